//! What a count has to be.

use super::harness::{Harness, numbered, range};
use crate::sensor::contract::Contract;

/// A count is the sum of a step's hits, up less down, clamped where it does not
/// fit; a hit is a rising edge within the scan.
pub(super) fn harness(contract: &Contract) -> Harness {
    let mut harness = Harness::new(
        contract,
        "counts",
        "One hit per rising edge of a detector's level, whatever the border between words, and only\n\
         within a scan. A count is the sum since the last dump of hits that the reference counts up less\n\
         those that it counts down: all that came before a dump, and nothing twice or lost at it. A count\n\
         that does not fit is clamped and flagged, never wrapped. (Dumps, the scan's clocks and the\n\
         reference are arbitrary here.)",
    );
    let detectors = contract.reference_codes.len() as u32;
    harness.empty("scan_controller");
    harness.empty("phase_stepper");
    inputs(contract, &mut harness);
    for d in 0..detectors {
        let channel = numbered("channel", d, detectors);
        let window = contract.lanes() + contract.parallel() - 1;
        harness.free(&format!("window_{d}"), window);
        harness.cut(
            &format!("window_{d}"),
            &format!("{channel}.stepper.o_window"),
            window,
        );
        edges(contract, d, &mut harness);
        if contract.total.is_some() {
            total(contract, d, &channel, &mut harness);
        }
        for q in 0..contract.parallel() {
            step(contract, d, q, &channel, &mut harness);
        }
    }
    harness
}

/// The scan's clocks and dumps, which the harness makes.
fn inputs(contract: &Contract, harness: &mut Harness) {
    let segments = contract.count_segments.count;
    harness.free("run", 1);
    harness.cut("run", "controller.o_run", 1);
    harness.free("may_dump", 1);
    let banks = contract.banks();
    harness.line(&format!("reg [{}:1] dumped;", segments + banks));
    // Segments of a total are settled one after another.
    let spaced = if segments > 1 {
        " & ~(|dumped[2:1])"
    } else {
        ""
    };
    harness.lines(&format!(
        "wire dump = may_dump & ~i_rst{spaced};\n\
         always @(posedge i_clk)\n    dumped <= i_rst ? 0 : {{dumped, dump}};"
    ));
    let dumps = match segments {
        1 => "dump".to_owned(),
        _ => format!("{{dumped[{}:1], dump}}", segments - 1),
    };
    harness.line(&format!("wire {}dumps = {dumps};", range(segments)));
    harness.cut("dumps", "controller.o_dump", segments);
}

/// Rising edges of a detector's samples.
fn edges(contract: &Contract, d: u32, harness: &mut Harness) {
    let lanes = contract.lanes();
    let samples = format!("i_samples[{}:{}]", (d + 1) * lanes - 1, d * lanes);
    let samples = if contract.reference_codes.len() == 1 {
        "i_samples".to_owned()
    } else {
        samples
    };
    let top = if lanes == 1 {
        String::new()
    } else {
        format!("[{}]", lanes - 1)
    };
    harness.lines(&format!(
        "\n// Detector {d}: samples that are high after a low one.\n\
         wire {0}level_{d} = {samples};\n\
         reg before_{d};\n\
         reg {0}hits_{d};\n\
         always @(posedge i_clk) begin\n    \
             before_{d} <= i_rst ? 0 : level_{d}{top};\n    \
             hits_{d} <= i_rst ? 0 : level_{d} & ~{{level_{d}, before_{d}}} & {{{lanes}{{run}}}};\n\
         end",
        range(lanes)
    ));
}

/// A running sum of `word`, which is there `delay` clocks later: what it grew by
/// up to a dump that comes `after` clocks later.
struct Sum<'a> {
    /// Suffix of its signals.
    name: &'a str,
    bits: u32,
    delay: u32,
    after: u32,
}

impl Sum<'_> {
    /// The sum since the last dump, beside the difference of totals that it is.
    fn declare(&self, harness: &mut Harness) {
        let Sum {
            name,
            bits,
            delay,
            after,
        } = self;
        let dump = match after {
            0 => "dump".to_owned(),
            after => format!("dumped[{after}]"),
        };
        harness.lines(&format!(
            "reg signed {0}sum_{name};\n\
             reg signed {0}total_{name};\n\
             reg signed {0}base_{name};\n\
             reg signed {0}exact_{name};\n\
             wire {0}growth_{name} = total_{name} - base_{name};\n\
             always @* assert (growth_{name} == sum_{name});",
            range(*bits)
        ));
        for clock in 1..=*delay {
            harness.line(&format!("reg signed [5:0] word_{name}_{clock};"));
        }
        harness.line("always @(posedge i_clk) begin");
        harness.line(&format!("    word_{name}_1 <= i_rst ? 0 : word_{name};"));
        for clock in 2..=*delay {
            let before = clock - 1;
            harness.line(&format!(
                "    word_{name}_{clock} <= i_rst ? 0 : word_{name}_{before};"
            ));
        }
        harness.lines(&format!(
            "    sum_{name} <= i_rst ? 0 : {dump} ? word_{name}_{delay} : sum_{name} + word_{name}_{delay};\n    \
             total_{name} <= i_rst ? 0 : total_{name} + word_{name}_{delay};\n    \
             base_{name} <= i_rst ? 0 : {dump} ? total_{name} : base_{name};\n    \
             exact_{name} <= i_rst ? 0 : {dump} ? sum_{name} : exact_{name};\n\
             end"
        ));
    }
}

/// Clocks from a hit in its register to the total: lane pairs and adder levels.
fn adder_clocks(contract: &Contract) -> u32 {
    Contract::clocks_to_dump(contract.lanes()) - 2
}

/// The count of step `q` of a group.
fn step(contract: &Contract, d: u32, q: u32, channel: &str, harness: &mut Harness) {
    let (lanes, parallel) = (contract.lanes(), contract.parallel());
    let name = format!("{d}_{q}");
    let bank = q / contract.bank_steps;
    let terms: Vec<String> = (0..lanes)
        .map(|lane| {
            let of = |signal: &str, width: u32, bit: u32| match width {
                1 => format!("{signal}_{d}"),
                _ => format!("{signal}_{d}[{bit}]"),
            };
            let hit = of("hits", lanes, lane);
            let up = of("window", lanes + parallel - 1, lane + parallel - 1 - q);
            format!("({hit} ? ({up} ? 6'sd1 : -6'sd1) : 6'sd0)")
        })
        .collect();
    harness.line(&format!(
        "wire signed [5:0] word_{name} = {};",
        terms.join(" + ")
    ));
    let sum = Sum {
        name: &name,
        bits: contract.exact_count_bits,
        delay: adder_clocks(contract) + bank,
        after: bank,
    };
    sum.declare(harness);
    let count = format!("{channel}.{}", numbered("o_count", q, parallel));
    harness.see(&format!("count_{name}"), &count, contract.count_bits);
    let settled = settled(contract, bank, harness, &name);
    if !contract.saturates() {
        harness.line(&format!(
            "always @* {settled}assert (count_{name} == exact_{name});"
        ));
        return;
    }
    let (bits, exact_bits) = (contract.count_bits, contract.exact_count_bits);
    let most = (1u128 << (bits - 1)) - 1;
    harness.lines(&format!(
        "wire signed [{0}:0] most_{name} = {most};\n\
         wire above_{name} = exact_{name} > most_{name};\n\
         wire below_{name} = exact_{name} < -most_{name} - 1;\n\
         wire {1}fits_{name} = above_{name} ? most_{name} : below_{name} ? -most_{name} - 1 : exact_{name};\n\
         always @* {settled}assert (count_{name} == fits_{name});",
        exact_bits - 1,
        range(bits)
    ));
    let clamped = format!("{channel}.{}", numbered("o_clamped", q, parallel));
    harness.see(&format!("clamped_{name}"), &clamped, 1);
    let total_too = match contract.total {
        Some(total) if total.saturates() && q == 0 => format!(" | above_{d}_total"),
        _ => String::new(),
    };
    harness.line(&format!(
        "always @* {settled}assert (clamped_{name} == (above_{name} | below_{name}{total_too}));"
    ));
}

/// All hits of a step, up and down together.
fn total(contract: &Contract, d: u32, channel: &str, harness: &mut Harness) {
    let Some(total) = contract.total else { return };
    let name = format!("{d}_total");
    let terms: Vec<String> = (0..contract.lanes())
        .map(|lane| match contract.lanes() {
            1 => format!("hits_{d}"),
            _ => format!("hits_{d}[{lane}]"),
        })
        .collect();
    let terms = terms.iter().map(|hit| format!("({hit} ? 6'sd1 : 6'sd0)"));
    let terms: Vec<String> = terms.collect();
    harness.line(&format!(
        "wire signed [5:0] word_{name} = {};",
        terms.join(" + ")
    ));
    let sum = Sum {
        name: &name,
        bits: total.exact_bits,
        delay: adder_clocks(contract),
        after: 0,
    };
    sum.declare(harness);
    harness.see(
        &format!("count_{name}"),
        &format!("{channel}.o_total"),
        total.bits,
    );
    let settled = settled(contract, 0, harness, &name);
    if !total.saturates() {
        harness.line(&format!(
            "always @* {settled}assert (count_{name} == exact_{name});"
        ));
        return;
    }
    let most = (1u128 << total.bits) - 1;
    harness.lines(&format!(
        "wire {0}hits_of_{name} = exact_{name};\n\
         wire above_{name} = hits_of_{name} > {most};\n\
         wire {1}fits_{name} = above_{name} ? {most} : hits_of_{name};\n\
         always @* {settled}assert (count_{name} == fits_{name});",
        range(total.exact_bits),
        range(total.bits)
    ));
}

/// Where a total has several segments, its count holds only once all of them
/// have settled: the condition under which it is looked at.
fn settled(contract: &Contract, bank: u32, harness: &mut Harness, name: &str) -> String {
    let clocks = contract.count_segments.clocks();
    if clocks == 1 {
        return String::new();
    }
    let after = match bank {
        0 => "dump".to_owned(),
        bank => format!("dumped[{bank}]"),
    };
    harness.lines(&format!(
        "reg [{clocks}:1] since_{name};\n\
         reg settled_{name};\n\
         always @(posedge i_clk) begin\n    \
             since_{name} <= i_rst ? 0 : {{since_{name}, {after}}};\n    \
             settled_{name} <= i_rst ? 0 : ~{after} & (settled_{name} | since_{name}[{}]);\n\
         end",
        clocks - 1
    ));
    format!("if (settled_{name}) ")
}

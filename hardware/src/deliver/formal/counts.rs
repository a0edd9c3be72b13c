//! What a count has to be.

use super::harness::{Harness, element, numbered, range};
use crate::sensor::interface::Interface;

/// A count is the sum of a step's hits, up less down, saturated where it does not
/// fit; a hit is a rising edge within the scan.
pub(super) fn harness(interface: &Interface) -> Harness {
    let mut harness = Harness::new(
        interface,
        "counts",
        "One hit per rising edge of a detector's level, whatever the border between words, and only\n\
         within a scan. A count is the sum since the last dump of hits that the reference counts up less\n\
         those that it counts down: all that came before a dump, and nothing twice or lost at it. A count\n\
         that does not fit is saturated and flagged, never wrapped. (Dumps, the scan's clocks and the\n\
         reference are arbitrary here.)",
    );
    let detectors = interface.reference_codes.len() as u32;
    harness.empty("scan_controller");
    harness.empty("phase_stepper");
    inputs(interface, &mut harness);
    for d in 0..detectors {
        let channel = numbered("channel", d, detectors);
        let window = interface.lanes() + interface.parallel() - 1;
        harness.free(&format!("window_{d}"), window);
        harness.cut(&format!("window_{d}"), &format!("{channel}.stepper.o_window"), window);
        edges(interface, d, &mut harness);
        if interface.total.is_some() {
            total(interface, d, &channel, &mut harness);
        }
        for q in 0..interface.parallel() {
            step(interface, d, q, &channel, &mut harness);
        }
    }
    harness
}

/// The scan's clocks and dumps, which the harness makes.
fn inputs(interface: &Interface, harness: &mut Harness) {
    let segments = interface.count_segments.count;
    harness.free("run", 1);
    harness.cut("run", "controller.o_run", 1);
    harness.free("may_dump", 1);
    let banks = interface.banks();
    harness.line(&format!("reg [{}:1] dumped;", segments + banks));
    // Segments of a total are settled one after another.
    let spaced = if segments > 1 { " & ~(|dumped[2:1])" } else { "" };
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
    harness.reaches("dumped[1]");
}

/// Rising edges of a detector's samples.
fn edges(interface: &Interface, d: u32, harness: &mut Harness) {
    let lanes = interface.lanes();
    let samples = format!("i_samples[{}:{}]", (d + 1) * lanes - 1, d * lanes);
    let samples =
        if interface.reference_codes.len() == 1 { "i_samples".to_owned() } else { samples };
    let top = if lanes == 1 { String::new() } else { format!("[{}]", lanes - 1) };
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
        let Sum { name, bits, delay, after } = self;
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
            harness.line(&format!("    word_{name}_{clock} <= i_rst ? 0 : word_{name}_{before};"));
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
fn adder_clocks(interface: &Interface) -> u32 {
    Interface::clocks_to_dump(interface.lanes()) - 2
}

/// The count of step `q` of a group.
fn step(interface: &Interface, d: u32, q: u32, channel: &str, harness: &mut Harness) {
    let (lanes, parallel) = (interface.lanes(), interface.parallel());
    let name = format!("{d}_{q}");
    let bank = q / interface.bank_steps;
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
    harness.line(&format!("wire signed [5:0] word_{name} = {};", terms.join(" + ")));
    let sum = Sum {
        name: &name,
        bits: interface.exact_count_bits,
        delay: adder_clocks(interface) + bank,
        after: bank,
    };
    sum.declare(harness);
    let count = format!("{channel}.{}", element("o_count", q, parallel, interface.count_bits));
    harness.see(&format!("count_{name}"), &count, interface.count_bits);
    let settled = settled(interface, bank, harness, &name);
    if !interface.saturates() {
        harness.line(&format!("always @* {settled}assert (count_{name} == exact_{name});"));
        return;
    }
    let (bits, exact_bits) = (interface.count_bits, interface.exact_count_bits);
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
    let saturated = format!("{channel}.{}", element("o_clamped", q, parallel, 1));
    harness.see(&format!("clamped_{name}"), &saturated, 1);
    let total_too = match interface.total {
        Some(total) if total.saturates() && q == 0 => format!(" | above_{d}_total"),
        _ => String::new(),
    };
    harness.line(&format!(
        "always @* {settled}assert (clamped_{name} == (above_{name} | below_{name}{total_too}));"
    ));
}

/// All hits of a step, up and down together.
fn total(interface: &Interface, d: u32, channel: &str, harness: &mut Harness) {
    let Some(total) = interface.total else { return };
    let name = format!("{d}_total");
    let terms: Vec<String> = (0..interface.lanes())
        .map(|lane| match interface.lanes() {
            1 => format!("hits_{d}"),
            _ => format!("hits_{d}[{lane}]"),
        })
        .collect();
    let terms = terms.iter().map(|hit| format!("({hit} ? 6'sd1 : 6'sd0)"));
    let terms: Vec<String> = terms.collect();
    harness.line(&format!("wire signed [5:0] word_{name} = {};", terms.join(" + ")));
    let sum = Sum { name: &name, bits: total.exact_bits, delay: adder_clocks(interface), after: 0 };
    sum.declare(harness);
    harness.see(&format!("count_{name}"), &format!("{channel}.o_total"), total.bits);
    let settled = settled(interface, 0, harness, &name);
    if !total.saturates() {
        harness.line(&format!("always @* {settled}assert (count_{name} == exact_{name});"));
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
fn settled(interface: &Interface, bank: u32, harness: &mut Harness, name: &str) -> String {
    let clocks = interface.count_segments.clocks();
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

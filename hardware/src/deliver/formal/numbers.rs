//! The header of the properties: this design's numbers and codes, for the proofs' files.

use std::fmt::Write as _;
use std::sync::Arc;

use crate::code::{Code, Generator, Lfsr};
use crate::deliver::design::EmittedDesign;
use crate::rtl::blocks::SequenceCounter;
use crate::scene::{Combination, Polarity};
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::{Correlator, Counting, Interface};
use crate::sensor::peak::PeakPlan;
use crate::sensor::registers::RegisterPlan;

/// Macros with a design's numbers, and modules with its codes.
pub(super) fn header(design: &EmittedDesign) -> String {
    let interface = design.interface();
    let mut text = String::new();
    let mut define = |name: &str, value: String| {
        let _ = writeln!(text, "`define {name} {value}");
    };
    define("TOP", design.top());
    if let Some(plan) = &interface.registers {
        define("SETTINGS_BITS", settings_bits(plan).to_string());
        define("SEED_BITS", plan.seed_bits().max(1).to_string());
    }
    of_ports(interface, &mut define);
    match &interface.counting {
        Counting::Histogram(histogram) => of_histogram(histogram, &mut define),
        Counting::Correlator(correlator) => of_correlators(interface, correlator, &mut define),
    }
    let mut modules = String::new();
    let of_laser = |code| set_instance(interface, code).unwrap_or_else(|| instance(code, 0));
    let is_set = interface.registers.is_some();
    let sources = interface.source_codes.iter().map(of_laser);
    modules += &code_module("spec_code_of_source", is_set, sources);
    let reference = of_laser(&interface.reference_codes[0]);
    modules += &code_module("spec_code_of_reference", is_set, [reference].into_iter());
    if interface.correlator().is_some() {
        let detectors = interface.reference_codes.iter();
        let of_detectors = detectors
            .map(|code| instance(code, Delay::of(interface).chip(code, present(interface) + 1)));
        modules += &code_module("spec_code_of_detector", false, of_detectors);
    }
    format!("{text}\n{modules}")
}

/// Bits of all settings that a scan goes by.
pub(super) fn settings_bits(plan: &RegisterPlan) -> u32 {
    plan.chips_bits + plan.groups_bits + plan.delay_bits + plan.lanes() + plan.seed_bits()
}

/// A number of the header, which Verilog takes for one of 32 bits if nothing else is said.
fn number(value: u64) -> String {
    match i32::try_from(value) {
        Ok(_) => value.to_string(),
        Err(_) => format!("64'd{value}"),
    }
}

fn flag(value: bool) -> String {
    format!("1'b{}", u8::from(value))
}

fn of_ports(interface: &Interface, define: &mut dyn FnMut(&str, String)) {
    let total = interface.total();
    for (name, value) in [
        ("SOURCES", interface.source_codes.len() as u32),
        ("DETECTORS", interface.reference_codes.len() as u32),
        ("CELLS", interface.input_cells.count),
        ("COINCIDENCE", interface.input_cells.coincidence),
        ("SAMPLES", interface.lanes()),
        ("DATA_BITS", interface.tdata_bits),
        ("COUNT_BITS", interface.count_bits()),
        ("TOTAL_BITS", total.map_or(1, |total| total.bits)),
        ("TOTAL_EXACT_BITS", total.map_or(1, |total| total.exact_bits)),
        ("PEAK_STEP_BITS", interface.peak().map_or(1, |peak| peak.step_bits)),
    ] {
        define(name, value.to_string());
    }
    for (name, value) in [
        ("INVERTED", interface.polarity == Polarity::Low),
        ("ODD_CELLS", interface.input_cells.combination == Combination::Xor),
        ("ADDED_CELLS", interface.input_cells.combination == Combination::Adder),
        ("SATURATES", interface.saturates()),
        ("SENDS_TOTAL", total.is_some()),
        ("FINDS_PEAK", interface.peak().is_some()),
        ("REALIGNS", interface.realigns() && interface.correlator().is_some()),
    ] {
        define(name, flag(value));
    }
}

fn of_histogram(plan: &HistogramPlan, define: &mut dyn FnMut(&str, String)) {
    define("ROWS", number(plan.rows));
    define("ROW_BITS", row_bits(plan).to_string());
    define("PERIODS", number(plan.periods));
    define("TAKES_TURNS", flag(plan.takes_turns()));
}

/// Bits of a row's number.
pub(super) fn row_bits(plan: &HistogramPlan) -> u32 {
    (u64::BITS - (plan.rows - 1).leading_zeros()).max(1)
}

fn of_correlators(
    interface: &Interface,
    correlator: &Correlator,
    define: &mut dyn FnMut(&str, String),
) {
    let (chips, groups) = (interface.timing.scan.integration_chips, interface.groups());
    let delay = Delay::of(interface);
    for (name, value) in [
        ("PARALLEL", interface.parallel()),
        ("LAST_STEPS", interface.last_group_steps() as u32),
        (
            "RESULTS",
            correlator.queued(interface.reference_codes.len() as u32 * interface.parallel()),
        ),
        ("EXACT_BITS", correlator.exact_count_bits),
        // A word's signed count.
        ("WORD_BITS", correlator.pairs.ilog2() + 2),
        ("SIGNED_BITS", correlator.signed_data_bits()),
        ("SEGMENTS", correlator.count_segments.count),
        ("SETTLING_CLOCKS", correlator.count_segments.clocks()),
        ("BANKS", correlator.banks),
        ("BANK_STEPS", correlator.bank_steps),
        ("CLOCKS_TO_DUMP", correlator.clocks_to_dump() - correlator.dumps_early()),
        ("CLOCKS_TO_COUNTED", correlator.clocks_to_counted()),
        ("COUNTING_CLOCKS", correlator.clocks_of_counting()),
        ("SCAN_CLOCKS", scan_clocks(correlator)),
        // From a hit in its register to the total: lane pairs and adder levels.
        ("ADDER_CLOCKS", correlator.clocks_to_dump() - 2),
        ("FIRST_SAMPLE", delay.first),
        ("KEPT_CHIPS", delay.kept_chips()),
    ] {
        define(name, value.to_string());
    }
    let first_chips = interface.reference_codes.iter().rev();
    let first_chips = first_chips.map(|code| delay.first_chips(code, present(interface)));
    define("FIRST_CHIPS", format!("{{{}}}", first_chips.collect::<Vec<_>>().join(", ")));
    define("CHIPS", number(chips));
    define("GROUPS", number(groups));
    // The counters are LFSRs, which stop at the state after so many steps.
    let counter =
        |least: u64, count: u64| (count > least).then(|| SequenceCounter::new(count - least));
    let chip_counter = counter(2, chips);
    let reset = chip_counter.as_ref().map(|counter| match interface.realigns() {
        true => counter.state(0),
        false => counter.state_before_the_first(),
    });
    of_counter("CHIP_COUNT", chip_counter.as_ref(), chips.saturating_sub(3), define);
    define("CHIP_COUNT_RESET", constant(chip_counter.as_ref(), reset.unwrap_or_default()));
    of_counter("STEP_COUNT", counter(1, groups).as_ref(), groups.saturating_sub(2), define);
    if let Some(peak) = &correlator.peak {
        of_peak(peak, define);
    }
}

/// An LFSR that counts: its bits, taps, first state and the one after `count` steps.
fn of_counter(
    name: &str,
    counter: Option<&SequenceCounter>,
    count: u64,
    define: &mut dyn FnMut(&str, String),
) {
    let value = |of: &dyn Fn(&SequenceCounter) -> u128| constant(counter, counter.map_or(0, of));
    define(&format!("{name}_BITS"), counter.map_or(1, SequenceCounter::width).to_string());
    define(&format!("{name}_TAPS"), value(&|counter| counter.taps()));
    define(&format!("{name}_FIRST"), value(&|counter| counter.state(0)));
    define(&format!("{name}_END"), value(&|counter| counter.state(count)));
}

fn constant(counter: Option<&SequenceCounter>, value: u128) -> String {
    format!("{}'h{value:x}", counter.map_or(1, SequenceCounter::width))
}

/// Clocks of the induction of `scan`: as many as an end takes on its way to the stream, and what
/// recognises it before.
pub(super) fn scan_clocks(correlator: &Correlator) -> u32 {
    correlator.clocks_to_counted() + 4
}

fn of_peak(peak: &PeakPlan, define: &mut dyn FnMut(&str, String)) {
    let last = (1u64 << peak.step_bits) - 1;
    define("FIRST_STEP", number(peak.first_step));
    define("WRAPPING_STEP", number(peak.wraps_after.unwrap_or(last)));
    define("PEAK_TURN_CLOCKS", peak.clocks_per_count().to_string());
    define("PEAK_COMPARED_CLOCKS", peak.clocks_to_compare().to_string());
    define("PEAK_CHOOSING_CLOCKS", peak.choosing_clocks.to_string());
    define("PEAK_GROUP_CLOCKS", number(peak.least_chips));
}

/// How the delay of the reference stands and grows.
struct Delay {
    /// Samples per chip.
    lanes: u32,
    parallel: u32,
    /// The first step's delay: whole chips, and samples beside them.
    whole: u64,
    first: u32,
}

impl Delay {
    fn of(interface: &Interface) -> Delay {
        let (step, lanes) = (interface.timing.scan.first_step, interface.lanes());
        Delay {
            lanes,
            parallel: interface.parallel(),
            whole: step / u64::from(lanes),
            first: (step % u64::from(lanes)) as u32,
        }
    }

    /// Chips that the reference keeps: those that a group's samples need, and those that come again
    /// when the delay grows.
    fn kept_chips(&self) -> u32 {
        let back = self.parallel - 1;
        let grows = !self.parallel.is_multiple_of(self.lanes);
        let oldest = (0..self.lanes + back).map(|sample| {
            let chips = back.saturating_sub(sample).div_ceil(self.lanes);
            let place = sample + chips * self.lanes - back;
            chips + u32::from(if grows { place + 1 < self.lanes } else { place < self.first })
        });
        oldest.max().unwrap_or(0) + self.parallel.div_ceil(self.lanes)
    }

    /// The chip of a code that is the present one in a cycle after reset.
    fn chip(&self, code: &Code, cycle: i128) -> u64 {
        (cycle - i128::from(self.whole)).rem_euclid(i128::from(code.len())) as u64
    }

    /// The chips that are kept when `cycle` is the present one, it in bit 0.
    fn first_chips(&self, code: &Code, cycle: i128) -> String {
        let kept = self.kept_chips();
        let chip = |back: u32| code.chips[self.chip(code, cycle - i128::from(back)) as usize];
        let chips: String = (0..kept).rev().map(|back| chip(back).to_string()).collect();
        format!("{kept}'b{chips}")
    }
}

/// The cycle in which reset leaves the reference: a clock before a scan's first, or, where a scan
/// waits for its start, in it.
fn present(interface: &Interface) -> i128 {
    if interface.realigns() { 0 } else { -1 }
}

/// A module that is one of several codes, by its parameter; of those that a host sets if `is_set`.
fn code_module(name: &str, is_set: bool, instances: impl Iterator<Item = String>) -> String {
    let mut text = format!(
        "module {name} #(\n    parameter NUMBER = 0\n) (\n    input wire i_clk,\n    \
         input wire i_rst,\n    input wire advance,\n    input wire load,\n    {}\
         output wire chip,\n    output wire epoch\n);\n    generate\n        case (NUMBER)\n",
        if is_set { "input wire [`SEED_BITS-1:0] seed,\n    " } else { "" }
    );
    for (number, instance) in instances.enumerate() {
        let _ = writeln!(text, "            {number}: {instance};");
    }
    text + "        endcase\n    endgenerate\nendmodule\n\n"
}

/// A code of which a host sets something, with its part of all that the host sets; none of another.
fn set_instance(interface: &Interface, code: &Arc<Code>) -> Option<String> {
    let plan = interface.registers.as_ref()?;
    let number = plan.seed_number(code, &interface.source_codes)?;
    let (seed, from) = (plan.seeds[number], plan.first_seed_bit(number));
    let (Generator::MSequence(u) | Generator::Gold { u, .. }) = &code.generator else {
        return None;
    };
    let own = match &code.generator {
        Generator::Gold { v, .. } if !seed.has_taps() => v.taps(),
        _ => 0,
    };
    Some(format!(
        "spec_set_code #(.DEGREE({degree}), {first}, .TAPS_V({degree}'h{own:x}), .SUMS({sums}), .SEED_BITS({bits}){depth}) \
         is (.seed(seed[{last}:{from}]), .*)",
        degree = seed.degree,
        first = lfsr("U", u, 0),
        sums = flag(matches!(code.generator, Generator::Gold { .. })),
        bits = seed.bits,
        depth = interleaved(code.interleave, 0),
        last = from + seed.bits - 1,
    ))
}

/// The parameters of interleaving, behind others.
fn interleaved(depth: u32, first_repetition: u64) -> String {
    match depth {
        0 => String::new(),
        _ => format!(", .DEPTH({depth}), .FIRST_REPETITION({first_repetition})"),
    }
}

/// A code that starts with its chip `start`.
fn instance(code: &Code, start: u64) -> String {
    let depth = code.interleave;
    let (start, repetition) = (start >> depth, start & ((1 << depth) - 1));
    let mut text = match &code.generator {
        Generator::MSequence(u) => lfsr("U", u, start),
        Generator::Gold { u, v } => lfsr("U", u, start) + ", " + &lfsr("V", v, start),
        Generator::Square => table(&[1, 0], start),
        Generator::Chips(chips) => table(chips, start),
    };
    if let Generator::MSequence(u) | Generator::Gold { u, .. } = &code.generator {
        text = format!(".DEGREE({}), {text}", u.degree);
    }
    format!("spec_code #({text}{}) is (.*)", interleaved(depth, repetition))
}

/// An LFSR whose bit i holds c[t + i]: the bits that give c[t + n], and its state after `start`
/// chips.
fn lfsr(name: &str, lfsr: &Lfsr, start: u64) -> String {
    let degree = lfsr.degree;
    let taps = lfsr.taps();
    let chips = lfsr.advanced(start).seed;
    let first = chips.iter().rev().fold(0, |state, &chip| state << 1 | u128::from(chip));
    format!(".TAPS_{name}({degree}'h{taps:x}), .FIRST_{name}({degree}'h{first:x})")
}

fn table(chips: &[u8], start: u64) -> String {
    let bits: String = chips.iter().rev().map(|chip| chip.to_string()).collect();
    let count = chips.len();
    format!(".CHIPS({count}), .TABLE({count}'b{bits}), .FIRST({start})")
}

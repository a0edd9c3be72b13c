//! Parts of the hardware (the blocks of `sensor_top`).

use super::{Part, kept, labelled, left_out};
use crate::code::{Code, Generator};
use crate::scene::SourceIndex;
use crate::sensor::Sensor;
use crate::sensor::block_ram::block_ram;
use crate::sensor::cells::{Cells, Gates};
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::{Correlator, Counting, Interface};
use crate::sensor::rows::RowPlan;

pub fn parts(sensor: &Sensor) -> Vec<Part> {
    let interface = sensor.interface();
    let mut parts: Vec<Part> = SourceIndex::of(&sensor.scene().sources)
        .flat_map(|source| generator_parts(sensor, source.0))
        .collect();
    parts.extend(cell_combiner(&interface.input_cells));
    match &interface.counting {
        Counting::Correlator(correlator) => parts.extend(
            [
                phase_stepper(sensor),
                lane_choice(sensor),
                edge_detector(sensor),
                updown_correlator(sensor, correlator),
                parallel_correlators(sensor),
                count_segments(correlator),
                saturation(correlator),
                total_counts(sensor, correlator),
                scan_controller(sensor),
                registers(interface),
                scan_realignment(sensor, interface),
                peak_detector(sensor, correlator),
                result_stream(interface),
            ]
            .into_iter()
            .chain(correlator.rows.map(|rows| row_sums(&rows))),
        ),
        Counting::Histogram(histogram) => parts.extend(histogram_parts(sensor, histogram)),
    }
    parts
}

/// The parts of hardware that keeps a histogram.
fn histogram_parts(sensor: &Sensor, plan: &HistogramPlan) -> Vec<Part> {
    let by_host = "all counts of a histogram follow from it on the host";
    vec![
        edge_detector(sensor),
        histogram_memory(sensor, plan),
        match plan.adders() {
            1 => left_out(
                "further_adders",
                format!(
                    "the dead time lets one hit into {} samples: one adder serves them",
                    plan.row_bins
                ),
            ),
            adders => kept(
                "further_adders",
                format!(
                    "{adders} adders, one for {} neighbouring samples, of which one can be a hit",
                    plan.adder_samples
                ),
            ),
        },
        bin_saturation(plan),
        kept("result_stream", format!("rows of {} bins, a row a clock", plan.row_bins)),
        left_out("phase_stepper", "no reference is made: the host correlates"),
        left_out("updown_correlator", by_host),
        left_out("peak_detector", by_host),
    ]
}

/// The memories of a histogram, and the block RAM that they take.
fn histogram_memory(sensor: &Sensor, plan: &HistogramPlan) -> Part {
    let detectors = sensor.scene().detectors.len();
    let ram = block_ram(sensor.scene().hardware.target);
    let memories = match plan.takes_turns() {
        true => format!(
            "two histograms of {} bins of {} bits for each detector, of which one counts \
             while the other is read",
            plan.bins(),
            plan.bin_bits
        ),
        false => format!(
            "a histogram of {} bins of {} bits, read while the next one's first code \
             period is counted",
            plan.bins(),
            plan.bin_bits
        ),
    };
    kept(
        "histogram_memory",
        format!(
            "{memories}: {} of the target's {} {}",
            ram.blocks_of_histograms(plan, detectors),
            ram.blocks,
            ram.name
        ),
    )
}

/// Whether bins may hold fewer bits than any stimulus fills.
fn bin_saturation(plan: &HistogramPlan) -> Part {
    match plan.saturates() {
        true => kept(
            "saturation",
            format!(
                "counter_width = {} is narrower than the {} bits that no stimulus overflows: bins \
                 are saturated, and flagged at o_saturated",
                plan.bin_bits, plan.exact_bits
            ),
        ),
        false => left_out(
            "saturation",
            format!(
                "{} code periods bring at most as many hits into a bin, which {} bits hold",
                plan.periods, plan.exact_bits
            ),
        ),
    }
}

fn generator_parts(sensor: &Sensor, index: usize) -> Vec<Part> {
    let source = &sensor.scene().sources[index];
    let code = &source.code;
    let name = |part| labelled(part, &source.name, sensor.scene().sources.len() > 1);
    let same = sensor.scene().sources[..index].iter().find(|s| s.code == *code);
    if let Some(same) = same {
        let reason = format!("the same code as \"{}\": one generator drives both", same.name);
        return vec![left_out(name("code_generator"), reason)];
    }
    let second = name("second_lfsr");
    let generator = name("code_generator");
    let (generator, second) = match &code.generator {
        Generator::Gold { u, .. } => (
            kept(generator, format!("an LFSR of degree {} makes the first m-sequence", u.degree)),
            kept(second, "a Gold code is the XOR of two m-sequences"),
        ),
        Generator::MSequence(lfsr) => (
            kept(generator, format!("one LFSR of degree {}", lfsr.degree)),
            left_out(second, "an m-sequence needs one LFSR only"),
        ),
        Generator::Square => (
            kept(generator, "a square wave is one flip-flop that toggles"),
            left_out(second, "a square wave needs no LFSR"),
        ),
        Generator::Chips(chips) => (
            kept(generator, format!("the {} given chips come from a table", chips.len())),
            left_out(second, "given chips need no LFSR"),
        ),
    };
    vec![generator, second, interleaver(code, name("interleaver"))]
}

fn interleaver(code: &Code, part: String) -> Part {
    match code.interleave {
        0 => left_out(part, "the code is not interleaved (nu = 0)"),
        nu => kept(
            part,
            format!(
                "nu = {nu}: each chip of the generator lasts {} clocks, inverted in every other",
                1u64 << nu
            ),
        ),
    }
}

fn phase_stepper(sensor: &Sensor) -> Part {
    match sensor.clock().samples_per_chip {
        1 => kept("phase_stepper", "holds the reference for one chip after each phase step"),
        samples => {
            kept("phase_stepper", format!("delays the reference by {samples} phase steps per chip"))
        }
    }
}

fn lane_choice(sensor: &Sensor) -> Part {
    match sensor.clock().samples_per_chip {
        1 => left_out(
            "lane_choice",
            "S = 1: every phase step is a whole chip, and all lanes are one",
        ),
        samples => kept(
            "lane_choice",
            format!("delays the reference by parts of a chip, one of {samples} samples at a time"),
        ),
    }
}

fn edge_detector(sensor: &Sensor) -> Part {
    let detectors = sensor.scene().detectors.len();
    kept(
        "edge_detector",
        format!(
            "finds rising edges in {} samples per clock of {detectors} detector{}",
            sensor.clock().samples_per_chip,
            if detectors == 1 { "" } else { "s" }
        ),
    )
}

/// What combines cells that have an input each.
fn cell_combiner(cells: &Cells) -> Option<Part> {
    let logic = match cells.gates()? {
        Gates::Xor => "an XOR".to_owned(),
        Gates::Or => "an OR".to_owned(),
        Gates::And => "an AND".to_owned(),
        Gates::AtLeast(least) => format!("adders and a comparison (at least {least})"),
    };
    let about =
        format!("{logic} of the samples of {} cells, which have an input each", cells.count);
    Some(kept("cell_combiner", about))
}

fn updown_correlator(sensor: &Sensor, correlator: &Correlator) -> Part {
    kept(
        "updown_correlator",
        format!(
            "{} bits hold any count of {} chips with at most {} edges each",
            correlator.exact_count_bits,
            sensor.timing().scan.integration_chips,
            correlator.pairs
        ),
    )
}

fn parallel_correlators(sensor: &Sensor) -> Part {
    match sensor.timing().parallel {
        1 => left_out(
            "parallel_correlators",
            "parallel = 1: phase steps are correlated one after another",
        ),
        parallel => kept(
            "parallel_correlators",
            format!("{parallel} phase steps are correlated at once, on the same light"),
        ),
    }
}

fn count_segments(correlator: &Correlator) -> Part {
    let (bits, segments) = (correlator.exact_count_bits, correlator.count_segments.count);
    match segments {
        _ if correlator.rows.is_some() => left_out(
            "count_segments",
            format!("all detectors share the carry chain of {bits} bits that sums their windows"),
        ),
        1 => left_out(
            "count_segments",
            format!("one carry chain holds {bits} bits at full clock; saves pipeline stages"),
        ),
        _ => kept(
            "count_segments",
            format!(
                "the carry chain of {bits} bits is cut into {segments}, each a clock behind the \
                 one below, so that the clock does not fall with the width"
            ),
        ),
    }
}

fn saturation(correlator: &Correlator) -> Part {
    let (count, exact) = (correlator.count_bits, correlator.exact_count_bits);
    if correlator.saturates() {
        kept(
            "saturation",
            format!(
                "counter_width = {count} is narrower than the {exact} bits that no stimulus \
                 overflows: counts are saturated, and flagged at o_saturated"
            ),
        )
    } else {
        left_out(
            "saturation",
            format!("no stimulus can overflow {exact} bits; saves a pipeline stage and a port"),
        )
    }
}

fn total_counts(sensor: &Sensor, correlator: &Correlator) -> Part {
    const PART: &str = "total_counts";
    let given = sensor.scene().hardware.total_counts.is_some();
    let estimator = sensor.scene().estimator;
    match correlator.total {
        Some(total) => kept(
            PART,
            format!(
                "{}: the hits of each phase step in {} bits, above its signed count",
                match given {
                    true => "total_counts = true".to_owned(),
                    false => format!("the estimator \"{estimator}\" fits them too"),
                },
                total.bits
            ),
        ),
        None => left_out(
            PART,
            match given {
                true => "total_counts = false: signed counts alone are sent".to_owned(),
                false => format!("the estimator \"{estimator}\" uses the signed counts alone"),
            },
        ),
    }
}

fn scan_controller(sensor: &Sensor) -> Part {
    kept(
        "scan_controller",
        format!(
            "walks {} phase steps of {} chips each",
            sensor.timing().scan.steps,
            sensor.timing().scan.integration_chips
        ),
    )
}

fn registers(interface: &Interface) -> Part {
    const PART: &str = "registers";
    match &interface.registers {
        None => left_out(PART, "the scan and the codes are those of the scene"),
        Some(plan) => kept(
            PART,
            format!(
                "registers = \"axi4-lite\": a host starts and stops scans, and sets their chips, groups and first \
                 step{}{}",
                match plan.seeds.len() {
                    0 => String::new(),
                    seeds => format!(
                        ", and the {}",
                        match (seeds, plan.sets_taps()) {
                            (1, false) => "seed of the code".to_owned(),
                            (1, true) => "seed and taps of the code".to_owned(),
                            (_, false) => format!("seeds of {seeds} codes"),
                            (_, true) => format!("seeds and taps of {seeds} codes"),
                        }
                    ),
                },
                match &plan.track {
                    None => String::new(),
                    Some(track) => format!(
                        "; a window of {} phase steps follows the peak that a scan has found",
                        track.window_steps()
                    ),
                }
            ),
        ),
    }
}

fn scan_realignment(sensor: &Sensor, interface: &Interface) -> Part {
    if interface.registers.is_some() {
        return left_out(
            "scan_realignment",
            "each scan is prepared as the registers say, and begins with a code period",
        );
    }
    let scan = &sensor.timing().scan;
    let (steps, period) = (scan.steps, scan.steps_per_period);
    if scan.is_full() && interface.realigns() {
        return kept(
            "scan_realignment",
            format!(
                "{steps} phase steps are not a whole number of groups of {}, so a scan does not end \
                 where it began: the next one waits for the code's first chip and loads the \
                 reference anew",
                interface.parallel()
            ),
        );
    }
    if interface.realigns() {
        kept(
            "scan_realignment",
            format!(
                "a scan of {steps} of {period} phase steps does not end where it began: \
                 the next one waits for the code's first chip and loads the reference anew"
            ),
        )
    } else {
        left_out(
            "scan_realignment",
            format!("a scan of all {period} phase steps ends where it began"),
        )
    }
}

fn peak_detector(sensor: &Sensor, correlator: &Correlator) -> Part {
    match correlator.peak {
        Some(peak) => kept(
            "peak_detector",
            format!(
                "peak_detector = true: the largest of a scan's {} counts and its phase step, in \
                 {} and {} bits for each detector, at ports of their own",
                sensor.timing().scan.steps,
                peak.count_bits,
                peak.step_bits
            ),
        ),
        None => left_out(
            "peak_detector",
            format!(
                "the host receives all {} counts and finds their maximum",
                sensor.timing().scan.steps
            ),
        ),
    }
}

fn row_sums(rows: &RowPlan) -> Part {
    kept(
        "row_sums",
        format!(
            "readout = \"rows\": {} detectors count windows of {} chips in {} bits, and share the \
             memory in which these are summed",
            rows.detectors,
            rows.window_chips.min(rows.first_chips),
            rows.piece_bits
        ),
    )
}

fn result_stream(interface: &Interface) -> Part {
    kept(
        "result_stream",
        format!("counts leave as an AXI4-Stream of {} bits", interface.tdata_bits),
    )
}

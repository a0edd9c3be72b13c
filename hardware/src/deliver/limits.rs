//! What the emitted hardware has a place for.

use super::error::HdlError;
use crate::code::{Code, Generator, Lfsr, MOST_HARDWARE_DEGREE};
use crate::sensor::Sensor;
use crate::sensor::block_ram::block_ram;
use crate::sensor::histogram::{HistogramPlan, LEAST_ROWS, MOST_ROW_BITS};
use crate::sensor::interface::{Correlator, Counting, Interface, longest_carry_chain};
use crate::sensor::peak::PeakPlan;
use crate::sensor::registers::RegisterPlan;

/// Longest integration, as in a scene file.
const MOST_INTEGRATION_CHIPS: u64 = 1 << 60;

/// # Errors
/// What of a scene the hardware that is emitted has no place for.
pub(super) fn check_limits(sensor: &Sensor, interface: &Interface) -> Result<(), HdlError> {
    let periods = interface.reference_codes.iter().map(|code| code.len());
    if periods.clone().any(|period| period != interface.reference_codes[0].len()) {
        return Err(HdlError::CodeLengths { found: periods.collect() });
    }
    match &interface.counting {
        Counting::Correlator(correlator) => check_correlator(sensor, interface, correlator)?,
        Counting::Histogram(plan) => check_histogram(sensor, plan)?,
    }
    if interface.timing.scan.integration_chips > MOST_INTEGRATION_CHIPS {
        return Err(HdlError::Limit {
            what: "the integration time in chips".into(),
            found: interface.timing.scan.integration_chips,
            limit: "at most 2^60".into(),
        });
    }
    within("samples per chip", interface.lanes(), "1, 2, 4, 8 or 16", |s| {
        s.is_power_of_two() && s <= 16
    })?;
    within(
        "the width of a count that cannot overflow",
        interface.exact_count_bits(),
        "at most 64 bits; integrate over fewer chips",
        |bits| bits <= 64,
    )?;
    for source in &sensor.scene().sources {
        check_code(&source.name, &source.code)?;
    }
    Ok(())
}

/// What signed counts and their steps are like.
fn check_correlator(
    sensor: &Sensor,
    interface: &Interface,
    correlator: &Correlator,
) -> Result<(), HdlError> {
    check_parallel(interface)?;
    if let Some(peak) = &correlator.peak {
        check_peak(interface, peak)?;
    }
    if let Some(plan) = &interface.registers {
        check_registers(sensor, interface, plan)?;
    }
    within("counter_width", correlator.count_bits, "2 to 64 bits", |bits| bits >= 2)
}

/// What a host's settings, and the counters behind them, can hold.
fn check_registers(
    sensor: &Sensor,
    interface: &Interface,
    plan: &RegisterPlan,
) -> Result<(), HdlError> {
    let longest = longest_carry_chain(sensor.scene().hardware.target);
    let chips = interface.timing.scan.integration_chips;
    let most = (1u64 << longest) - 1;
    if chips < plan.least_chips || chips > most {
        return limit(
            "the integration time of hardware with registers, in chips",
            chips,
            format!("{} to {most}, which its counters are for", plan.least_chips),
        );
    }
    if interface.groups() >> plan.groups_bits != 0 {
        return limit(
            "the groups of phase steps of hardware with registers",
            interface.groups(),
            format!("at most {}; scan fewer steps", (1u64 << plan.groups_bits) - 1),
        );
    }
    if let Some(track) = &plan.track
        && track.sum_bits() > longest
    {
        return limit(
            "the bits of a window's sum, of hardware that follows a target,",
            track.sum_bits().into(),
            format!(
                "at most {longest}; write a smaller counter_width, or integrate over fewer chips"
            ),
        );
    }
    // The reference's chips have to be there before a scan, however long it waits.
    let kept = 4 + 2 * u64::from(interface.parallel().div_ceil(interface.lanes()));
    if plan.period_chips < kept || plan.period_chips > most {
        return limit(
            "the code period of hardware with registers, in chips",
            plan.period_chips,
            format!("{kept} to {most}"),
        );
    }
    within(
        "codes with a seed of their own behind registers",
        plan.seeds.len() as u32,
        "at most 20",
        |seeds| seeds <= 20,
    )
}

/// Steps at once, and chips for the reference to go back.
fn check_parallel(interface: &Interface) -> Result<(), HdlError> {
    within("parallel", interface.parallel(), "1 to 64", |parallel| (1..=64).contains(&parallel))?;
    let most_held = u64::from(interface.parallel().div_ceil(interface.lanes()));
    if interface.timing.scan.integration_chips < most_held {
        return Err(HdlError::ShortStep {
            chips: interface.timing.scan.integration_chips,
            parallel: interface.parallel(),
            lanes: interface.lanes(),
            needed: most_held,
        });
    }
    Ok(())
}

/// What is beyond a limit.
fn limit(what: &str, found: u64, limit: String) -> Result<(), HdlError> {
    Err(HdlError::Limit { what: what.to_owned(), found, limit: limit.into() })
}

/// What the memories of a histogram, and the stream of its rows, can hold.
fn check_histogram(sensor: &Sensor, plan: &HistogramPlan) -> Result<(), HdlError> {
    if plan.rows < LEAST_ROWS {
        return limit(
            "the code period of a histogram in chips",
            plan.rows,
            format!(
                "at least {LEAST_ROWS}: a bin is written six clocks after it is read; use a longer code"
            ),
        );
    }
    if plan.row_data_bits() > MOST_ROW_BITS {
        return limit(
            "a row of the histogram, the bins of a chip in whole bytes, in bits",
            plan.row_data_bits().into(),
            format!(
                "at most {MOST_ROW_BITS}; use fewer samples per chip, a narrower counter_width, or a \
                 shorter integration"
            ),
        );
    }
    check_turns(plan, sensor.scene().detectors.len())?;
    check_block_ram(sensor, plan)
}

/// Whether rows can leave while the next histogram counts.
fn check_turns(plan: &HistogramPlan, detectors: usize) -> Result<(), HdlError> {
    if !plan.takes_turns() && detectors > 1 {
        return limit(
            "detectors of a histogram with buffers = 1",
            detectors as u64,
            "one, since its rows leave in the clocks in which the next ones are counted; write \
             buffers = 2"
                .to_owned(),
        );
    }
    if plan.takes_turns() && plan.periods <= detectors as u64 {
        return limit(
            "the integration time in code periods",
            plan.periods,
            format!(
                "at least {} with {detectors} detector{}: one histogram is read, a row a clock, while \
                 the next counts; integrate over more code periods, or write buffers = 1",
                detectors + 1,
                if detectors == 1 { "" } else { "s" }
            ),
        );
    }
    Ok(())
}

/// Whether the target's block RAM holds the histograms.
fn check_block_ram(sensor: &Sensor, plan: &HistogramPlan) -> Result<(), HdlError> {
    let detectors = sensor.scene().detectors.len();
    let ram = block_ram(sensor.scene().hardware.target);
    let blocks = ram.blocks_of_histograms(plan, detectors);
    if blocks > ram.blocks {
        return limit(
            &format!(
                "the block RAM of {} of {} bins of {} bits in blocks ({})",
                match plan.takes_turns() {
                    true => "two histograms",
                    false => "a histogram",
                },
                plan.bins(),
                plan.bin_bits,
                ram.name
            ),
            blocks,
            format!(
                "at most {}, which the target has; use {}",
                ram.blocks,
                ram.advice(plan, detectors)
            ),
        );
    }
    Ok(())
}

/// The peak detector compares a group's counts one after another.
fn check_peak(interface: &Interface, peak: &PeakPlan) -> Result<(), HdlError> {
    let needed = peak.least_chips;
    let chips = interface.timing.scan.integration_chips;
    if chips >= needed {
        return Ok(());
    }
    Err(HdlError::Limit {
        what: "the integration time in chips".into(),
        found: chips,
        limit: format!(
            "at least {needed} with a peak detector and parallel = {}, because the counts of a \
             group are compared one after another; integrate longer, or leave the peak to the host",
            interface.parallel()
        )
        .into(),
    })
}

fn check_code(source_name: &str, code: &Code) -> Result<(), HdlError> {
    let of_source = |what: &str| format!("{what} of source `{source_name}`");
    within(of_source("the interleaving depth"), code.interleave, "0 to 4", |nu| nu <= 4)?;
    let problem = |problem: String| HdlError::Code { source_name: source_name.to_owned(), problem };
    let base_period = match &code.generator {
        Generator::MSequence(lfsr) => check_lfsr(source_name, lfsr)?,
        Generator::Gold { u, v } => {
            let period = check_lfsr(source_name, u)?;
            if check_lfsr(source_name, v)? != period {
                return Err(problem("the LFSRs of a Gold code differ in degree".into()));
            }
            period
        }
        Generator::Square => 2,
        Generator::Chips(chips) => {
            within(
                of_source("the number of chips"),
                chips.len() as u32,
                "1 to 4096 given chips",
                |chips| (1..=4096).contains(&chips),
            )?;
            chips.len() as u64
        }
    };
    if code.len() != base_period << code.interleave {
        return Err(problem(format!(
            "its table has {} chips, its generator {}",
            code.len(),
            base_period << code.interleave
        )));
    }
    Ok(())
}

/// The period of an LFSR that the generator can hold.
fn check_lfsr(source_name: &str, lfsr: &Lfsr) -> Result<u64, HdlError> {
    within(format!("the degree of source `{source_name}`"), lfsr.degree, "3 to 16", |degree| {
        (3..=MOST_HARDWARE_DEGREE).contains(&degree)
    })?;
    let problem = |problem: &str| {
        Err(HdlError::Code { source_name: source_name.to_owned(), problem: problem.to_owned() })
    };
    if lfsr.seed.len() != lfsr.degree as usize || !lfsr.seed.contains(&1) {
        return problem("a seed needs as many chips as the degree, and one that is 1");
    }
    if lfsr.exponents.iter().any(|&e| e > lfsr.degree) || !lfsr.exponents.contains(&lfsr.degree) {
        return problem("a polynomial's highest exponent has to be its degree");
    }
    Ok((1 << lfsr.degree) - 1)
}

fn within(
    what: impl Into<String>,
    found: u32,
    limit: &'static str,
    holds: impl Fn(u32) -> bool,
) -> Result<(), HdlError> {
    if holds(found) {
        return Ok(());
    }
    Err(HdlError::Limit { what: what.into(), found: u64::from(found), limit: limit.into() })
}

//! Table `[scan]`.

use toml::de::DeValue;

use super::Scan;
use super::declare::*;
use super::reader::Value;
use super::source::PATH;
use crate::code::MAX_CODE_CHIPS;
use crate::light::round_trip_ps;
use crate::scan::Clock;

/// Most samples of one scan: 2^60 samples of 1 ns are 36 years, and the number of
/// a sample in any of 8 scans stays within 64 bits.
pub(super) const MAX_SCAN_SAMPLES: u128 = 1 << 60;
/// Most chips of a step: doubles count them one by one.
const MAX_STEP_CHIPS: f64 = (1_u64 << 53) as f64;

/// Most phase steps of a code period: the longest code, with the most samples.
const MOST_PHASE_STEPS: i64 = (MAX_CODE_CHIPS * 64) as i64;

tables! {
    SCAN = "scan" {
        integration = quantity(Time, "1 ps", "1000000 s"), Needed, "100 us";
            "integration time of a phase step, rounded to whole chips; of a histogram, \
             and where scans are added up, to whole code periods"
            "the shortest chip period; eleven days, in which the number of samples stays within 64 \
             bits";
        steps = words("\"all\" or a table of phase steps", Form::AllOr("scan.steps")),
            Otherwise("\"all\""), "\"all\"";
            "which phase steps are measured";
    }

    STEPS = "scan.steps" {
        first = integer(0, MOST_PHASE_STEPS - 1),
            Otherwise("none: the window is given with `around`"), "0";
            "first phase step, less than those of a code period"
            "phase steps of the longest code, 2^24 chips, with 64 samples per chip";
        count = integer(1, MOST_PHASE_STEPS),
            Otherwise("none: the window is given with `around`"), "64";
            "number of phase steps, no more than those of a code period"
            "as for `first`";
        around = quantity(Distance, "0 m", "1500000 km"),
            Otherwise("none: the window is given with `first`"), "3.2 m";
            "distance (or time of flight, 0 s to 10 s) in the middle of the window"
            "as for `path.distance` and `path.delay`";
        halfwidth = integer(0, MOST_PHASE_STEPS / 2),
            Otherwise("none: the window is given with `first`"), "16";
            "phase steps on either side of the middle"
            "as for `first`";
    }
}

const STEPS_EXAMPLE: &str =
    "\"all\", { first = 0, count = 64 } or { around = \"3.2 m\", halfwidth = 16 }";

/// Reads `[scan]`. `steps_per_period` is K, if it is known.
pub(super) fn read(
    section: Section,
    clock: Option<Clock>,
    steps_per_period: Option<u64>,
) -> Option<Scan> {
    let steps = read_steps(&section, clock, steps_per_period);
    let requested_ps = section.quantity("integration");
    let chips = requested_ps
        .zip(clock)
        .and_then(|(requested, clock)| whole_chips(&section, requested, clock));
    if let (Some((_, count)), Some(chips)) = (steps, chips)
        && let Some(clock) = clock
        && u128::from(count) * u128::from(chips) * u128::from(clock.samples_per_chip)
            > MAX_SCAN_SAMPLES
    {
        let message = format!(
            "{count} phase steps of this length are more than 2^60 samples; integrate for less"
        );
        section.report("integration", &message);
    }
    section.finish();
    let (first_step, steps) = steps?;
    Some(Scan {
        first_step,
        steps,
        steps_per_period: steps_per_period?,
        integration_chips: chips?,
        requested_integration_ps: requested_ps?,
    })
}

fn whole_chips(section: &Section, requested_ps: f64, clock: Clock) -> Option<u64> {
    let chips = clock.chips(requested_ps).round();
    if chips < 1.0 {
        let message = format!(
            "the integration time rounds to 0 chips of {} ns; integrate for at least one chip",
            clock.chip_period_ps / 1e3
        );
        section.report("integration", &message);
        return None;
    }
    if chips > MAX_STEP_CHIPS {
        section.report(
            "integration",
            &format!(
                "this is more than 2^53 chips; integrate for at most \"{:.0} s\"",
                (clock.ps(MAX_STEP_CHIPS) * 1e-12).floor()
            ),
        );
        return None;
    }
    Some(chips as u64)
}

/// First step and number of steps.
fn read_steps(
    scan: &Section,
    clock: Option<Clock>,
    steps_per_period: Option<u64>,
) -> Option<(u64, u64)> {
    const KEY: &str = "steps";
    let Some(value) = scan.get(KEY) else {
        return Some((0, steps_per_period?));
    };
    match value.get_ref() {
        DeValue::String(text) if text == "all" => Some((0, steps_per_period?)),
        DeValue::Table(_) => {
            let section = scan.section_of(KEY, value, STEPS_EXAMPLE)?;
            let steps = read_window(&section, clock, steps_per_period);
            section.finish();
            steps
        }
        _ => {
            let shown = scan.excerpt(value);
            let message = format!("{shown} is not a choice of phase steps; write {STEPS_EXAMPLE}");
            scan.report_at(KEY, value, &message);
            None
        }
    }
}

fn read_window(
    section: &Section,
    clock: Option<Clock>,
    steps_per_period: Option<u64>,
) -> Option<(u64, u64)> {
    let first = section.integer("first");
    let count = section.integer("count");
    let around = section.get("around");
    let halfwidth = section.integer("halfwidth");
    let given = |keys: [&'static str; 2]| keys.map(|key| section.get(key).is_some());
    match (given(["first", "count"]), given(["around", "halfwidth"])) {
        ([true, true], [false, false]) => {
            let (first, count, period) = (first? as u64, count? as u64, steps_per_period?);
            if first >= period {
                let message =
                    format!("{first} is outside 0 to {}, the phase steps of a period", period - 1);
                section.report("first", &message);
            }
            check_count(section, "count", count, period)?;
            Some((first, count))
        }
        ([false, false], [true, true]) => {
            let delay_ps = read_centre(section, around?);
            let (halfwidth, period) = (halfwidth? as u64, steps_per_period?);
            let count = 2 * halfwidth + 1;
            check_count(section, "halfwidth", count, period)?;
            let centre = (delay_ps? / clock?.sample_period_ps()).round();
            // Steps repeat with the period, and so do distances.
            let centre = centre.rem_euclid(period as f64) as u64;
            Some(((centre + period - halfwidth) % period, count))
        }
        _ => {
            let message = format!("these keys do not choose phase steps; write {STEPS_EXAMPLE}");
            section.complain(&message);
            None
        }
    }
}

fn check_count(section: &Section, key: &str, count: u64, period: u64) -> Option<()> {
    if count <= period {
        return Some(());
    }
    let message = format!(
        "{count} phase steps are more than the {period} of a code period; scan fewer, or \"all\""
    );
    section.report(key, &message);
    None
}

/// Delay in picoseconds that a distance or a time stands for.
fn read_centre(section: &Section, value: Value) -> Option<f64> {
    const KEY: &str = "around";
    let is_time = value
        .get_ref()
        .as_str()
        .is_some_and(|text| super::units::parse(text, Quantity::Time, "").is_ok());
    if is_time {
        section.quantity_of(KEY, value, PATH.key("delay"))
    } else {
        section.quantity_of(KEY, value, STEPS.key(KEY)).map(round_trip_ps)
    }
}

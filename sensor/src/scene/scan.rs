//! Table `[scan]`.

use toml::de::DeValue;

use super::declare::*;
use super::reader::SceneValue;
use super::source::PATH;
use super::{Architecture, Registers, Scene};
use crate::code::MAX_CODE_CHIPS;
use crate::light::round_trip_ps;
use crate::scan::{Clock, Scan};

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
            "distance (or time of flight, 0 s to 10 s) in the middle of the window; `detector.delay` is not \
             in it, which moves a target's peak to later phase steps"
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
fn read_centre(section: &Section, value: SceneValue) -> Option<f64> {
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

impl Scene {
    /// The scene of what a host gets where a board adds up M scans (`hardware.accumulate`): one scan whose
    /// steps are M times as long. Steps are whole code periods there, so that a step's counts do not depend on when
    /// it begins, and the sum of M of them has this scan's mean and scatter.
    #[must_use]
    pub fn summed(mut self) -> Scene {
        let scans = std::mem::replace(&mut self.hardware.accumulate, 1);
        self.scan.integration_chips *= u64::from(scans);
        self.scan.requested_integration_ps *= f64::from(scans);
        self
    }
}

/// Samples of a scan, no more than [`MAX_SCAN_SAMPLES`].
fn samples_of(scene: &Scene) -> u128 {
    let Scan { steps, integration_chips, .. } = scene.scan;
    u128::from(steps) * u128::from(integration_chips) * u128::from(scene.samples_per_chip)
}

/// Reports what does not go with sums of scans: they are of scans that are alike, and of counts as they are.
pub(super) fn check_sums(root: &Section, scene: &Scene) {
    let scans = u64::from(scene.hardware.accumulate);
    if scans == 1 || scene.hardware.architecture == Architecture::Histogram {
        return;
    }
    let hardware = root.section_or_defaults("hardware");
    let refuse = |why: &str| hardware.report("accumulate", why);
    if scene.hardware.registers != Registers::None {
        refuse(
            "a host can change the scan between two that are added up; leave out this key, or the \
             registers",
        );
    } else if scene.hardware.counter_width.is_some() {
        refuse(
            "the sum of counts that were cut to counter_width says nothing of what was cut off; leave \
             out this key, or counter_width",
        );
    } else if u128::from(scans) * samples_of(scene) > MAX_SCAN_SAMPLES {
        refuse(
            "so many scans have more than 2^60 samples together; add up fewer, or integrate for less",
        );
    }
    let paths = root.sections("path", usize::MAX);
    for (section, _) in paths.iter().zip(&scene.paths).filter(|(_, path)| path.movement.is_some()) {
        let key = if section.get("velocity").is_some() { "velocity" } else { "fluctuation" };
        section.report(
            key,
            "hardware.accumulate adds up scans, in each of which the target is elsewhere; leave out \
             hardware.accumulate, or let the target stand still",
        );
    }
    let sources = root.sections("source", usize::MAX);
    for (section, _) in sources.iter().zip(&scene.sources).filter(|(_, it)| !it.clock.is_shared()) {
        let key =
            if section.get("clock_offset").is_some() { "clock_offset" } else { "clock_drift" };
        section.report(
            key,
            "hardware.accumulate adds up scans, in each of which a code of another clock is elsewhere; \
             leave out hardware.accumulate, or let the source share the clock",
        );
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Scene, parse};

    /// The scene `quick`, 2,500 chips of a code of 31, with these lines under `[hardware]`.
    fn quick(hardware: &str) -> Result<Scene, String> {
        let text = std::fs::read_to_string("../scenes/quick.toml").expect("it is there");
        parse("x.toml", &format!("{text}\n[hardware]\n{hardware}\n")).map_err(|e| e.to_string())
    }

    #[test]
    fn scans_that_are_added_up_have_steps_of_whole_code_periods() {
        let one = quick("accumulate = 1").expect("it is sound");
        assert_eq!((one.scan.integration_chips, one.clone().summed().scan), (2500, one.scan));
        // 80.6 code periods are 81, of each of four scans; 80 us were asked for of them together.
        let four = quick("accumulate = 4").expect("it is sound");
        assert_eq!(four.scan.integration_chips, 81 * 31);
        let sum = four.summed();
        assert_eq!(sum.scan.integration_chips, 4 * 81 * 31);
        assert!((sum.scan.requested_integration_ps - 80e6).abs() < 1e-3);
        // It is the sum already.
        assert_eq!((sum.hardware.accumulate, sum.clone().summed().scan), (1, sum.scan));
    }

    #[test]
    fn what_does_not_go_with_sums_is_refused_by_its_key() {
        for (hardware, why) in [
            ("registers = \"axi4-lite\"", "hardware.accumulate: a host can change the scan"),
            ("counter_width = 8", "hardware.accumulate: the sum of counts that were cut"),
            ("architecture = \"histogram\"", "hardware.accumulate: a histogram adds up"),
        ] {
            let error = quick(&format!("accumulate = 2\n{hardware}")).expect_err(hardware);
            assert!(error.contains(why), "{error}");
        }
        let moving = std::fs::read_to_string("../scenes/moving.toml").expect("it is there");
        let moving = moving.replace("[hardware]", "[hardware]\naccumulate = 2");
        let error = parse("x.toml", &moving).expect_err("it moves").to_string();
        assert!(error.contains("hardware.accumulate adds up scans, in each of which"), "{error}");
        let slipping = "accumulate = 2\n[[source]]\nname = \"other\"\n\
                        code = { family = \"gold\", degree = 5, index = 3 }\nwavelength = \"783 nm\"\n\
                        mean_power = \"2 pW\"\nclock_offset = \"10 ppm\"";
        let error = quick(slipping).expect_err("its code is elsewhere");
        assert!(error.contains("a code of another clock is elsewhere"), "{error}");
    }
}

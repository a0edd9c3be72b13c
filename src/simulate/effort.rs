//! What simulating scans takes in time and memory, refused before the work.

use super::Tier;
use crate::estimate::{TheoryEffort, Work};
use crate::photons::DetectorModel;
use crate::response::MeanResponseError;
use crate::scene::{Architecture, DetectorIndex};
use crate::sensor::Sensor;

/// A detection, with what it takes to look for the next.
const DETECTION_S: f64 = 10e-9;
/// A clock of the Verilog.
const CLOCK_S: f64 = 10e-9;
/// The scans of one detector that are expected to take longer on one core are refused.
const LONGEST_DAYS: f64 = 30.0;
/// Preparing to draw counts, which nobody can share out, takes no longer on one core.
const LONGEST_PREPARATION_S: f64 = 3600.0;
/// Most afterpulses pending at a time: a list of some hundred megabytes.
const MOST_PENDING: f64 = 1e7;

/// Why a simulation is not begun.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TooMuch {
    /// It would take too long.
    #[error(
        "simulating {scans} scans would take about {days:.0} days of one core, and no more than \
         {limit_days} are begun; simulate fewer scans (`--shard` shares them out), fewer steps, \
         shorter integration times or less light, or take the tiers `counts` or `expected`"
    )]
    Time {
        /// Scans that are asked for.
        scans: u64,
        /// What they take.
        days: f64,
        /// The most that is begun.
        limit_days: f64,
    },
    /// It would fill the memory.
    #[error(
        "some {pending:.1e} afterpulses would be pending at a time, and no more than {limit:.0e} are \
         kept; shorten the time constant of afterpulsing, or lower its probability or the light"
    )]
    Memory {
        /// Afterpulses pending in the brightest light.
        pending: f64,
        /// The most that are kept.
        limit: f64,
    },
}

/// Seconds on one core that a scan takes, of any tier that follows photons.
pub(super) fn scan_s(sensor: &Sensor, model: &DetectorModel, tier: Tier) -> f64 {
    let scan = &model.timing.scan;
    let integration = scan.integration_chips as f64;
    let groups = match sensor.scene().hardware.architecture {
        Architecture::UpDown => model.timing.groups() as f64,
        Architecture::Histogram => 1.0,
    };
    let detections = (model.warm_up_chips() as f64 + integration) * model.most_work_per_chip();
    let clocks = if tier == Tier::Rtl { integration } else { 0.0 };
    groups * (detections * DETECTION_S + clocks * CLOCK_S)
}

/// Refuses to work out the moments to draw counts by where that takes too long, or too much
/// memory.
///
/// # Errors
/// With what it would take, and what to change.
pub(super) fn check_draws(
    sensor: &Sensor,
    detector: DetectorIndex,
) -> Result<(), MeanResponseError> {
    TheoryEffort::of(sensor, detector)?.check_within(Work::Draws, LONGEST_PREPARATION_S)
}

/// Refuses scans of a detector that follow photons and would take too long, or too much memory.
///
/// # Errors
/// With what they would take, and what to change.
pub(super) fn check(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: Tier,
    scans: u64,
) -> Result<(), TooMuch> {
    if tier <= Tier::Counts {
        return Ok(());
    }
    let model = DetectorModel::new(sensor, detector);
    let pending = model.most_pending_afterpulses();
    if pending > MOST_PENDING {
        return Err(TooMuch::Memory { pending, limit: MOST_PENDING });
    }
    let days = scans as f64 * scan_s(sensor, &model, tier) / 86_400.0;
    // What is not a number is refused, too.
    if days <= LONGEST_DAYS {
        return Ok(());
    }
    Err(TooMuch::Time { scans, days, limit_days: LONGEST_DAYS })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{extreme, load_with};
    use crate::simulate::scans::scans;

    const FIRST: DetectorIndex = DetectorIndex(0);

    /// Scenes at the ends of every range: what a scan takes is said at once, as a finite number;
    /// what is refused says what to change, and what is said to be little ends.
    #[test]
    fn simulations_of_extreme_scenes_end_or_are_refused() {
        let (mut refused, mut simulated) = (0, 0);
        for (settings, scene) in extreme::scenes(200) {
            let sensor = Sensor::new(&scene);
            for tier in [Tier::Events, Tier::Sampled] {
                let seconds = scan_s(&sensor, &DetectorModel::new(&sensor, FIRST), tier);
                assert!(seconds.is_finite() && seconds >= 0.0, "{settings:?}");
                // As many scans as come to a month are begun, and one more is not.
                let most = (LONGEST_DAYS * 86_400.0 / seconds) as u64;
                assert!(check(&sensor, FIRST, tier, most).is_ok(), "{settings:?}");
                let reason = check(&sensor, FIRST, tier, most + 1).expect_err("too many");
                assert!(reason.to_string().contains("; simulate fewer scans"), "{reason}");
                refused += u32::from(most == 0);
                if seconds < 1e-3 {
                    simulated += 1;
                    let found = scans(&sensor, FIRST, tier, 1, 1, |_| ());
                    found.unwrap_or_else(|reason| panic!("{settings:?}: {reason}"));
                }
            }
            if let Err(reason) = check_draws(&sensor, FIRST) {
                refused += 1;
                let refusal = scans(&sensor, FIRST, Tier::Counts, 1, 1, |_| ());
                let refusal = refusal.expect_err("the moments take too long").to_string();
                assert_eq!(refusal, reason.to_string(), "{settings:?}");
            }
        }
        println!("{refused} refused, {simulated} simulated");
        assert!(refused > 20 && simulated > 10, "{refused} {simulated}");
    }

    #[test]
    fn too_many_scans_and_pending_afterpulses_are_refused_before_the_work() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/quick.toml");
        let sensor = |settings: &[&str]| {
            let settings: Vec<_> = settings.iter().map(|s| s.parse().expect("a setting")).collect();
            Sensor::new(&load_with(&file, &settings).expect("it is sound"))
        };
        for tier in [Tier::Events, Tier::Sampled] {
            let refused =
                scans(&sensor(&[]), FIRST, tier, 1, 1 << 60, |_| ()).expect_err("endless");
            assert!(refused.to_string().contains("days of one core"), "{refused}");
        }
        // 4.6 afterpulses of each of up to 1,000 million avalanches a second, for 10 ms.
        let settings = |time_constant: &str| {
            let trap = format!("{{ probability = 0.99, time_constant = \"{time_constant}\" }}");
            [format!("detector.afterpulsing={trap}"), "detector.dead_time=1 ns".to_owned()]
        };
        let sensor_of = |time_constant| {
            let settings = settings(time_constant);
            sensor(&settings.each_ref().map(String::as_str))
        };
        let one = |sensor: &Sensor| scans(sensor, FIRST, Tier::Sampled, 1, 1, |_| ());
        let refused = one(&sensor_of("10 ms")).expect_err("too much").to_string();
        assert!(refused.contains("4.6e7 afterpulses would be pending"), "{refused}");
        one(&sensor_of("10 ns")).expect("some are kept");
    }
}

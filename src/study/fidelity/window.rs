//! The phase steps that a comparison needs.

use crate::estimate::{CountingTier, calibration_offset_ps, predict};
use crate::plan::{Part, Saving};
use crate::scene::{Architecture, DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Expected misses of the whole scan that a window may leave out, in target errors.
const LEFT_OUT: f64 = 0.01;

/// The sensor with only the phase steps that the fine stage needs, two chips on
/// either side of the path's peak (whole groups of them), and what that saved.
///
/// Steps elsewhere decide how many scans miss the peak. They are left out only where
/// that is expected to be next to nothing beside the target error, by the sum of the
/// chances of all of them.
pub fn round_peak(sensor: &Sensor, path: PathIndex, target_error: f64) -> (Sensor, Option<Part>) {
    let scene = sensor.scene();
    if scene.hardware.architecture == Architecture::Histogram {
        // Its bins make up the whole range.
        return (sensor.clone(), None);
    }
    let step_ps = sensor.clock().sample_period_ps();
    let offset_ps = calibration_offset_ps(sensor, DetectorIndex(0), CountingTier::Sampled);
    let period = scene.scan.steps_per_period;
    let peak = ((scene.paths[path].delay_ps + offset_ps) / step_ps).round() as u64 % period;
    let half = 2 * u64::from(scene.samples_per_chip);
    let steps = (2 * half + 1).next_multiple_of(u64::from(scene.hardware.parallel));
    if !scene.scan.is_full() || steps >= period {
        return (sensor.clone(), None);
    }
    let missed = match predict(sensor, DetectorIndex(0), path, CountingTier::Sampled) {
        Ok(expected) if expected.coarse_failure_bound_fraction <= LEFT_OUT * target_error => {
            expected.coarse_failure_bound_fraction
        }
        _ => return (sensor.clone(), None),
    };
    let windowed = sensor.with(|scene| {
        scene.scan.first_step = (peak + period - half) % period;
        scene.scan.steps = steps;
    });
    let part = Part {
        part: "phase_steps_away_from_the_peak".to_owned(),
        kept: false,
        reason: format!(
            "the fine stage needs {steps} of {period} phase steps, and the others are expected to \
             mislead at most {:.1e} of the scans",
            missed
        ),
        saving: Some(Saving {
            time_fraction: 1.0 - steps as f64 / period as f64,
            basis: "share of the phase steps: photons and clocks".to_owned(),
        }),
        saved_cells: None,
    };
    (windowed, Some(part))
}

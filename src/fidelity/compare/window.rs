//! The phase steps that a comparison needs.

use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::plan::{Part, Saving};
use crate::scene::{Scan, Scene};

/// The scene with only the phase steps that the fine stage needs, two chips on
/// either side of the path's peak (whole groups of them), and what that saved.
pub fn round_peak(scene: &Scene, path: usize) -> (Scene, Option<Part>) {
    let mut windowed = scene.clone();
    let step_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
    let offset_ps = calibration_offset_ps(scene, 0, CountingTier::Sampled);
    let period = scene.scan.steps_per_period;
    let peak = ((scene.paths[path].delay_ps + offset_ps) / step_ps).round() as u64 % period;
    let half = 2 * u64::from(scene.samples_per_chip);
    let steps = (2 * half + 1).next_multiple_of(u64::from(scene.hardware.parallel));
    if !scene.scan.is_full() || steps >= period {
        return (windowed, None);
    }
    windowed.scan = Scan {
        first_step: (peak + period - half) % period,
        steps,
        ..scene.scan
    };
    let part = Part {
        part: "phase_steps_away_from_the_peak".to_owned(),
        kept: false,
        reason: format!("the fine stage needs {steps} of {period} phase steps"),
        saving: Some(Saving {
            share: 1.0 - steps as f64 / period as f64,
            basis: "share of the phase steps: photons and clocks".to_owned(),
        }),
    };
    (windowed, Some(part))
}

//! What the phase estimator says of many scans, and at which steps its coarse
//! stage stood.

use std::collections::BTreeMap;

use super::run_error::RunError;
use super::statistics::{Measured, rate, sample_mean_of, sample_std};
use crate::estimate::{CountingTier, calibration_offset_ps, delay_error_ps, distance_m, estimate};
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::scans::scans;

/// Errors of the estimates of a scene's first path.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Standard deviation, in metres.
    pub std_m: Measured,
    /// Mean error, in metres.
    pub bias_m: Measured,
    /// Scans within a chip of the target; the others take no part.
    pub found: u64,
    /// All scans.
    pub scans: u64,
    /// Share of the found in which another step than the most frequent one counts
    /// most.
    pub elsewhere: Measured,
    /// Detections per second.
    pub detected_rate_cps: f64,
}

impl Errors {
    /// Share of scans within a chip of the target.
    pub fn correct_coarse(&self) -> Measured {
        rate(self.found, self.scans)
    }
}

/// Simulates scans, single detection by single detection, and takes the phase
/// estimator's errors against the first path.
pub fn phase_errors(scene: &Scene, seed: u64, repetitions: u64) -> Result<Errors, RunError> {
    let sensor = Sensor::new(scene);
    let timing = sensor.timing();
    let offset_ps = calibration_offset_ps(&sensor, DetectorIndex(0), CountingTier::Events);
    let period_ps = timing.code_period_ps();
    let mut errors_m = Vec::new();
    let mut coarse_steps: BTreeMap<u64, u64> = BTreeMap::new();
    let mut detections = 0;
    let mut signed = Vec::new();
    scans(&sensor, DetectorIndex(0), Tier::Events, seed, repetitions, |counts| {
        signed.clear();
        signed.extend(counts.iter().map(|count| count.signed));
        detections += counts.iter().map(|count| count.total).sum::<u64>();
        let Ok(found) = estimate(timing, &signed, offset_ps) else {
            return;
        };
        let error_ps = delay_error_ps(found.delay_ps, scene.paths[0].delay_ps, period_ps);
        if error_ps.abs() <= timing.clock.chip_period_ps {
            errors_m.push(distance_m(error_ps));
            *coarse_steps.entry(found.coarse_step).or_default() += 1;
        }
    })?;
    if errors_m.len() < 2 {
        return Err(RunError::NoStatistics { scans: repetitions });
    }
    let found = errors_m.len() as u64;
    let most_frequent = coarse_steps.values().copied().max().unwrap_or(found);
    let step_s = timing.integration_ps() * 1e-12;
    Ok(Errors {
        std_m: sample_std(&errors_m),
        bias_m: sample_mean_of(&errors_m),
        found,
        scans: repetitions,
        elsewhere: rate(found - most_frequent, found),
        detected_rate_cps: detections as f64 / (step_s * (repetitions * scene.scan.steps) as f64),
    })
}

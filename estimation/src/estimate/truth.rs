//! The true delay that an estimate is compared with, and the constant part of a measured delay that is
//! not time of flight.

use crate::response::CountingTier;
use crate::scan::Step;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// The delay that a scan should find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueDelay {
    /// Time of flight, without a fluctuation.
    pub delay_ps: f64,
    /// When the path has it, from the start of the scan; `None` for a path that
    /// always has it.
    pub at_ps: Option<f64>,
}

/// The delay of path `path` when the scan passes it.
///
/// Phase steps follow one another, so the delay of a path that moves is measured
/// at the moment at which the reference is as late as the light: k T_s grows by
/// T_s per step, the delay by its walk w = 2 v D T_c / c, and the phase stage, which
/// sees the peak where the two meet, returns the delay of that moment. With
/// several steps at once it is the middle of the peak's group. A path that the
/// scan does not pass has its delay at the step nearest to it.
pub fn true_delay(sensor: &Sensor, path: PathIndex, tier: CountingTier) -> TrueDelay {
    let path = &sensor.scene().paths[path];
    if path.movement.is_none() {
        return TrueDelay { delay_ps: path.delay_ps, at_ps: None };
    }
    let offset_ps = calibration_offset_ps(sensor, path.detector, tier);
    let step_ps = sensor.clock().sample_period_ps();
    let period_steps = sensor.timing().scan.steps_per_period as f64;
    // How far in front of the light the reference is at a step, in steps.
    let ahead = |step: Step| -> f64 {
        let light = path.delay_ps_at(sensor.timing().middle_of_step_ps(step)) + offset_ps;
        let steps = light / step_ps - sensor.timing().scan.phase_step(step) as f64;
        steps - period_steps * (steps / period_steps).round()
    };
    let nearest = Step::all(sensor.timing().scan.steps)
        .min_by(|&a, &b| ahead(a).abs().total_cmp(&ahead(b).abs()))
        .unwrap_or(Step(0));
    let mut at_ps = sensor.timing().middle_of_step_ps(nearest);
    let walk_steps = path.delay_rate() * sensor.timing().integration_ps() / step_ps;
    let steps_to_go = ahead(nearest) / (1.0 - walk_steps);
    if sensor.timing().parallel == 1 && steps_to_go.abs() <= 1.0 {
        at_ps += steps_to_go * sensor.timing().integration_ps();
    }
    TrueDelay { delay_ps: path.delay_ps_at(at_ps), at_ps: Some(at_ps) }
}

/// How much later than the light's delay the correlation's peak is, in ps. The mean of
/// the jitter's tail is part of it.
///
/// `Events`: the detection comes `delay` late, and the reference's edges come
/// (rising + falling) / 2 late on average, which makes the detection look that
/// much earlier: delay - (rising + falling) / 2.
///
/// `Sampled`: delay + T_s. Sample s stands for the registered times in
/// ((s - 1) T_s, s T_s], so that a detection is seen T_s / 2 late on average;
/// and the reference at sample s is that of the instant s T_s, the *first* of
/// the T_s that it holds for, which is another T_s / 2. Of pulses shorter than a
/// sample only those are seen that begin w at most before it: w / 2 late on average.
/// `Binned`: the same of pulses that are all seen.
/// Where samples are not equally far apart, their mean lateness takes the place of
/// T_s / 2: light of one chip comes by each of them once, wherever it begins.
pub fn calibration_offset_ps(sensor: &Sensor, detector: DetectorIndex, tier: CountingTier) -> f64 {
    let spad = &sensor.scene().detectors[detector];
    let delay_ps = spad.delay_ps + spad.jitter_tail.mean_ps();
    match tier {
        CountingTier::Events => {
            delay_ps - 0.5 * (spad.counter.rising_delay_ps + spad.counter.falling_delay_ps)
        }
        CountingTier::Sampled | CountingTier::Binned => {
            let sample_ps = sensor.clock().sample_period_ps();
            let seen = match tier {
                CountingTier::Binned => f64::INFINITY,
                _ => spad.pulse_width_ps / sample_ps,
            };
            let lateness = spad.sampler.mean_lateness(seen);
            delay_ps + (0.5 * sample_ps + lateness * sample_ps)
        }
    }
}

/// A path whose estimates are asked about, from counts of a tier.
#[derive(Clone, Copy)]
pub(super) struct Asked<'s> {
    pub sensor: &'s Sensor,
    pub detector: DetectorIndex,
    pub path: PathIndex,
    pub tier: CountingTier,
}

impl Asked<'_> {
    /// The delay that its estimates are compared with.
    pub fn truth(&self) -> TrueDelay {
        true_delay(self.sensor, self.path, self.tier)
    }

    /// The constant part of its measured delay that is not time of flight.
    pub fn offset_ps(&self) -> f64 {
        calibration_offset_ps(self.sensor, self.detector, self.tier)
    }

    /// The time after which its delays repeat.
    pub fn code_period_ps(&self) -> f64 {
        self.sensor.code_period_of_path_ps(self.path)
    }
}

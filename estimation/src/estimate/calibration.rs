//! The constant part of a measured delay that is not light.

use crate::response::CountingTier;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// What the correlation's peak stands later than the light's delay, in ps. The mean of
/// the jitter's tail is part of the delay.
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
pub fn calibration_offset_ps(sensor: &Sensor, detector: DetectorIndex, tier: CountingTier) -> f64 {
    let spad = &sensor.scene().detectors[detector];
    let delay_ps = spad.delay_ps + spad.jitter_tail.mean_ps();
    match tier {
        CountingTier::Events => {
            delay_ps - 0.5 * (spad.counter.rising_delay_ps + spad.counter.falling_delay_ps)
        }
        CountingTier::Sampled => {
            let sample_ps = sensor.clock().sample_period_ps();
            delay_ps + 0.5 * (sample_ps + spad.pulse_width_ps.min(sample_ps))
        }
    }
}

//! Where the fit of one path starts: at the phase estimate and the rate.

use super::coarse::best_match;
use super::parameters::{Parameters, PathParameters};
use crate::estimate::phase::estimate_at;
use crate::estimate::{CountingTier, NoEstimate, calibration_offset_ps};
use crate::photons::DeadTime;
use crate::response::MeanCount;
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// A start, and the number of the step where the peak is.
pub struct Start {
    pub parameters: Parameters,
    pub peak: Step,
}

/// Least share of the light that a fit starts to take for the path's.
const LEAST_SHARE: f64 = 0.02;

/// Most of the light that a fit starts to take for the path's: with none but that, a
/// count against it would be impossible.
const MOST_SHARE: f64 = 0.999;

/// The phase estimate for the delay. For the light, with q the code's share of
/// ones and e the excess on-light: detections per chip give the mean light
/// m = q e + constant, corrected for the dead time, and without dead time the peak
/// would be r / N = (q (e + constant) - (1 - q) constant) / m, that is
/// e / m = (r / N + 1 - 2 q) / (2 q (1 - q)). So few counts that this is no positive
/// number, or more than there is, start from a little light, or nearly all.
pub fn start(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[MeanCount],
) -> Result<Start, NoEstimate> {
    let signed: Vec<f64> = counts.iter().map(|count| count.signed).collect();
    let spad = &sensor.scene().detectors[detector];
    let code = &sensor.scene().sources[spad.reference].code;
    let peak = best_match(sensor, code, &signed);
    let largest = counts[peak];
    if signed.iter().all(|&count| count == largest.signed) || largest.total <= 0.0 {
        return Err(NoEstimate::Flat { count: largest.signed as i64 });
    }
    let offset_ps = calibration_offset_ps(sensor, detector, tier);
    let phase = estimate_at(&signed, peak, sensor.timing(), offset_ps);

    let ones = code.weight() as f64 / code.len() as f64;
    let sample_ps = sensor.clock().sample_period_ps();
    let seen = match tier {
        CountingTier::Events => 1.0,
        CountingTier::Sampled => (spad.pulse_width_ps / sample_ps).min(1.0),
    };
    let detected = largest.total / sensor.timing().scan.integration_chips as f64 / seen;
    let dead_time = DeadTime(sensor.clock().chips(spad.dead_time_ps));
    let mean = dead_time.primary(detected) * (1.0 - spad.afterpulsing_probability);
    let zeros = 1.0 - ones;
    if ones * zeros <= 0.0 {
        return Err(NoEstimate::NotModulated);
    }
    let contrast = (largest.signed / largest.total + zeros - ones) / (2.0 * ones * zeros);
    let rate = mean * contrast.clamp(LEAST_SHARE, MOST_SHARE / ones);
    Ok(Start {
        parameters: Parameters {
            paths: vec![PathParameters {
                delay_chips: sensor.clock().chips(phase.delay_ps),
                ln_rate: rate.ln(),
            }],
            walk: None,
            constant: mean - rate * ones,
        },
        peak: Step::at(peak),
    })
}

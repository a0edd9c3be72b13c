//! Where the fit of one path starts: at the phase estimate and the rate.

use super::coarse::best_match;
use super::problem::{Parameters, PathParameters};
use crate::estimate::phase::{Measurement, estimate_at};
use crate::estimate::{CountingTier, NoEstimate, calibration_offset_ps};
use crate::optics::MeanCount;
use crate::scene::Scene;
use crate::sensor::Step;

/// A start, and the number of the step where the peak is.
pub struct Start {
    pub parameters: Parameters,
    pub peak: Step,
}

/// The phase estimate for the delay. For the light, with q the code's share of
/// ones, e the excess on-light and x = constant / e: detections per chip give
/// the mean light q e + constant, corrected for the dead time, and without dead
/// time the peak would be r / N = (q (1 + x) - (1 - q) x) / (q + x), which gives
/// x.
pub fn start(
    scene: &Scene,
    detector: usize,
    tier: CountingTier,
    counts: &[MeanCount],
) -> Result<Start, NoEstimate> {
    let signed: Vec<f64> = counts.iter().map(|count| count.signed).collect();
    let spad = &scene.detectors[detector];
    let code = &scene.sources[spad.reference].code;
    let peak = best_match(scene, code, &signed);
    let largest = counts[peak];
    if signed.iter().all(|&count| count == largest.signed) || largest.total <= 0.0 {
        return Err(NoEstimate::Flat {
            count: largest.signed as i64,
        });
    }
    let offset_ps = calibration_offset_ps(scene, detector, tier);
    let phase = estimate_at(&signed, peak, &Measurement::new(scene, &[]), offset_ps);

    let ones = code.weight() as f64 / code.len() as f64;
    let detected = largest.total / scene.scan.integration_chips as f64;
    let dead = (detected * spad.dead_time_ps / scene.chip_period_ps).min(0.95);
    let mean = detected * (1.0 - spad.afterpulsing_probability) / (1.0 - dead);
    let depth = (largest.signed / largest.total).clamp(0.01, 0.999);
    let constant_share = (ones * (1.0 - depth) / (depth - 2.0 * ones + 1.0)).max(0.0);
    let rate = mean / (ones + constant_share);
    Ok(Start {
        parameters: Parameters {
            paths: vec![PathParameters {
                delay_chips: phase.delay_ps / scene.chip_period_ps,
                ln_rate: rate.ln(),
            }],
            constant: rate * constant_share,
        },
        peak: Step::at(peak),
    })
}

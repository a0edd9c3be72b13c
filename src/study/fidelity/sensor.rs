//! The sensor's own trade.

use super::SensorPoint;
use crate::estimate::{CountingTier, predict};
use crate::scene::{Architecture, DetectorIndex, EstimatorKind, PathIndex, Scene};
use crate::sensor::Sensor;

/// Powers and integration times, relative to the scene's.
const POWERS: [f64; 4] = [0.1, 0.3, 1.0, 3.0];
const INTEGRATIONS: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];

/// Expected error of the distance over integration time at several light levels.
/// Where the counts have no expected peak there is no point.
pub fn trade(scene: &Scene, path: PathIndex) -> Vec<SensorPoint> {
    let mut points = Vec::new();
    for relative_power in POWERS {
        for factor in INTEGRATIONS {
            let mut other = scene.clone();
            // The trade is that of the phase estimator, its misses too.
            other.estimator = EstimatorKind::Fft;
            for source in &mut other.sources {
                source.mean_power_w *= relative_power;
            }
            let whole_chips = match scene.hardware.architecture {
                Architecture::UpDown => 1,
                // Whole code periods.
                Architecture::Histogram => Sensor::new(scene).timing().code_chips(),
            } as f64;
            let times = (scene.scan.integration_chips as f64 * factor / whole_chips).round();
            let chips = times.max(1.0) * whole_chips;
            other.scan.integration_chips = chips as u64;
            let Ok(expected) =
                predict(&Sensor::new(&other), DetectorIndex(0), path, CountingTier::Sampled)
            else {
                continue;
            };
            points.push(SensorPoint {
                relative_power,
                detected_rate_cps: expected.detection_rate_hz,
                integration_s: scene.clock().ps(chips) * 1e-12,
                std_m: expected.std_m,
                bias_m: expected.bias_m,
                coarse_failure_bound_fraction: expected.coarse_failure_bound_fraction,
                missed_fraction: expected.missed_fraction,
            });
        }
    }
    points
}

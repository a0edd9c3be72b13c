//! From the counts of a scan to a distance.

pub mod bound;
mod calibration;
mod effort;
pub mod fit;
mod missed;
mod modulation;
mod moving;
mod phase;
mod prediction;
pub mod report;
mod theory;
mod truth;
pub mod unwrap;

pub use crate::response::CountingTier;
pub use calibration::calibration_offset_ps;
pub use effort::TheoryEffort;
pub use missed::tolerance_ps;
pub use modulation::check_modulated;
pub use phase::{CoarseOnly, Estimate, Measurement, NoEstimate, estimate};
pub use prediction::{Prediction, PredictionError, predict};
pub use theory::{Theory, theory};
pub use truth::{TrueDelay, true_delay};

use crate::SPEED_OF_LIGHT_M_PER_S;
use crate::scene::Scene;

/// Distance (half the optical path, eq. 1) of a time of flight.
pub fn distance_m(delay_ps: f64) -> f64 {
    0.5 * delay_ps * 1e-12 * SPEED_OF_LIGHT_M_PER_S
}

/// `delay_ps` less `true_delay_ps`, the short way round the code period.
pub fn delay_error_ps(delay_ps: f64, true_delay_ps: f64, code_period_ps: f64) -> f64 {
    let turns = (delay_ps - true_delay_ps) / code_period_ps;
    (turns - turns.round()) * code_period_ps
}

/// What to say of a path that is longer than distances are unambiguous.
pub fn folded(scene: &Scene, path: usize) -> Option<String> {
    let code = &scene.sources[scene.paths[path].source].code;
    let range_m = distance_m(scene.chip_period_ps * code.len() as f64);
    let path_m = scene.paths[path].distance_m();
    (path_m >= range_m).then(|| {
        format!(
            "the path's {path_m:.4} m are beyond the unambiguous range of {range_m:.4} m, and are \
             folded to {:.4} m",
            path_m.rem_euclid(range_m)
        )
    })
}

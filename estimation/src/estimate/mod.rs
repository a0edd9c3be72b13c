//! From the counts of a scan to a distance.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! #     pub use goldtof_estimation::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use std::path::Path;
//!
//! use goldtof::estimate::{CountingTier, predict};
//! use goldtof::scene::{DetectorIndex, PathIndex};
//! use goldtof::sensor::Sensor;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let sensor = Sensor::new(&scene);
//! let expected = predict(&sensor, DetectorIndex(0), PathIndex(0), CountingTier::Sampled)?;
//! // Dead time hides the end of bright chips: the phase comes early.
//! assert!(expected.bias_m < 0.0 && expected.std_m > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod approximation;
pub mod bound;
pub mod chance;
mod corners;
mod count_law;
pub mod coverage;
mod dead_time;
mod effort;
pub mod estimator;
pub mod evidence;
mod expected_counts;
pub mod fit;
pub mod histogram;
mod missed;
mod moving;
mod phase;
mod possible;
mod prediction;
pub mod report;
mod still;
mod theory;
mod truth;
pub mod unwrap;

pub use crate::light::distance_m;
pub use crate::response::CountingTier;
pub use approximation::Approximation;
pub use effort::{TheoryEffort, Work};
pub use missed::share_error;
pub use phase::{CoarseOnly, Estimate, NoEstimate, estimate, estimate_values};
pub use possible::ImpossibleScan;
pub use possible::{check_modulated, possible_count, possible_scan};
pub use prediction::{Prediction, PredictionError};
pub use theory::{Theory, predict, theory, theory_of_integrations};
pub use truth::{TrueDelay, calibration_offset_ps, true_delay};
pub use unwrap::tolerance_ps;

use crate::scene::PathIndex;
use crate::sensor::Sensor;

/// `delay_ps` less `true_delay_ps`, the short way round the code period.
pub fn delay_error_ps(delay_ps: f64, true_delay_ps: f64, code_period_ps: f64) -> f64 {
    let turns = (delay_ps - true_delay_ps) / code_period_ps;
    (turns - turns.round()) * code_period_ps
}

/// What to say of a path that is longer than distances are unambiguous.
pub fn folded(sensor: &Sensor, path: PathIndex) -> Option<String> {
    let range_m = distance_m(sensor.code_period_of_path_ps(path));
    let path_m = sensor.scene().paths[path].distance_m();
    (path_m >= range_m).then(|| {
        format!(
            "the path's {path_m:.4} m are beyond the unambiguous range of {range_m:.4} m, and are \
             folded to {:.4} m",
            path_m.rem_euclid(range_m)
        )
    })
}

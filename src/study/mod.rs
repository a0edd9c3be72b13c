//! Studies: which architecture to build, what limits a sensor, the fidelity of the tiers, the article's
//! figures and claims, stiff and extreme cases, sweeps over a scene's keys.
//!
//! ```
//! use goldtof::study::sweep::SweepAxis;
//!
//! let axis: SweepAxis = "path.distance=1 m..10 m +10".parse()?;
//! assert_eq!(axis.values.len(), 10);
//! assert_eq!(axis.column(), "path.distance (m)");
//! # Ok::<(), String>(())
//! ```

pub mod architectures;
pub mod fidelity;
pub mod limits;
pub mod reproduce;
pub mod stress;
pub mod sweep;

use crate::scene::{self, Detector, Scene};

const PAPER_SINGLE: &str = include_str!("../../scenes/paper-single.toml");

/// The sensor of Table I: the standard scene `paper-single`, the one place in which the
/// table's numbers stand.
fn table_i() -> Scene {
    scene::parse("paper-single.toml", PAPER_SINGLE).expect("the standard scene is sound")
}

/// The detector of Table I, with an afterpulse's delay counted from the end of the dead
/// time; its reference is the first source.
fn table_i_detector() -> Detector {
    table_i().detectors.swap_remove(0)
}

//! The article's own sensor, for the studies that start from it.

use crate::scene::{self, Detector, Scene};

const PAPER_SINGLE: &str = include_str!("../../scenes/paper-single.toml");

/// The sensor of Table I: the standard scene `paper-single`, the one place in which the
/// table's numbers stand.
pub(super) fn table_i() -> Scene {
    scene::parse("paper-single.toml", PAPER_SINGLE).expect("the standard scene is sound")
}

/// The detector of Table I, with an afterpulse's delay counted from the end of the dead
/// time; its reference is the first source.
pub(super) fn detector() -> Detector {
    table_i().detectors.swap_remove(0)
}

//! Which parts of the hardware a scene needs, why, and what they take of an FPGA.

pub mod cells;
mod list;
mod part;
pub mod resources;

pub use list::parts;
pub use part::{Part, Saving, kept, labelled, left_out};

use crate::sensor::Sensor;

/// The parts of the hardware that `scene` does without.
pub fn parts_left_out(sensor: &Sensor) -> Vec<Part> {
    let mut parts = parts(sensor);
    parts.retain(|part| !part.kept);
    parts
}

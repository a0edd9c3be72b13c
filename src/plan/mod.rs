//! What a scene needs, part by part: kept or left out, and why.
//!
//! Each scene runs through only the parts it needs. The plan names every part,
//! so that what was left out is never a surprise.
//!
//! ```
//! use std::path::Path;
//!
//! use goldtof::sensor::Sensor;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let plan = goldtof::plan::plan(&Sensor::new(&scene));
//! let interleaver = plan.hardware.iter().find(|part| part.part == "interleaver").unwrap();
//! assert!(!interleaver.kept);
//! assert!(interleaver.reason.contains("not interleaved"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cells;
pub mod figures;
mod hardware;
pub mod link;
mod measure;
mod movement;
pub mod overview;
mod part;
pub mod resources;
mod simulation;

pub use measure::with_savings;
pub use part::{Part, Plan, Saving};

use crate::sensor::Sensor;

/// Decides, part by part, what `scene` needs.
pub fn plan(sensor: &Sensor) -> Plan {
    Plan {
        hardware: hardware::parts(sensor),
        simulation: simulation::parts(sensor),
        not_measured: 0,
    }
}

/// The parts of the hardware that `scene` does without.
pub fn hardware_left_out(sensor: &Sensor) -> Vec<Part> {
    let mut parts = hardware::parts(sensor);
    parts.retain(|part| !part.kept);
    parts
}

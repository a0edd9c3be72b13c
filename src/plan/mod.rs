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

pub mod figures;
pub mod link;
mod measure;
mod movement;
pub mod overview;
mod simulation;

pub use goldtof_hardware::parts::{Part, Saving, cells, resources};
pub use measure::with_savings;

use goldtof_hardware::parts;
use serde::Serialize;

use crate::sensor::Sensor;

/// Every part of the hardware and of the simulation.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Plan {
    /// Parts of the hardware, along the way of the data.
    pub hardware: Vec<Part>,
    /// Parts of the simulation, along the way of the light.
    pub simulation: Vec<Part>,
    /// Parts left out whose saving was to be measured, but would have taken too
    /// long.
    pub not_measured: usize,
}

/// Decides, part by part, what `scene` needs.
pub fn plan(sensor: &Sensor) -> Plan {
    Plan { hardware: parts::parts(sensor), simulation: simulation::parts(sensor), not_measured: 0 }
}

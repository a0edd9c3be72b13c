//! What a scene needs, part by part: kept or left out, and why.
//!
//! Each scene runs through only the parts it needs. The plan names every part,
//! so that what was left out is never a surprise.

mod hardware;
mod movement;
mod simulation;

use serde::Serialize;

use crate::scene::Scene;

/// A part of the hardware or of the simulation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Part {
    /// Its name.
    pub part: String,
    /// Whether the scene needs it.
    pub kept: bool,
    /// Why, with the scene's numbers.
    pub reason: String,
}

/// Every part of the hardware and of the simulation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Plan {
    /// Parts of the hardware, along the way of the data.
    pub hardware: Vec<Part>,
    /// Parts of the simulation, along the way of the light.
    pub simulation: Vec<Part>,
}

/// Decides, part by part, what `scene` needs.
pub fn plan(scene: &Scene) -> Plan {
    Plan {
        hardware: hardware::parts(scene),
        simulation: simulation::parts(scene),
    }
}

/// A part that is kept, because of `reason`.
fn kept(part: impl Into<String>, reason: impl Into<String>) -> Part {
    Part {
        part: part.into(),
        kept: true,
        reason: reason.into(),
    }
}

/// A part that is left out, because of `reason`.
fn left_out(part: impl Into<String>, reason: impl Into<String>) -> Part {
    Part {
        kept: false,
        ..kept(part, reason)
    }
}

/// `part`, followed by `name` in brackets where the scene has several.
fn labelled(part: &str, name: &str, several: bool) -> String {
    if several {
        format!("{part} ({name})")
    } else {
        part.to_owned()
    }
}

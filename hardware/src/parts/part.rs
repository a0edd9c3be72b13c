//! What a part of the plan is.

use serde::Serialize;

use super::cells::FpgaCells;

/// A part of the hardware or of the simulation.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Part {
    /// Its name.
    pub part: String,
    /// Whether the scene needs it.
    pub kept: bool,
    /// Why, with the scene's numbers.
    pub reason: String,
    /// What leaving it out saves in time, where that was found out.
    pub saving: Option<Saving>,
    /// What leaving a part of the hardware out saves of an FPGA, by the fit of
    /// [`resources`](super::resources), where that was found out.
    pub saved_cells: Option<FpgaCells>,
}

impl Part {
    /// Its name without the label of whose it is.
    pub(super) fn bare_name(&self) -> &str {
        self.part.split(" (").next().unwrap_or_default()
    }
}

/// What leaving a part out saves.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Saving {
    /// Share of the simulation's time with the part.
    pub time_fraction: f64,
    /// How that was found out.
    pub basis: String,
}

/// A part that is kept, because of `reason`.
pub fn kept(part: impl Into<String>, reason: impl Into<String>) -> Part {
    Part { part: part.into(), kept: true, reason: reason.into(), saving: None, saved_cells: None }
}

/// A part that is left out, because of `reason`.
pub fn left_out(part: impl Into<String>, reason: impl Into<String>) -> Part {
    Part { kept: false, ..kept(part, reason) }
}

/// `part`, followed by `name` in brackets where the scene has several.
pub fn labelled(part: &str, name: &str, several: bool) -> String {
    if several { format!("{part} ({name})") } else { part.to_owned() }
}

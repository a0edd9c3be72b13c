//! Which engine does which part of a run.

use serde::{Deserialize, Serialize};

use super::StimulusKind;

/// How Verilog and reference model are clocked.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// Long runs of photons in lanes and a part in lock-step, all else in lock-step.
    #[default]
    Auto,
    /// In lanes, or not at all.
    Lanes,
    /// In lock-step.
    Lockstep,
}

/// What an engine did of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct EnginePart {
    /// The engine.
    pub engine: Engine,
    /// What drove it.
    pub stimulus: StimulusKind,
    /// Clocks from the start on.
    pub clocks: u64,
    /// Lanes that shared them.
    pub lanes: Option<usize>,
    /// Clocks of the first 64 lanes, together, that Verilator's model of the same gates went
    /// through beside the compiler's vectors, with the same words in all registers.
    pub refereed_clocks: Option<u64>,
}

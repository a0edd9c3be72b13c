//! What a grade is asked for: the command line's options, the library's, and a shard's.

use serde::{Deserialize, Serialize};

use super::Bounds;
use crate::cosim::MOST_CLOCKS;
use crate::cosim::own::OwnRtl;

/// What is graded.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema, clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum GradeStimulus {
    /// The first four million clocks of a scan's photons.
    Photons,
    /// Inputs chosen to hurt, as in a co-simulation.
    #[value(alias = "hostile")]
    Adversarial,
    /// What the emitted testbench has recorded.
    Testbench,
}

/// What to grade, and how long it may take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct GradeOptions {
    /// The Verilog; the emitted one if none is given. A shard knows it by its SHA-256
    #[command(flatten)]
    #[serde(skip)]
    pub own: OwnRtl,
    /// What emitted files say that they were made by
    #[arg(skip)]
    #[serde(skip)]
    pub made_by: String,
    /// Stimulus to grade: the first 4 million clocks of photons, the adversarial stimulus of
    /// `cosim` up to its last cover point (also `hostile`), or that of the emitted testbench
    #[arg(long, value_enum, default_value_t = GradeOptions::default().stimulus)]
    pub stimulus: GradeStimulus,
    /// Clocks of the stimulus, reset included: --clocks 100000 [default: as many as it needs]
    #[arg(long, value_name = "N",
        value_parser = clap::value_parser!(u64).range(16..=MOST_CLOCKS))]
    pub clocks: Option<u64>,
    /// Mutants beside the stuck-at faults, 0 for none: --mutants 100
    #[arg(long, value_name = "N", default_value_t = GradeOptions::default().mutants,
        value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub mutants: u32,
    /// Time limit in seconds for the proof that a survivor is equivalent: --proof-time 20
    #[arg(long = "proof-time", value_name = "S",
        default_value_t = GradeOptions::default().proof_time_s,
        value_parser = clap::value_parser!(u32).range(1..=3_600))]
    pub proof_time_s: u32,
    /// Time limit in seconds for all these proofs together: --proof-budget 600
    #[arg(long = "proof-budget", value_name = "S",
        default_value_t = GradeOptions::default().proof_budget_s,
        value_parser = clap::value_parser!(u32).range(1..=86_400))]
    pub proof_budget_s: u32,
    /// Seed of the stimulus and of the choice of mutants
    #[arg(skip)]
    pub seed: u64,
    /// Exit with status 4 if a smaller share is caught, of faults or of mutants that are
    /// not proven equivalent: --at-least 99%
    #[arg(long = "at-least", value_name = "SHARE", value_parser = parse_share)]
    pub asked_fraction: Option<f64>,
}

impl Default for GradeOptions {
    fn default() -> GradeOptions {
        let bounds = Bounds::default();
        GradeOptions {
            own: OwnRtl::default(),
            made_by: crate::version::MADE_BY.to_owned(),
            stimulus: GradeStimulus::Adversarial,
            clocks: None,
            mutants: 1_000,
            proof_time_s: bounds.each_s,
            proof_budget_s: bounds.all_s,
            seed: 1,
            asked_fraction: None,
        }
    }
}

impl GradeOptions {
    /// How long the model checker may take.
    pub fn proof_bounds(&self) -> Bounds {
        Bounds { each_s: self.proof_time_s, all_s: self.proof_budget_s }
    }
}

/// A share of all: `99%` or `0.99`.
fn parse_share(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text.trim(), 1.0),
    };
    let share = number.trim().parse::<f64>().map_or(f64::NAN, |n| n * scale);
    if (0.0..=1.0).contains(&share) {
        Ok(share)
    } else {
        Err("write a share from 0% to 100%, as 99% or 0.99".to_owned())
    }
}

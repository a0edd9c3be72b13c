//! Ways of simulating a scene, from exact to cheap, and what they say.

pub mod compare;
pub mod scans;
pub mod simulate;

use serde::Serialize;

use crate::estimate::CountingTier;

/// How much of the sensor a simulation goes through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// Every detection, and the article's continuous-time counter.
    Events,
    /// Every detection, sampled, through the bit-exact reference model.
    Sampled,
    /// The same through the Verilog, compared at every clock.
    Rtl,
}

impl Tier {
    /// How this tier turns detections into counts.
    pub fn counting(self) -> CountingTier {
        match self {
            Tier::Events => CountingTier::Events,
            Tier::Sampled | Tier::Rtl => CountingTier::Sampled,
        }
    }
}

impl std::fmt::Display for Tier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Tier::Events => "events",
            Tier::Sampled => "sampled",
            Tier::Rtl => "rtl",
        })
    }
}

//! What a simulation is asked for: the command line's options, the library's, and a shard's.

use serde::{Deserialize, Serialize};

use super::Tier;
use crate::cosim::engine::Engine;
use crate::scene::EstimatorKind;

/// What to simulate.
///
/// ```
/// use goldtof::simulate::{SimulateOptions, Tier};
///
/// let options = Tier::Counts.scans(200).seeded(7);
/// let same = SimulateOptions { fidelity: Tier::Counts, repetitions: 200, seed: 7, ..options };
/// assert_eq!(options, same);
/// ```
#[derive(
    Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args,
)]
pub struct SimulateOptions {
    /// Scans of each detector, 1 to 1000000, for example --repeat 1000
    #[arg(long = "repeat", value_name = "R", default_value_t = SimulateOptions::default().repetitions,
        value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub repetitions: u64,
    /// Tier of simulation
    #[arg(long, value_name = "T", value_enum, default_value_t = SimulateOptions::default().fidelity)]
    pub fidelity: Tier,
    /// Co-simulation engine of the tier rtl
    #[arg(long, value_name = "E", value_enum, default_value_t = SimulateOptions::default().engine)]
    pub engine: Engine,
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Seed of all random numbers
    #[arg(skip)]
    pub seed: u64,
}

impl Tier {
    /// So many scans of this tier.
    pub fn scans(self, repetitions: u64) -> SimulateOptions {
        SimulateOptions { fidelity: self, repetitions, ..SimulateOptions::default() }
    }
}

impl SimulateOptions {
    /// The same with other random numbers.
    pub fn seeded(self, seed: u64) -> SimulateOptions {
        SimulateOptions { seed, ..self }
    }
}

impl Default for SimulateOptions {
    fn default() -> SimulateOptions {
        SimulateOptions {
            repetitions: 100,
            fidelity: Tier::Events,
            engine: Engine::Auto,
            estimator: None,
            seed: 1,
        }
    }
}

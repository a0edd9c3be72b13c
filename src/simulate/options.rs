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
/// let options = SimulateOptions { fidelity: Tier::Counts, repetitions: 200, ..Default::default() };
/// assert_eq!(options.seed, 1);
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

impl SimulateOptions {
    /// So many scans of a tier.
    pub fn of(fidelity: Tier, seed: u64, repetitions: u64) -> SimulateOptions {
        SimulateOptions { fidelity, seed, repetitions, ..SimulateOptions::default() }
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

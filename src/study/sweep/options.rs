//! What a sweep is asked for: the command line's options, the library's, a shard's, and what its
//! folder is known by.

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use crate::document::Body;
use crate::scene::EstimatorKind;
use crate::simulate::{SimulateOptions, Tier};

/// What a sweep's numbers depend on, beside the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct SweepOptions {
    /// A key and its values: a list, as --over 'path.distance=1 m, 2 m, 5 m'; values spaced evenly
    /// by ratio, 'source[0].mean_power=1 pW..64 pW x7'; or by difference,
    /// 'path.distance=1 m..10 m +10'. May be repeated, for every combination
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    #[schemars(with = "Vec<String>")]
    pub over: Vec<Axis>,
    /// Scans of each point, 1 to 1000000, for example --repeat 1000
    #[arg(long = "repeat", value_name = "R", default_value_t = SweepOptions::default().repetitions,
        value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub repetitions: u64,
    /// Tier of simulation
    #[arg(long, value_name = "T", value_enum, default_value_t = SweepOptions::default().fidelity)]
    pub fidelity: Tier,
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Seed of every point
    #[arg(skip)]
    pub seed: u64,
}

impl Default for SweepOptions {
    fn default() -> SweepOptions {
        let SimulateOptions { repetitions, fidelity, estimator, seed, .. } = Default::default();
        SweepOptions { over: Vec::new(), repetitions, fidelity, estimator, seed }
    }
}

impl Body for SweepOptions {
    const NAME: &'static str = "sweep-definition";
}

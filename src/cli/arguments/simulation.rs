//! Options of the commands that simulate a scene, or estimate from its counts.

use std::path::PathBuf;

use clap::Args;

use super::common::{CheckArgument, SceneArgument, ShardArguments};
use crate::cli::values::parse_shard;
use crate::scene::EstimatorKind;
use crate::shard::Part;
use crate::simulate::SimulateOptions;
use crate::study::sweep::SweepOptions;

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof simulate scenes/quick.toml --repeat 1000 --fidelity sampled"
)]
pub(in crate::cli) struct SimulateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: SimulateOptions,
    /// Write the expected count of each phase step, or bin of a histogram, and its
    /// standard deviation as CSV, for example --expected expected.csv
    #[arg(long, value_name = "FILE", conflicts_with = "shard")]
    pub expected: Option<PathBuf>,
    #[command(flatten)]
    pub check: CheckArgument,
    #[command(flatten)]
    pub shard: ShardArguments,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof sweep scenes/quick.toml \
    --over 'source[0].mean_power=1 pW..64 pW x7' --over 'path.distance=1 m, 2 m' --out out/sweep\n\n\
    A sweep that was interrupted resumes when it is started again.")]
pub(in crate::cli) struct SweepArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: SweepOptions,
    /// Folder for sweep.csv, sweep.parquet, sweep.svg and the finished points; made when
    /// missing, for example --out out/sweep
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub check: CheckArgument,
    /// Simulate one of N shards of the points, for `goldtof merge` to join: --shard 3/20, or
    /// --shard task/20 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Part>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof merge out/many")]
pub(in crate::cli) struct MergeArguments {
    /// Output folder of the shards
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Only list the missing shards, in the format of `sbatch --array`
    #[arg(long)]
    pub missing: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof estimate scenes/quick.toml out/quick/counts.csv --out out/residuals"
)]
pub(in crate::cli) struct EstimateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Counts of one scan, as `run` writes them: columns phase_step, count, and if
    /// there are any detector and total_count; or of one histogram: bin, count, detector
    pub counts: PathBuf,
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Folder for the residuals of each detector as CSV and as a plot; made when missing,
    /// for example --out out/residuals
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub check: CheckArgument,
}

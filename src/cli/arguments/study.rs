//! Options of the commands that run a study.

use std::path::PathBuf;

use clap::Args;

use super::common::{CheckArgument, SceneArgument, ShardArguments};
use crate::cli::values::{parse_error, parse_shard};
use crate::shard::Part;
use crate::study::reproduce::FigureId;

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof fidelity scenes/quick.toml --target-error 5% --out out/fidelity"
)]
pub(in crate::cli) struct FidelityArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Largest error of standard deviation, bias (in standard deviations) and share of
    /// missed peaks for a recommended tier, 0.01% to 99%: --target-error 5%, or 0.05
    #[arg(long, value_name = "E", default_value = "5%",
          value_parser = parse_error)]
    pub target_error: f64,
    /// Folder for fidelity.svg, sensor-trade.svg and their data as CSV; made when
    /// missing, for example --out out/fidelity
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Approximate run time in seconds, 1 to 86400, for example --budget-s 300
    #[arg(long, value_name = "S", default_value_t = 60,
          value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub budget_s: u64,
    #[command(flatten)]
    pub check: CheckArgument,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof compare-architectures scenes/quick.toml --out out/architectures"
)]
pub(in crate::cli) struct CompareArchitecturesArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for architectures.svg and architectures.csv; made when missing, for example
    /// --out out/architectures
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof reproduce --figure 8 --out out/article")]
pub(in crate::cli) struct ReproduceArguments {
    /// One figure, with the claims that it decides [default: all]
    #[arg(long, value_name = "N", value_enum)]
    pub figure: Option<FigureId>,
    /// Folder for the figures (SVG) and their data (CSV); made when missing, for
    /// example --out out/article
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Scans of 1.04 ms per phase step behind each standard deviation and bias, 2 to
    /// 1000000, for example --repeat 2000
    #[arg(long, value_name = "R", default_value_t = 500,
          value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub repeat: u64,
    /// Make one of N shards of the figures, for `goldtof merge` to join: --shard 3/12, or
    /// --shard task/12 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Part>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof stress --quick")]
pub(in crate::cli) struct StressArguments {
    /// One case, for example --case no-light-at-all [default: all]
    #[arg(long, value_name = "NAME", conflicts_with = "quick")]
    pub case: Option<String>,
    /// The fast subset
    #[arg(long)]
    pub quick: bool,
    /// List the cases without running them
    #[arg(long, conflicts_with = "shard")]
    pub list: bool,
    #[command(flatten)]
    pub shard: ShardArguments,
}

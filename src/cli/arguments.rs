//! The command line: its commands, and the options that several of them share. The others stand
//! beside their command, or are a job's own (`SimulateOptions` and the like).

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Parser, Subcommand};

use super::codes::CodesArguments;
use super::compare_architectures::CompareArchitecturesArguments;
use super::cosim::CosimArguments;
use super::emit::EmitArguments;
use super::estimate::EstimateArguments;
use super::fidelity::FidelityArguments;
use super::grade::GradeArguments;
use super::manual::{CompletionsArguments, ManArguments};
use super::merge::MergeArguments;
use super::new::NewArguments;
use super::reproduce::ReproduceArguments;
use super::run::RunArguments;
use super::simulate::SimulateArguments;
use super::stress::StressArguments;
use super::sweep::SweepArguments;
use super::values::{parse_shard, parse_time};
use crate::cosim::MOST_CLOCKS;
use crate::printable::{printable, printable_path, shell_word};
use crate::scene::{self, Scene, SceneErrors, Setting};
use crate::shard::Part;

/// Verilog, co-simulation and photon-level simulation of DS-CDMA indirect
/// time-of-flight sensors.
#[derive(Debug, Parser)]
#[command(name = "goldtof", version = crate::version::VERSION, propagate_version = true, color = super::output::clap_colours())]
pub(super) struct Cli {
    /// Print one JSON document, and nothing else, on stdout
    #[arg(long, global = true)]
    pub json: bool,
    /// Seed of all random numbers, 0 to 18446744073709551615, for example --seed 7
    #[arg(long, global = true, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Print no progress and no summary
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Time limit for an external tool, or for a block of clocks of the Verilog: a
    /// number with its unit (s, min or h), 0.001 s to 24000 h, for example
    /// --tool-timeout 90s
    #[arg(long, global = true, value_name = "TIME", default_value = "10min",
          value_parser = parse_time)]
    pub tool_timeout: Duration,
    /// Cache folder for built models [default: $GOLDTOF_CACHE_DIR, or
    /// goldtof in the user's folder for caches], for example --cache target/models
    #[arg(long, global = true, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Plan, emit, simulate photons, co-simulate, estimate, report: the main job
    Run(RunArguments),
    /// Show what a scene keeps and leaves out, and why
    #[command(after_help = "Example: goldtof plan scenes/quick.toml")]
    Plan(SceneArgument),
    /// Show a code and its correlation properties
    Codes(CodesArguments),
    /// Write the Verilog of a scene, with testbench, constraints and file lists
    Emit(EmitArguments),
    /// Compare Verilog with the reference model, clock by clock
    Cosim(CosimArguments),
    /// Measure the fault coverage of a stimulus
    Grade(GradeArguments),
    /// Simulate scans, photons to distance: bias and standard deviation
    Simulate(SimulateArguments),
    /// Simulate a scene over ranges of its keys: a table and a plot
    Sweep(SweepArguments),
    /// Join the shards of a command, as if it had run as one
    Merge(MergeArguments),
    /// Write a commented scene to start from
    New(NewArguments),
    /// Estimate distances from recorded counts, with residuals and a diagnosis
    Estimate(EstimateArguments),
    /// Measure error against run time for every tier of simulation
    Fidelity(FidelityArguments),
    /// Compare sensors: one phase step at a time, sixteen, or a histogram
    CompareArchitectures(CompareArchitecturesArguments),
    /// Reproduce the article's figures and claims, and the errors it leaves out
    Reproduce(ReproduceArguments),
    /// Run stiff and extreme cases, each held to its bound
    Stress(StressArguments),
    /// Print completions for a shell
    Completions(CompletionsArguments),
    /// Write manual pages, one for each command
    Man(ManArguments),
}

#[derive(Debug, Args)]
pub(super) struct SceneArgument {
    /// Scene file (TOML), for example scenes/paper-single.toml
    pub scene: PathBuf,
    /// Override a key of the file; may be repeated. Several tables are told
    /// apart by number or name: --set 'path[0].distance=5 m' --set 'source[laser].mean_power=1 pW'
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
}

impl SceneArgument {
    /// The scene, with its settings.
    ///
    /// # Errors
    /// If it cannot be read, and everything that is wrong with it.
    pub fn load(&self) -> Result<Scene, SceneErrors> {
        scene::load_with(&self.scene, &self.settings)
    }

    /// [`SceneArgument::load`], and the file's text.
    ///
    /// # Errors
    /// As there.
    pub fn load_with_text(&self) -> Result<(Scene, String), SceneErrors> {
        scene::load_with_text(&self.scene, &self.settings)
    }

    /// The file's name and the settings, as a command line has them. Where the file lies
    /// is left out, so that what is made does not depend on it.
    pub fn shown(&self) -> String {
        let name = self.scene.file_name().unwrap_or_default();
        let mut shown = shell_word(&printable_path(Path::new(name))).into_owned();
        for setting in &self.settings {
            let origin = printable(setting.origin());
            let (option, set) = origin.split_once(' ').unwrap_or(("", &origin));
            shown += &format!(" {option} {}", shell_word(set));
        }
        shown
    }
}

/// Which part of the work, and where it goes.
pub(super) struct Order<'a> {
    /// Which part.
    pub part: Part,
    /// The folder of the job's shards is in this one.
    pub out: &'a Path,
}

/// Whether the exit status reports a contradicted expectation.
#[derive(Debug, Args)]
pub(super) struct CheckArgument {
    /// Exit with status 1 if scans contradict their expected bias, standard deviation or
    /// share of missed peaks, or recorded counts their scene
    #[arg(long)]
    pub check: bool,
}

/// A shard of the work, of a command without an output folder of its own.
#[derive(Debug, Args)]
pub(super) struct ShardArguments {
    /// Do one of N shards of the work, for `goldtof merge` to join: --shard 3/20, or
    /// --shard task/20 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard, requires = "out")]
    pub shard: Option<Part>,
    /// Folder for the shards; made when missing, for example --out out/many
    #[arg(long, value_name = "DIR", requires = "shard")]
    pub out: Option<PathBuf>,
}

impl ShardArguments {
    /// Which part, and where it goes, if only a part is asked for.
    pub fn order(&self) -> Option<Order<'_>> {
        let (part, out) = (self.shard?, self.out.as_deref()?);
        Some(Order { part, out })
    }
}

/// A window of clocks for waveforms.
#[derive(Debug, Args)]
pub(super) struct VcdWindow {
    /// First clock of the waveforms, reset included, 0 to 2^50 [default: 0 with --vcd-clocks,
    /// else a thousand before the first mismatch or result], for example --vcd-from 100000
    #[arg(long, value_name = "CLOCK", value_parser = clap::value_parser!(u64).range(0..=MOST_CLOCKS))]
    pub vcd_from: Option<u64>,
    /// Clocks of the waveforms, 1 to 1000000 [default: 2000], for example --vcd-clocks 500
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub vcd_clocks: Option<u64>,
}

impl VcdWindow {
    /// Clocks of a window without a length.
    const CLOCKS: u64 = 2000;

    /// The window, if one was given.
    pub fn clocks(&self) -> Option<Range<u64>> {
        if self.vcd_from.is_none() && self.vcd_clocks.is_none() {
            return None;
        }
        let from = self.vcd_from.unwrap_or(0);
        Some(from..from + self.vcd_clocks.unwrap_or(VcdWindow::CLOCKS))
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    /// Each option with free values has an example in its help.
    #[test]
    fn every_option_and_every_command_has_an_example() {
        let mut command = super::Cli::command();
        command.build();
        let mut checked = 0;
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            let more = sub.get_after_help().map(ToString::to_string);
            let example = format!("Example: goldtof {} ", sub.get_name());
            assert!(more.unwrap_or_default().starts_with(&example), "{example}");
            let options = sub.get_arguments().filter(|option| option.get_long().is_some());
            for option in options.filter(|option| option.get_action().takes_values()) {
                let name = format!("--{}", option.get_long().unwrap_or_default());
                let help = option.get_help().map(ToString::to_string).unwrap_or_default();
                let has_example = help.contains(&format!("{name} "));
                let is_choice = !option.get_possible_values().is_empty();
                assert!(has_example || is_choice, "{} {name}: {help}", sub.get_name());
                checked += 1;
            }
        }
        assert!(checked > 60, "{checked}");
    }

    #[test]
    fn the_argument_tree_is_sound() {
        super::Cli::command().debug_assert();
    }
}

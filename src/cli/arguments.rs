//! The command line and its commands. The options of a command stand beside it, or are the job's own
//! (`SimulateOptions` and the like).

use std::time::Duration;

use clap::{Parser, Subcommand};

use super::common::{self, parse_time};
use super::prelude::*;
use super::{
    calibrate, compare_architectures, cosim, emit, estimate, explain, fidelity, grade, image, new,
    pulses, replay, reproduce, run, shards, simulate, stress, sweep,
};
use crate::code::{CodeSpec, report};
use crate::plan::overview::overview;
use crate::report::plan::text;

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
    pub command: Commands,
}

/// Declares the commands: what each does, its name, and its arguments.
macro_rules! commands {
    ($($(#[$about:meta])* $name:ident($arguments:ty);)*) => {
        #[derive(Debug, Subcommand)]
        pub(super) enum Commands { $($(#[$about])* $name($arguments),)* }

        impl Command for Commands {
            fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
                match self { $(Commands::$name(arguments) => arguments.run(seed, output),)* }
            }
        }
    };
}

commands! {
    /// Plan, emit, simulate photons, co-simulate, estimate, report: the main job
    Run(run::RunArguments);
    /// Show what a scene keeps and leaves out, and why
    #[command(after_help = "Example: goldtof plan scenes/quick.toml")]
    Plan(common::SceneArgument);
    /// Show what limits a detector, and what each key would bring
    Explain(explain::ExplainArguments);
    /// Make an image of what an array of pixels sees
    Image(image::ImageArguments);
    /// Show a code and its correlation properties
    #[command(after_help = "Example: goldtof codes --degree 11 --index 3 --interleave 1")]
    Codes(CodeSpec);
    /// Write the Verilog of a scene, with testbench, constraints and file lists
    Emit(emit::EmitArguments);
    /// Compare Verilog with the reference model, clock by clock
    Cosim(cosim::CosimArguments);
    /// Measure the fault coverage of a stimulus
    Grade(grade::GradeArguments);
    /// Simulate scans, photons to distance: bias and standard deviation
    Simulate(simulate::SimulateArguments);
    /// Simulate a scene over ranges of its keys: a table and a plot
    Sweep(sweep::SweepArguments);
    /// Join the shards of a command, as if it had run as one
    Merge(shards::MergeArguments);
    /// Write a commented scene to start from
    New(new::NewArguments);
    /// Estimate distances from recorded counts, with residuals and a diagnosis
    Estimate(estimate::EstimateArguments);
    /// Measure when samples are taken, from recorded dark counts
    Calibrate(calibrate::CalibrateArguments);
    /// Replay photons that an instrument recorded: histogram, counts, distances
    Replay(replay::ReplayArguments);
    /// Write the sampled pulses of simulated photons, for a simulated board
    Pulses(pulses::PulsesArguments);
    /// Measure error against run time for every tier of simulation
    Fidelity(fidelity::FidelityArguments);
    /// Compare sensors: one phase step at a time, sixteen, or a histogram
    CompareArchitectures(compare_architectures::CompareArchitecturesArguments);
    /// Reproduce the article's figures and claims, and the errors it leaves out
    Reproduce(reproduce::ReproduceArguments);
    /// Run stiff and extreme cases, each held to its bound
    Stress(stress::StressArguments);
    /// Print completions for a shell
    Completions(CompletionsArguments);
    /// Write manual pages, one for each command
    Man(ManArguments);
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof completions bash > \
    ~/.local/share/bash-completion/completions/goldtof")]
pub(super) struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof man --out ~/.local/share/man/man1")]
pub(super) struct ManArguments {
    /// Folder for goldtof.1 and a page for each command; created if missing, for example
    /// --out man
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl Command for SceneArgument {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sensor = self.sensor(output)?;
        let overview = overview(&sensor);
        output.answer(
            Some(sensor.scene().reference()),
            &overview,
            &text(&overview, terminal_width()),
        )
    }
}

impl Command for CodeSpec {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let report = report(self)?;
        output.answer(None, &report, &report.to_text())
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
            for option in options.filter(takes_values) {
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

    fn takes_values(option: &&clap::Arg) -> bool {
        option.get_num_args().is_some_and(|number| number.takes_values())
    }

    #[test]
    fn the_argument_tree_is_sound() {
        super::Cli::command().debug_assert();
    }
}

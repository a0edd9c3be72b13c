//! What the commands take that make Verilog, check it, or grade a stimulus on it.

use std::ops::Range;
use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::common::{CheckArgument, SceneArgument, ShardArguments};
use crate::cli::values::{MOST_CLOCKS, parse_latency, parse_share};
use crate::cosim::StimulusKind;
use crate::cosim::engine::Engine;
use crate::cosim::latency::Latency;
use crate::cosim::own::OwnRtl;
use crate::deliver::Prefix;
use crate::grade::{Bounds, GradeStimulus};
use crate::scene::EstimatorKind;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof run scenes/quick.toml --out out/quick")]
pub(in crate::cli) struct RunArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for the Verilog, counts.csv and report.html; made when missing,
    /// for example --out out/quick
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How counts become distances [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    #[command(flatten)]
    pub check: CheckArgument,
    /// With one of these waves.vcd is written as well
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// How Verilog and reference model are clocked
    #[arg(long, value_name = "E", value_enum, default_value_t = Engine::Auto)]
    pub engine: Engine,
    /// Grade the adversarial stimulus on the Verilog, too, with every stuck-at fault and
    /// 0 to 10,000 mutants: the report says how strong a match is, for example --grade or
    /// --grade=100 [default: no grade; 0 mutants]
    #[arg(long, value_name = "MUTANTS", num_args = 0..=1, require_equals = true,
          default_missing_value = "0", hide_default_value = true,
          value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub grade: Option<u32>,
    /// Write what the co-simulation found as a JUnit report, too, for example
    /// --junit run.xml
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof emit scenes/quick.toml --out rtl")]
pub(in crate::cli) struct EmitArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for the Verilog and manifest.json; made when missing, for example
    /// --out rtl
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What the names of all modules, files and macros begin with, so that several
    /// sensors can be in one design: a letter, then letters, digits and single
    /// underscores, at most 64 characters, for example --prefix left_ [default: none]
    #[arg(long, value_name = "NAME")]
    pub prefix: Option<Prefix>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof cosim scenes/quick.toml --rtl rtl --stimulus adversarial")]
pub(in crate::cli) struct CosimArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub own: OwnArguments,
    /// Clocks after which the Verilog's results come: "auto" for its own, N, or N,P with
    /// those of the peak, for example --latency 7 [default: the emitted design's]
    #[arg(long, value_name = "L", default_value = "", hide_default_value = true,
          value_parser = parse_latency)]
    pub latency: Latency,
    /// Clocks to run, reset included, 1 to 2^50, for example --clocks 100000 [default: one
    /// whole scan of photons, or as long as the adversary needs]
    #[arg(long, alias = "cycles", value_name = "N",
          value_parser = clap::value_parser!(u64).range(1..=MOST_CLOCKS))]
    pub clocks: Option<u64>,
    /// What drives both sides
    #[arg(long, value_enum, default_value_t = StimulusKind::Photons)]
    pub stimulus: StimulusKind,
    /// How both sides are clocked: long runs of photons in lanes, that is 64 time slices
    /// of the scan and more at once, else in lock-step
    #[arg(long, value_name = "E", value_enum, default_value_t = Engine::Auto)]
    pub engine: Engine,
    /// Write waveforms of all ports, both sides, round the first mismatch (or the first
    /// result when there is none), with views for GTKWave and Surfer beside them, for
    /// example --vcd ports.vcd
    #[arg(long, value_name = "FILE")]
    pub vcd: Option<PathBuf>,
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// Write the verdict as a JUnit report, too: a case for each output port, each family
    /// of cover points and the stimulus, for example --junit cosim.xml
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// Other clocks of waveforms than those round what was found.
#[derive(Debug, Args)]
pub(in crate::cli) struct VcdWindow {
    /// First clock of the waveforms, reset included, 0 to 2^50 [default: 0 with --vcd-clocks,
    /// else a thousand before the first mismatch or result], for example --vcd-from 100000
    #[arg(long, value_name = "CLOCK", value_parser = clap::value_parser!(u64).range(0..=MOST_CLOCKS))]
    pub vcd_from: Option<u64>,
    /// Clocks of the waveforms, 1 to 1000000 [default: 2000], for example --vcd-clocks 500
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub vcd_clocks: Option<u64>,
}

impl VcdWindow {
    /// Clocks of waveforms that have a beginning and no length.
    const CLOCKS: u64 = 2000;

    /// The clocks that were asked for, if any were.
    pub fn clocks(&self) -> Option<Range<u64>> {
        if self.vcd_from.is_none() && self.vcd_clocks.is_none() {
            return None;
        }
        let from = self.vcd_from.unwrap_or(0);
        Some(from..from + self.vcd_clocks.unwrap_or(VcdWindow::CLOCKS))
    }
}

/// Verilog to check in place of the emitted one.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("own").args(["rtl", "filelist"]).multiple(true))]
pub(in crate::cli) struct OwnArguments {
    /// Folder of Verilog to check in place of the emitted one, with the same ports: a
    /// manifest.json there names its files, else those of it and its subfolders that the
    /// top module needs are taken, for example --rtl my_rtl
    #[arg(long, value_name = "DIR")]
    pub rtl: Option<PathBuf>,
    /// List of files and options of the Verilog to check, as simulators take it with -f;
    /// may be repeated. Paths are relative to the list's folder, for example
    /// --filelist my_rtl/files.f
    #[arg(long, value_name = "FILE")]
    pub filelist: Vec<PathBuf>,
    /// Top module of the Verilog to check, for example --top my_top [default: sensor_top]
    #[arg(long, value_name = "NAME", requires = "own")]
    pub top: Option<String>,
    /// Folder in which files that the Verilog includes are looked for first; may be
    /// repeated, for example --include my_rtl/include
    #[arg(short = 'I', long = "include", value_name = "DIR", requires = "own")]
    pub include: Vec<PathBuf>,
    /// Macro for the Verilog to check; may be repeated, for example --define WIDTH=8
    #[arg(short = 'D', long = "define", value_name = "NAME[=VALUE]", requires = "own")]
    pub define: Vec<String>,
}

impl OwnArguments {
    /// The Verilog to check, if it is not the emitted one.
    pub fn rtl(&self) -> Option<OwnRtl> {
        (self.rtl.is_some() || !self.filelist.is_empty()).then(|| OwnRtl {
            folder: self.rtl.clone(),
            file_lists: self.filelist.clone(),
            top: self.top.clone(),
            include_folders: self.include.clone(),
            defines: self.define.clone(),
        })
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof grade scenes/quick.toml --stimulus testbench --at-least 98%"
)]
pub(in crate::cli) struct GradeArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub own: OwnArguments,
    /// What is graded: the first 4 million clocks of photons, the inputs
    /// chosen to hurt of `cosim` (also `hostile`), or those of the emitted testbench
    #[arg(long, value_enum, default_value_t = GradeStimulus::Adversarial)]
    pub stimulus: GradeStimulus,
    /// Its clocks, reset included: --clocks 100000 [default: as many as it takes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(16..=MOST_CLOCKS))]
    pub clocks: Option<u64>,
    /// Mutants beside the stuck-at faults, 0 for none: --mutants 100
    #[arg(long, value_name = "N", default_value_t = 1_000,
          value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub mutants: u32,
    /// Seconds to prove that one that is not caught is equivalent: --proof-time 20
    #[arg(long, value_name = "S", default_value_t = Bounds::default().each_s,
          value_parser = clap::value_parser!(u32).range(1..=3_600))]
    pub proof_time: u32,
    /// Seconds for all these proofs together: --proof-budget 600
    #[arg(long, value_name = "S", default_value_t = Bounds::default().all_s,
          value_parser = clap::value_parser!(u32).range(1..=86_400))]
    pub proof_budget: u32,
    /// End with exit status 4 if fewer are caught, of faults or of mutants that are not
    /// proven equivalent: --at-least 99%
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub at_least: Option<f64>,
    #[command(flatten)]
    pub shard: ShardArguments,
}

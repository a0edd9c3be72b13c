//! Options of the commands that emit Verilog, check it, or grade a stimulus.

use std::ops::Range;
use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::common::{CheckArgument, SceneArgument, ShardArguments};
use crate::cli::values::parse_latency;
use crate::cosim::MOST_CLOCKS;
use crate::cosim::StimulusKind;
use crate::cosim::engine::Engine;
use crate::cosim::latency::Latency;
use crate::cosim::own::OwnRtl;
use crate::deliver::Prefix;
use crate::grade::GradeOptions;
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
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    #[command(flatten)]
    pub check: CheckArgument,
    /// With either of these waves.vcd is written, too
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// Co-simulation engine
    #[arg(long, value_name = "E", value_enum, default_value_t = Engine::Auto)]
    pub engine: Engine,
    /// Also grade the adversarial stimulus on the Verilog, with every stuck-at fault and
    /// 0 to 10,000 mutants, so that the report states the strength of a match, for example
    /// --grade or --grade=100 [default: no grade; 0 mutants]
    #[arg(long, value_name = "MUTANTS", num_args = 0..=1, require_equals = true,
          default_missing_value = "0", hide_default_value = true,
          value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub grade: Option<u32>,
    /// Also write the result of the co-simulation as a JUnit report, for example
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
    /// Prefix of the names of all modules, files and macros, so that one design can hold
    /// several sensors: a letter, then letters, digits and single underscores, at most
    /// 64 characters, for example --prefix left_ [default: none]
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
    /// Latency of the Verilog's results in clocks: "auto" to measure it, N, or N,P with
    /// that of the peak, for example --latency 7 [default: the emitted design's]
    #[arg(long, value_name = "L", default_value = "", hide_default_value = true,
          value_parser = parse_latency)]
    pub latency: Latency,
    /// Clocks to run, reset included, 1 to 2^50, for example --clocks 100000 [default: one
    /// whole scan of photons, or as many as the adversarial stimulus needs]
    #[arg(long, alias = "cycles", value_name = "N",
          value_parser = clap::value_parser!(u64).range(1..=MOST_CLOCKS))]
    pub clocks: Option<u64>,
    /// Stimulus of both sides
    #[arg(long, value_enum, default_value_t = StimulusKind::Photons)]
    pub stimulus: StimulusKind,
    /// Co-simulation engine: lanes run 64 or more time slices of the scan in parallel;
    /// auto takes them for long photon runs, and lock-step otherwise
    #[arg(long, value_name = "E", value_enum, default_value_t = Engine::Auto)]
    pub engine: Engine,
    /// Write waveforms of all ports, both sides, round the first mismatch (or the first
    /// result if there is none), with views for GTKWave and Surfer, for example
    /// --vcd ports.vcd
    #[arg(long, value_name = "FILE")]
    pub vcd: Option<PathBuf>,
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// Also write the verdict as a JUnit report: a case for each output port, each family
    /// of cover points and the stimulus, for example --junit cosim.xml
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// A window of clocks for waveforms.
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

/// The Verilog to check, if not the emitted one.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("own").args(["rtl", "filelist"]).multiple(true))]
pub(in crate::cli) struct OwnArguments {
    /// Folder with Verilog to check in place of the emitted one, with the same ports. Its
    /// files are those that a manifest.json there lists, else those below it that the top
    /// module needs, for example --rtl my_rtl
    #[arg(long, value_name = "DIR")]
    pub rtl: Option<PathBuf>,
    /// File list of the Verilog to check, as for the option -f of simulators; may be
    /// repeated. Paths are relative to the list's folder, for example
    /// --filelist my_rtl/files.f
    #[arg(long, value_name = "FILE")]
    pub filelist: Vec<PathBuf>,
    /// Top module of the Verilog to check, for example --top my_top [default: sensor_top]
    #[arg(long, value_name = "NAME", requires = "own")]
    pub top: Option<String>,
    /// Folder to search first for included files; may be repeated, for example
    /// --include my_rtl/include
    #[arg(short = 'I', long = "include", value_name = "DIR", requires = "own")]
    pub include: Vec<PathBuf>,
    /// Macro to define for the Verilog to check; may be repeated, for example
    /// --define WIDTH=8
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
    #[command(flatten)]
    pub options: GradeOptions,
    #[command(flatten)]
    pub shard: ShardArguments,
}

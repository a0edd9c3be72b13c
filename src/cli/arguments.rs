//! What can be written on the command line.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{ArgGroup, Args, Parser, Subcommand};

use super::shards::Order;
use super::values::{Like, parse_error};
use crate::code::Family;
use crate::cosim::StimulusKind;
use crate::cosim::engine::Engine;
use crate::cosim::latency::Latency;
use crate::cosim::own::OwnRtl;
use crate::deliver::Prefix;
use crate::grade::{Bounds, GradeStimulus};
use crate::printable::{printable, printable_path};
use crate::scene::{self, EstimatorKind, Scene, SceneErrors, Setting};
use crate::shard::Part;
use crate::simulate::Tier;
use crate::study::reproduce::FigureId;
use crate::study::sweep::Axis;

/// Most clocks of a co-simulation: years of them, whose samples 64 bits number.
const MOST_CLOCKS: u64 = 1 << 50;

/// Verilog, co-simulation and photon-level simulation of DS-CDMA indirect
/// time-of-flight sensors.
#[derive(Debug, Parser)]
#[command(name = "goldtof", version = crate::version::VERSION, propagate_version = true)]
pub(super) struct Cli {
    /// Print one JSON document on stdout, and nothing else there
    #[arg(long, global = true)]
    pub json: bool,
    /// Seed of all random numbers, 0 to 18446744073709551615, for example --seed 7
    #[arg(long, global = true, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Print no progress and no summary
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Longest time that an external tool, or a block of clocks of the Verilog, may
    /// take: a number with its unit (s, min or h), 0.001 s to 24000 h, for example
    /// --tool-timeout 90s
    #[arg(long, global = true, value_name = "TIME", default_value = "10min",
          value_parser = parse_time)]
    pub tool_timeout: Duration,
    /// Folder for built models, which later runs find again [default: $GOLDTOF_CACHE_DIR, or
    /// goldtof in the user's folder for caches], for example --cache target/models
    #[arg(long, global = true, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    #[command(subcommand)]
    pub command: Command,
}

/// Longest time that can be asked for: 1000 days.
const MOST_SECONDS: f64 = 1000.0 * 86_400.0;

fn parse_time(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit_s = match &text[digits.len()..] {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => {
            return Err(
                "write a number with its unit, as \"90 s\", \"10min\" or \"2h\"".to_owned(),
            );
        }
    };
    let seconds = digits
        .trim()
        .parse::<f64>()
        .map_or(f64::NAN, |n| n * unit_s);
    // Neither is one that is no number.
    if (1e-3..=MOST_SECONDS).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!(
            "write a time from 0.001 s to {} h",
            MOST_SECONDS / 3600.0
        ))
    }
}

/// `--shard`, which may ask for the number of the present task.
fn parse_shard(text: &str) -> Result<Part, String> {
    Part::parse(text, |name| std::env::var(name).ok())
}

/// A part of the work, of a command that has no folder otherwise.
#[derive(Debug, Args)]
pub(super) struct ShardArguments {
    /// Do one of N parts of the work, on this machine or another, for `goldtof merge` to
    /// join: --shard 3/20, or --shard task/20 in a task of an array (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard, requires = "out")]
    pub shard: Option<Part>,
    /// Folder for the shards of all parts; made when missing, for example --out out/many
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

fn parse_latency(text: &str) -> Result<Latency, String> {
    match text {
        "" => Ok(Latency::Emitted),
        text => text.parse(),
    }
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// The main job: plan, emit, simulate photons, co-simulate, estimate, report
    Run(RunArguments),
    /// What is kept and what is left out for a scene, and why
    #[command(after_help = "Example: goldtof plan scenes/quick.toml")]
    Plan(SceneArgument),
    /// A code and its correlation properties
    Codes(CodesArguments),
    /// Write the Verilog for a scene, and what goes with it
    Emit(EmitArguments),
    /// Run Verilog and the reference model in lock-step
    Cosim(CosimArguments),
    /// How many faults and mutants of a design a stimulus would find
    Grade(GradeArguments),
    /// Photons to distance, many times: bias and standard deviation
    Simulate(SimulateArguments),
    /// A scene over and over, with some of its keys otherwise: a table and a plot
    Sweep(SweepArguments),
    /// What the shards of a command say together, as if it had run as one
    Merge(MergeArguments),
    /// A scene to start from, with comments
    New(NewArguments),
    /// Recorded counts to distance, with residuals and what seems wrong
    Estimate(EstimateArguments),
    /// Error against run time for every way of simulating
    Fidelity(FidelityArguments),
    /// Which sensor to build: one phase step after another, sixteen at once, or a histogram
    CompareArchitectures(CompareArchitecturesArguments),
    /// The article's figures and claims, and the errors it leaves out
    Reproduce(ReproduceArguments),
    /// Stiff and extreme cases, each with what is measured and its bound
    Stress(StressArguments),
    /// Completions for a shell, on stdout
    Completions(CompletionsArguments),
    /// Manual pages, one for each command
    Man(ManArguments),
}

#[derive(Debug, Args)]
pub(super) struct SceneArgument {
    /// Scene file (TOML), for example scenes/paper-single.toml
    pub scene: PathBuf,
    /// Set a key otherwise than the file has it; may be repeated. Of several tables say
    /// which: --set 'path[0].distance=5 m' --set 'source[laser].mean_power=1 pW'
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
        let mut shown = printable_path(Path::new(name));
        for setting in &self.settings {
            let origin = printable(setting.origin());
            let (option, set) = origin.split_once(' ').unwrap_or(("", &origin));
            shown += &format!(" {option} '{}'", set.replace('\'', "'\\''"));
        }
        shown
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof run scenes/quick.toml --out out/quick")]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for the Verilog, counts.csv and report.html; made when missing,
    /// for example --out out/quick
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How counts become distances [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// With one of these waves.vcd is written as well
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// How Verilog and reference model are clocked
    #[arg(long, value_name = "E", value_enum, default_value_t = Engine::Auto)]
    pub engine: Engine,
    /// Write what the co-simulation found as a JUnit report, too, for example
    /// --junit run.xml
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof emit scenes/quick.toml --out rtl")]
pub(super) struct EmitArguments {
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
pub(super) struct CosimArguments {
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
pub(super) struct OwnArguments {
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
    #[arg(
        short = 'D',
        long = "define",
        value_name = "NAME[=VALUE]",
        requires = "own"
    )]
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
pub(super) struct GradeArguments {
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
    #[arg(long, value_name = "SHARE", value_parser = super::grade::parse_share)]
    pub at_least: Option<f64>,
    #[command(flatten)]
    pub shard: ShardArguments,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof simulate scenes/quick.toml --repeat 1000 --fidelity sampled"
)]
pub(super) struct SimulateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Scans to simulate, 1 to 1000000, for example --repeat 1000
    #[arg(long, value_name = "R", default_value_t = 100,
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub repeat: u64,
    /// How much of the sensor to simulate
    #[arg(long, value_name = "T", value_enum, default_value_t = Tier::Events)]
    pub fidelity: Tier,
    /// How the Verilog is clocked, where it is (rtl)
    #[arg(long, value_name = "E", value_enum, default_value_t = Engine::Auto)]
    pub engine: Engine,
    /// Write what each phase step, or bin of a histogram, is expected to count, with its
    /// standard deviation, as CSV, for example --expected expected.csv
    #[arg(long, value_name = "FILE", conflicts_with = "shard")]
    pub expected: Option<PathBuf>,
    /// How counts become distances [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    #[command(flatten)]
    pub shard: ShardArguments,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof sweep scenes/quick.toml \
    --over 'source[0].mean_power=1 pW..64 pW x7' --over 'path.distance=1 m, 2 m' --out out/sweep\n\n\
    A sweep that was cut off goes on where it stopped when it is started again.")]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// A key and its values: a list, as --over 'path.distance=1 m, 2 m, 5 m'; values spaced evenly
    /// by ratio, 'source[0].mean_power=1 pW..64 pW x7'; or by difference,
    /// 'path.distance=1 m..10 m +10'. Repeated, every combination is taken
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub over: Vec<Axis>,
    /// Scans of each point, 1 to 1000000, for example --repeat 1000
    #[arg(long, value_name = "R", default_value_t = 100,
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub repeat: u64,
    /// How much of the sensor to simulate
    #[arg(long, value_name = "T", value_enum, default_value_t = Tier::Events)]
    pub fidelity: Tier,
    /// How counts become distances [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Folder for sweep.csv, sweep.svg and the finished points; made when missing,
    /// for example --out out/sweep
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Do one of N parts of the points, on this machine or another, for `goldtof merge` to
    /// join: --shard 3/20, or --shard task/20 in a task of an array (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Part>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof merge out/many")]
pub(super) struct MergeArguments {
    /// Folder that the shards were written to, with --out
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Only say which shards are not there, as `sbatch --array` takes their numbers
    #[arg(long)]
    pub missing: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof new my-sensor --like multipath")]
pub(super) struct NewArguments {
    /// Name of the scene: NAME.toml is written into the present folder, or wherever
    /// NAME leads
    pub name: PathBuf,
    /// The standard scene to begin with in place of a short one
    #[arg(long, value_name = "SCENE", value_enum)]
    pub like: Option<Like>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof completions bash > \
    ~/.local/share/bash-completion/completions/goldtof")]
pub(super) struct CompletionsArguments {
    /// The shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof man --out ~/.local/share/man/man1")]
pub(super) struct ManArguments {
    /// Folder for goldtof.1 and a page for each command; made when missing, for example
    /// --out man
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof estimate scenes/quick.toml out/quick/counts.csv --out out/residuals"
)]
pub(super) struct EstimateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Counts of one scan, as `run` writes them: columns phase_step, count, and if
    /// there are any detector and total_count; or of one histogram: bin, count, detector
    pub counts: PathBuf,
    /// How counts become distances [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Folder for the residuals as CSV and as a plot, a file for each detector; made
    /// when missing, for example --out out/residuals
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof fidelity scenes/quick.toml --target-error 5% --out out/fidelity"
)]
pub(super) struct FidelityArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Error of standard deviation, bias (in standard deviations) and share of missed
    /// peaks to recommend a tier for, 0.01% to 99%: --target-error 5%, or 0.05
    #[arg(long, value_name = "E", default_value = "5%",
          value_parser = parse_error)]
    pub target_error: f64,
    /// Folder for fidelity.svg, sensor-trade.svg and their data as CSV; made when
    /// missing, for example --out out/fidelity
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seconds to spend, about, 1 to 86400, for example --budget-s 300
    #[arg(long, value_name = "S", default_value_t = 60,
          value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub budget_s: u64,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof compare-architectures scenes/quick.toml --out out/architectures"
)]
pub(super) struct CompareArchitecturesArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for architectures.svg and architectures.csv; made when missing, for example
    /// --out out/architectures
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof reproduce --figure 8 --out out/article")]
pub(super) struct ReproduceArguments {
    /// The one figure to make, with the claims that it decides [default: all]
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
    /// Do one of N parts of the figures, on this machine or another, for `goldtof merge` to
    /// join: --shard 3/12, or --shard task/12 in a task of an array (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Part>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof stress --quick")]
pub(super) struct StressArguments {
    /// The one case to run, for example --case no-light-at-all [default: all]
    #[arg(long, value_name = "NAME", conflicts_with = "quick")]
    pub case: Option<String>,
    /// The fast subset
    #[arg(long)]
    pub quick: bool,
    /// Name the cases and run none
    #[arg(long, conflicts_with = "shard")]
    pub list: bool,
    #[command(flatten)]
    pub shard: ShardArguments,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof codes --degree 11 --index 3 --interleave 1")]
pub(super) struct CodesArguments {
    /// Degree n of the polynomials, 2 to 20, for example --degree 11; the code has
    /// 2^n - 1 chips before interleaving
    #[arg(long, value_name = "N")]
    pub degree: Option<u32>,
    /// Family, for example --family m-sequence
    #[arg(long, value_name = "F", value_enum, default_value_t = Family::Gold)]
    pub family: Family,
    /// Exponents in descending order, the two polynomials of a Gold pair
    /// separated by a semicolon: --polynomials "11,2,0;11,8,5,2,0"
    /// [default: a preferred pair]
    #[arg(long, value_name = "LIST")]
    pub polynomials: Option<String>,
    /// First chips of each m-sequence, separated by a comma: --seeds
    /// 11111,11111 [default: all ones]
    #[arg(long, value_name = "A,B")]
    pub seeds: Option<String>,
    /// Index in the Gold set: -2 is u, -1 is v, i is u XOR v advanced by i chips,
    /// up to 2^n - 2, for example --index 3 [default: 0]
    #[arg(long, value_name = "I", allow_negative_numbers = true)]
    pub index: Option<i64>,
    /// Interleaving depth nu, 0 to 8, for example --interleave 1
    #[arg(long, value_name = "V", default_value_t = 0)]
    pub interleave: u32,
    /// Chips of family chips, first chip first: --chips 0110100
    #[arg(long, value_name = "BITS")]
    pub chips: Option<String>,
    /// Permit a Gold set from a pair that is not preferred
    #[arg(long)]
    pub allow_non_preferred: bool,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    #[test]
    fn a_time_has_its_unit_and_its_bounds() {
        let time = |text| super::parse_time(text).map(|time| time.as_secs_f64());
        assert_eq!(time("10min"), Ok(600.0));
        assert_eq!(time(" 1.5 h "), Ok(5400.0));
        assert_eq!(time("0.25s"), Ok(0.25));
        for text in [
            "",
            "10",
            "s",
            "-1 s",
            "0 s",
            "1e99 h",
            "nan s",
            "inf s",
            "1 d",
            "1 \u{b5}s",
        ] {
            assert!(time(text).is_err(), "{text}");
        }
    }

    /// Each option that takes what is not in a list says how it is written.
    #[test]
    fn every_option_and_every_command_has_an_example() {
        let mut command = super::Cli::command();
        command.build();
        let mut checked = 0;
        for sub in command
            .get_subcommands()
            .filter(|sub| sub.get_name() != "help")
        {
            let more = sub.get_after_help().map(ToString::to_string);
            let example = format!("Example: goldtof {} ", sub.get_name());
            assert!(more.unwrap_or_default().starts_with(&example), "{example}");
            let options = sub
                .get_arguments()
                .filter(|option| option.get_long().is_some());
            for option in options.filter(|option| option.get_action().takes_values()) {
                let name = format!("--{}", option.get_long().unwrap_or_default());
                let help = option
                    .get_help()
                    .map(ToString::to_string)
                    .unwrap_or_default();
                let has_example = help.contains(&format!("{name} "));
                let is_choice = !option.get_possible_values().is_empty();
                assert!(
                    has_example || is_choice,
                    "{} {name}: {help}",
                    sub.get_name()
                );
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

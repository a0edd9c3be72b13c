//! `goldtof cosim`.

use std::sync::Arc;

use super::common::{VcdWindow, warn};
use super::emit::{command_line, on_board};
use super::junit;
use super::output::{Bar, with_causes};
use super::prelude::*;
use super::replay::ChannelArguments;
use crate::board::{self, BoardReport};
use crate::cosim::shift::PortDifference;
use crate::cosim::window::Window;
use crate::cosim::{CosimOptions, Report, StimulusKind, VcdClocks, Verdict};
use crate::deliver::board::Board;
use crate::door::{EmitOptions, cosim};
use crate::files::check_target;
use crate::photons::Pulse;
use crate::progress::Progress;
use crate::sensor::port::PortRole;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof cosim scenes/quick.toml --rtl rtl --stimulus adversarial")]
pub(super) struct CosimArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: CosimOptions,
    /// Check what stands round the core on this board, from the pins to the core's ports and back: the emitted
    /// Verilog, or with --rtl that of a folder of `emit --board`, for example --board ulx3s-12f
    #[arg(long, value_name = "BOARD", value_parser = Board::named, conflicts_with_all =
          ["file_lists", "top", "latency", "clocks", "stimulus", "engine", "vcd", "vcd_from", "vcd_clocks", "tags", "photons",
          "epoch", "epoch_periods", "junit"])]
    pub board: Option<&'static Board>,
    /// Write waveforms of all ports, both sides, round the first mismatch (or the first
    /// result if there is none), with views for GTKWave and Surfer, for example
    /// --vcd ports.vcd
    #[arg(long, value_name = "FILE")]
    pub vcd: Option<PathBuf>,
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// Recorded photons in place of simulated ones: a file of time tags, as for `replay`, with
    /// --photons and --epoch, for example --tags evening.ptu
    #[arg(long, value_name = "FILE")]
    pub tags: Option<PathBuf>,
    #[command(flatten)]
    pub channels: ChannelArguments,
    /// Also write the verdict as a JUnit report: a case for each output port, each family
    /// of cover points and the stimulus, for example --junit cosim.xml
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

impl Command for CosimArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        if let Some(board) = self.board {
            return check_board(self, board, seed, output);
        }
        let sensor = self.scene.sensor(output)?;
        let scene = sensor.scene();
        for path in [&self.vcd, &self.junit].into_iter().flatten() {
            // An unwritable file is reported before the run, not after it.
            check_target(path)?;
        }
        let options = CosimOptions {
            made_by: command_line(&self.scene),
            seed,
            window: window(self)?,
            recorded: recorded(self, &sensor, output)?,
            ..self.options.clone()
        };
        let mut progress = CosimProgress::new(output);
        progress.build();
        let found = cosim(&sensor, &options, |so_far| progress.hear(so_far));
        progress.end();
        let mut cosimulation = with_junit(self.junit.as_deref(), &scene.name, found)?;
        if let Some(path) = &self.junit {
            junit::write_report(path, &scene.name, &cosimulation.report)?;
        }
        if let Some(path) = &self.vcd {
            cosimulation.write_vcd(path)?;
        }
        output.answer(
            Some(scene.reference()),
            &cosimulation.report,
            &text(&cosimulation.report),
        )?;
        Ok(ending(cosimulation.report.verdict))
    }
}

/// `cosim --board`.
fn check_board(
    arguments: &CosimArguments,
    board: &'static Board,
    seed: u64,
    output: &CommandOutput,
) -> anyhow::Result<Ending> {
    // As `emit` has it, so that builds are found again.
    let made_by = format!("{} --board {}", command_line(&arguments.scene), board.name);
    let options = EmitOptions { prefix: None, made_by };
    let (_, sensor, emission) = on_board(arguments.scene.read()?, board, &[], &options)?;
    warn(&sensor, output);
    let bar = output.bar();
    let report =
        board::check(&sensor, &emission, &arguments.options.own, seed, |run| bar.stage(run));
    bar.end();
    let report = report?;
    output.answer(Some(sensor.scene().reference()), &report, &board_text(&report))?;
    Ok(ending(report.verdict))
}

/// What was found of a board, in words.
fn board_text(report: &BoardReport) -> String {
    let mut text = String::new();
    for run in &report.runs {
        text += &format!(
            "{}: {} chips, {} bytes to the host, {} results, {} answers\n",
            run.name, run.chips, run.bytes, run.results, run.answers
        );
    }
    for remark in &report.remarks {
        text += &format!("remark: {remark}\n");
    }
    if let Some(fault) = &report.fault {
        text += &format!("fault: {fault}\n");
    } else {
        for point in report.cover.iter().filter(|point| point.reached == 0) {
            text += &format!("inconclusive: {} never came up\n", point.name);
        }
    }
    let reached = report.cover.iter().filter(|point| point.reached > 0).count();
    text + &format!(
        "score: {} on {}, {reached} of {} cover points reached, {} chips\n",
        report.verdict,
        report.board,
        report.cover.len(),
        report.runs.iter().map(|run| run.chips).sum::<u64>()
    )
}

/// The pulses of a recording's first scan, if one was named.
fn recorded(
    arguments: &CosimArguments,
    sensor: &Sensor,
    output: &CommandOutput,
) -> anyhow::Result<Option<Arc<Vec<Vec<Pulse>>>>> {
    let Some(tags) = &arguments.tags else { return Ok(None) };
    anyhow::ensure!(
        arguments.options.stimulus == StimulusKind::Photons,
        "--tags are photons; leave out --stimulus adversarial"
    );
    let replayed = arguments.channels.replay(sensor, tags, output)?;
    let whole = replayed.scan.ok_or_else(|| {
        anyhow::anyhow!(
            "{}: the recording has {} code periods without a pause, and a scan of the scene lasts {}; \
             scan.integration and scan.steps make it shorter",
            printable_path(tags),
            replayed.file.epochs.periods,
            sensor.interface().scan_clocks() / sensor.timing().code_chips()
        )
    })?;
    Ok(Some(whole))
}

/// The clocks to keep for waveforms.
fn window(arguments: &CosimArguments) -> anyhow::Result<Window> {
    let asked = arguments.vcd_window.clocks();
    anyhow::ensure!(
        asked.is_none() || arguments.vcd.is_some(),
        "--vcd-from and --vcd-clocks say which clocks the waveforms have; name their file with \
         --vcd FILE"
    );
    Ok(asked.map_or(Window::Found, Window::Clocks))
}

/// Passes a result on; an error goes into the JUnit report first.
pub(super) fn with_junit<T, E: Into<anyhow::Error>>(
    junit: Option<&Path>,
    scene: &str,
    found: Result<T, E>,
) -> anyhow::Result<T> {
    found.map_err(|error| {
        let error = error.into();
        if let Some(path) = junit {
            // The error itself is what matters.
            let _ = junit::write_error(path, scene, &with_causes(&error));
        }
        error
    })
}

/// Shows how far a co-simulation is.
pub(super) struct CosimProgress<'o> {
    output: &'o CommandOutput,
    bar: Bar,
    forecast: Option<Forecast<'o>>,
}

impl<'o> CosimProgress<'o> {
    pub fn new(output: &'o CommandOutput) -> CosimProgress<'o> {
        CosimProgress { output, bar: output.bar(), forecast: None }
    }

    /// The Verilog is being built.
    pub fn build(&self) {
        self.bar.stage("compiling a model of the Verilog; the next run has it from the cache");
    }

    /// Clocks of the co-simulation, and stages of what is done after it.
    pub fn hear(&mut self, so_far: Progress) {
        match so_far {
            Progress::Parts { done, of } => {
                // From the first block on: what is built before is not in the rate.
                let new = || Forecast::new(self.output, "the co-simulation");
                self.forecast.get_or_insert_with(new).progress(done, of);
                self.bar.clocks("co-simulating", done, of);
            }
            Progress::Stage(what) => {
                self.bar.end();
                self.bar = self.output.bar();
                self.bar.stage(what);
            }
        }
    }

    pub fn end(&self) {
        self.bar.end();
    }
}

/// 1 unless the two sides agree in what makes a sensor.
pub(super) fn ending(verdict: Verdict) -> Ending {
    match verdict {
        Verdict::Match => Ending::Done,
        Verdict::Mismatch | Verdict::Inconclusive => Ending::DoesNotHold,
    }
}

/// The report in words.
pub(super) fn text(report: &Report) -> String {
    let mut text = format!(
        "{}: {} clocks, {} phase steps, {} output ports at every clock, {:.1} million clocks per \
         second\n",
        report.verdict,
        report.clocks,
        report.phase_steps,
        report.compared_ports.len(),
        report.clocks_per_s / 1e6,
    );
    if let Some(latency) = &report.latency {
        text += &format!("latency: {}\n", latency.text());
    }
    for remark in &report.remarks {
        text += &format!("remark: {remark}\n");
    }
    text += &exercised(report);
    if report.stimulus == StimulusKind::Adversarial {
        text += &report.coverage.text();
    }
    if let Some(first) = &report.first_mismatch {
        text += &format!(
            "first mismatch at clock {} ({:.3} ns): {}; {} clock(s) differ in all that was compared\n",
            first.clock,
            first.time_ps / 1e3,
            first.text(),
            report.mismatches,
        );
        text += &differences(report);
    }
    if let Some(vcd) = &report.vcd {
        text += &format!("waveforms: {}", printable_path(vcd));
        if let Some(VcdClocks { from, clocks }) = report.vcd_clocks {
            text += &format!(", clocks {from} to {}", from + clocks - 1);
        }
        text.push('\n');
    }
    text + &score(report)
}

/// The verdict with its score, in one line.
pub(super) fn score(report: &Report) -> String {
    format!("score: {}, {}, {} clocks\n", report.verdict, report.coverage.score(), report.clocks)
}

/// The difference at each port, and a hint at `--latency auto`.
fn differences(report: &Report) -> String {
    let mut text = String::new();
    for difference in &report.differences {
        text += &format!("  {}: {}\n", difference.port, difference.text);
    }
    let depends = |difference: &&PortDifference| {
        let port = PortRole::of(&difference.port);
        matches!(port, Some(PortRole::Valid | PortRole::PeakValid))
    };
    if report.differences.iter().any(|d| depends(&d)) {
        text += "  (--latency auto holds a design to its own latency)\n";
    }
    text
}

/// Coverage behind the verdict, and what is missing for one.
pub(super) fn exercised(report: &Report) -> String {
    let mut text = format!("clocked: {}\n", report.engines_text());
    text += &format!("exercised: {}\n", report.exercised.text());
    for missing in &report.missing {
        text += &format!("inconclusive: {missing}\n");
    }
    if !report.not_exercised.is_empty() {
        text += &format!("not exercised: {}", report.not_exercised.join(", "));
        text += match report.stimulus {
            StimulusKind::Photons => " (`goldtof cosim --stimulus adversarial` drives it)\n",
            StimulusKind::Adversarial => " (more --clocks bring it)\n",
        };
    }
    text
}

//! `goldtof cosim`.

use super::arguments::CosimArguments;
use super::emit::rtl;
use super::ending::Ending;
use super::forecast::Forecast;
use super::junit;
use super::output::{Output, Progress, with_causes};
use super::warnings::warn_of_far_paths;

use crate::cosim::shift::PortDifference;
use crate::cosim::window::Window;
use crate::cosim::{Report, StimulusKind, VcdClocks, Verdict};
use crate::door::{CosimOptions, cosim};
use crate::files::check_target;
use crate::printable::printable_path;
use crate::sensor::Sensor;
use crate::sensor::port::Role;
use std::path::Path;

pub(super) fn run(
    arguments: &CosimArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?;
    warn_of_far_paths(&Sensor::new(&scene), output);
    for path in [&arguments.vcd, &arguments.junit].into_iter().flatten() {
        // Better now than after a long run.
        check_target(path)?;
    }
    let options = CosimOptions {
        rtl: rtl(&arguments.own, &arguments.scene),
        stimulus: arguments.stimulus,
        clocks: arguments.clocks,
        seed,
        window: window(arguments)?,
        latency: arguments.latency,
        engine: arguments.engine,
    };
    let mut progress = CosimProgress::new(output);
    progress.build();
    let found = cosim(&scene, &options, |done, of| progress.take(done, of));
    progress.end();
    let mut cosimulation = with_junit(arguments.junit.as_deref(), &scene.name, found)?;
    if let Some(path) = &arguments.junit {
        junit::write_report(path, &scene.name, &cosimulation.report)?;
    }
    if let Some(path) = &arguments.vcd {
        cosimulation.write_vcd(path)?;
    }
    output.answer(Some(&scene), &cosimulation.report, &text(&cosimulation.report))?;
    Ok(ending(&cosimulation.report))
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

/// A result; if it is an error, the JUnit report says so before the program ends.
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
    output: &'o Output,
    progress: Progress,
    forecast: Option<Forecast<'o>>,
}

impl<'o> CosimProgress<'o> {
    pub fn new(output: &'o Output) -> CosimProgress<'o> {
        CosimProgress { output, progress: output.progress(), forecast: None }
    }

    /// The Verilog is being built.
    pub fn build(&self) {
        self.progress.stage("building the model of the Verilog");
    }

    /// `done` clocks `of` all are done.
    pub fn take(&mut self, done: u64, of: u64) {
        // From the first block on: what is built before is not in the rate.
        let forecast =
            self.forecast.get_or_insert_with(|| Forecast::new(self.output, "the co-simulation"));
        forecast.progress(done, of);
        self.progress.clocks("co-simulating", done, of);
    }

    /// Names what is being done after it.
    pub fn stage(&mut self, what: &'static str) {
        self.progress.end();
        self.progress = self.output.progress();
        self.progress.stage(what);
    }

    pub fn end(&self) {
        self.progress.end();
    }
}

/// 1 unless the two sides agree in what makes a sensor.
pub(super) fn ending(report: &Report) -> Ending {
    match report.verdict {
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
    format!(
        "score: {}, {} of {} cover points reached, {} clocks\n",
        report.verdict, report.coverage.covered, report.coverage.points, report.clocks
    )
}

/// How each port differs, and what would take a design that is late.
fn differences(report: &Report) -> String {
    let mut text = String::new();
    for difference in &report.differences {
        text += &format!("  {}: {}\n", difference.port, difference.text);
    }
    let depends = |difference: &&PortDifference| {
        let port = Role::of(&difference.port);
        matches!(port, Some(Role::Valid | Role::PeakValid))
    };
    if report.differences.iter().any(|d| depends(&d)) {
        text += "  (--latency auto holds a design to its own latency)\n";
    }
    text
}

/// What the verdict rests on, and what it lacks.
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

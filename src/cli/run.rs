//! `goldtof run`: plan, emit, simulate photons, co-simulate, estimate, report.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use super::Ending;
use super::arguments::RunArguments;
use super::cosim::{ending, exercised, text as cosim_text, with_progress};
use super::emit::{command_line, text as emit_text};
use super::output::{Output, terminal_width};
use super::warnings::warn_of_far_paths;
use crate::cosim::build::{cache_dir, sources_of};
use crate::cosim::sent::SentCount;
use crate::cosim::{self, Cosimulation, Request, StimulusKind, Verdict};
use crate::deliver;
use crate::deliver::Emission;
use crate::estimate::report::{EstimateReport, estimate_scan};
use crate::photons::StepCount;
use crate::plan::{self, Plan};
use crate::printable::printable_path;
use crate::report::estimates::BothEstimates;
use crate::report::page::Page;
use crate::report::{DetectorCounts, counts_csv};
use crate::sensor::Sensor;

/// Written last.
const REPORT: &str = "report.html";
const COUNTS: &str = "counts.csv";
const WAVEFORMS: &str = "mismatch.vcd";

/// Said of an estimate after a mismatch.
const OF_THE_VERILOG: &str = "the counts are the Verilog's, which differs from the reference model";

/// The JSON of `goldtof run`.
#[derive(Serialize)]
struct RunReport<'a> {
    scene: &'a str,
    seed: u64,
    plan: &'a Plan,
    emit: &'a Emission,
    cosim: &'a cosim::Report,
    /// By the scene's estimator.
    estimates: &'a [EstimateReport],
    /// By the other one, on the same counts.
    other_estimates: &'a [EstimateReport],
}

pub(super) fn run(
    arguments: &RunArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let out = &arguments.out;
    let scene = arguments.scene.load()?;
    let sensor = Sensor::new(&scene.with_estimator(arguments.estimator)?);
    warn_of_far_paths(&sensor, output);
    let plan = plan::plan(&sensor);
    let emission = deliver::emit(&sensor, &command_line(&arguments.scene))?;
    let folder = output.folder(out)?;
    // A folder with a report has all that belongs to it, and of one scene.
    for name in [REPORT, COUNTS, WAVEFORMS] {
        folder.remove(name)?;
    }
    folder.sync()?;
    let rtl = folder.join("rtl");
    deliver::write_into(&emission, &output.subfolder(&folder, "rtl")?)?;
    output.note(
        emit_text(&emission, &rtl)
            .lines()
            .next()
            .unwrap_or_default(),
    );

    let request = Request {
        sources: sources_of(&emission),
        cache: cache_dir()?,
        stimulus: StimulusKind::Photons,
        clocks: None,
        seed,
    };
    let mut cosimulation = with_progress(&sensor, &request, output)?;
    if cosimulation.report.verdict == Verdict::Mismatch {
        cosimulation.write_vcd(&folder.join(WAVEFORMS))?;
    }
    let told = cosim_text(&cosimulation.report);
    output.note(match cosimulation.report.verdict {
        // The summary has the rest.
        Verdict::Match => told.lines().next().unwrap_or_default(),
        Verdict::Mismatch | Verdict::Inconclusive => told.trim_end(),
    });
    let estimates_of = |sensor: &Sensor| estimates(sensor, &cosimulation);
    let estimates = estimates_of(&sensor);
    let scene = sensor.scene();
    let other = Sensor::new(&scene.estimated_by(scene.estimator.other()));
    let other_estimates = estimates_of(&other);
    let counts: Vec<DetectorCounts> = cosimulation
        .counts
        .iter()
        .zip(&estimates)
        .enumerate()
        .map(|(detector, (counts, estimate))| {
            DetectorCounts::new(&sensor, detector, estimate.calibration_offset_ps, counts)
        })
        .collect();
    folder.write(COUNTS, &counts_csv(&sensor, &counts))?;
    let page = Page {
        sensor: &sensor,
        seed,
        plan: &plan,
        emission: &emission,
        cosim: &cosimulation.report,
        counts: &counts,
        estimates: &estimates,
        other_estimates: &other_estimates,
    };
    folder.write(REPORT, &page.html()?)?;

    let report = RunReport {
        scene: &sensor.scene().name,
        seed,
        plan: &plan,
        emit: &emission,
        cosim: &cosimulation.report,
        estimates: &estimates,
        other_estimates: &other_estimates,
    };
    output.answer(&report, &summary(&sensor, &report, out))?;
    Ok(ending(&cosimulation.report))
}

/// What the counts that the Verilog sent say of the distance, detector by detector.
fn estimates(sensor: &Sensor, cosimulation: &Cosimulation) -> Vec<EstimateReport> {
    let of_detector = |(detector, sent): (usize, &Vec<SentCount>)| {
        let counts: Vec<StepCount> = sent.iter().map(SentCount::step_count).collect();
        let mut estimate = estimate_scan(sensor, detector, &counts);
        if cosimulation.report.verdict == Verdict::Mismatch {
            estimate.add_remark(OF_THE_VERILOG);
        }
        estimate
    };
    let counts = cosimulation.counts.iter().enumerate();
    counts.map(of_detector).collect()
}

/// The end of the run in a few lines.
fn summary(sensor: &Sensor, report: &RunReport, out: &Path) -> String {
    let mut text = format!(
        "{}: co-simulation {}: {} clocks, {} phase steps of {} chips\n",
        report.scene,
        report.cosim.verdict,
        report.cosim.cycles,
        report.cosim.phase_steps,
        sensor.timing().scan.integration_chips,
    );
    text += &exercised(report.cosim);
    let both = report.estimates.iter().zip(report.other_estimates);
    for (detector, (own, other)) in both.enumerate() {
        text += &BothEstimates { own, other }.text(terminal_width());
        if let Some(peak) = report.cosim.peaks.get(detector) {
            let _ = writeln!(
                text,
                "{}: peak of the hardware at phase step {}, count {}",
                peak.detector, peak.step, peak.count
            );
        }
    }
    let _ = writeln!(text, "report: {}", printable_path(&out.join(REPORT)));
    text
}

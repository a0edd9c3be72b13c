//! `goldtof cosim`.

use super::arguments::CosimArguments;
use super::emit::command_line;
use super::forecast::Forecast;
use super::output::Output;
use super::{Ending, rtl};
use crate::cosim::build::{cache_dir, sources_of};
use crate::cosim::{Cosimulation, Report, Request, StimulusKind, Verdict, cosimulate};
use crate::deliver;
use crate::files::check_target;
use crate::printable::printable_path;
use crate::sensor::Sensor;

pub(super) fn run(
    arguments: &CosimArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let sensor = Sensor::new(&arguments.scene.load()?);
    if let Some(path) = &arguments.vcd {
        // Better now than after a long run.
        check_target(path)?;
    }
    let sources = match &arguments.rtl {
        Some(folder) => rtl::read(folder)?,
        None => sources_of(&deliver::emit(&sensor, &command_line(&arguments.scene))?),
    };
    let request = Request {
        sources,
        cache: cache_dir()?,
        stimulus: arguments.stimulus,
        clocks: arguments.cycles,
        seed,
    };
    let mut cosimulation = with_progress(&sensor, &request, output)?;
    if let Some(path) = &arguments.vcd {
        cosimulation.write_vcd(path)?;
    }
    output.answer(&cosimulation.report, &text(&cosimulation.report))?;
    Ok(ending(&cosimulation.report))
}

/// Co-simulates and shows how far it is.
pub(super) fn with_progress(
    sensor: &Sensor,
    request: &Request,
    output: &Output,
) -> anyhow::Result<Cosimulation> {
    let progress = output.progress();
    progress.stage("building the model of the Verilog");
    let mut forecast: Option<Forecast> = None;
    let cosimulation = cosimulate(sensor, request, |done, of| {
        // From the first block on: what is built before is not in the rate.
        let forecast = forecast.get_or_insert_with(|| Forecast::new(output, "the co-simulation"));
        forecast.progress(done, of);
        progress.clocks("co-simulating", done, of);
    });
    progress.end();
    Ok(cosimulation?)
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
        report.cycles,
        report.phase_steps,
        report.compared_ports.len(),
        report.cycles_per_second / 1e6,
    );
    text += &exercised(report);
    if let Some(first) = &report.first_mismatch {
        text += &format!(
            "first mismatch at clock {} ({:.3} ns): port {} should be {} and is {}; {} clock(s) \
             differ in all that was compared\n",
            first.cycle,
            first.time_ps / 1e3,
            first.port,
            first.expected,
            first.got,
            report.mismatches,
        );
    }
    if let Some(vcd) = &report.vcd {
        text += &format!("waveforms: {}\n", printable_path(vcd));
    }
    text
}

/// What the verdict rests on, and what it lacks.
pub(super) fn exercised(report: &Report) -> String {
    let mut text = format!("exercised: {}\n", report.exercised.text());
    for missing in &report.missing {
        text += &format!("inconclusive: {missing}\n");
    }
    if !report.not_exercised.is_empty() {
        text += &format!("not exercised: {}", report.not_exercised.join(", "));
        text += match report.stimulus {
            StimulusKind::Photons => " (`goldtof cosim --stimulus adversarial` drives it)\n",
            StimulusKind::Adversarial => " (more --cycles bring it)\n",
        };
    }
    text
}

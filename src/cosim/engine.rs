//! Which engine does which part of a run.

use std::sync::mpsc::channel;
use std::thread;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::lanes::run::LanesOutcome;
use super::lanes::{Prepared, Refusal, Unfit, refuse_memories};
use super::lockstep::Outcome;
use super::window::Window;
use super::{
    Cosimulation, Report, Request, StimulusKind, Verdict, build, coverage, peaks, report, run,
};
use crate::photons::DetectorModel;
use crate::reference::coverage::CoverTable;
use crate::reference::predictor::Reference;
use crate::reference::stimulus::clocks_for_scans;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Shorter runs are done before lanes have started.
const LEAST_CLOCKS: u64 = 20_000_000;
/// Clocks of photons, and as many of the adversary, that the RTL itself is clocked
/// beside lanes.
const WITNESSED_CLOCKS: u64 = 500_000;

/// How Verilog and reference model are clocked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// Long runs of photons in lanes and a part in lock-step, all else in lock-step.
    #[default]
    Auto,
    /// In lanes, or not at all.
    Lanes,
    /// In lock-step.
    Lockstep,
}

/// What an engine did of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EnginePart {
    /// The engine.
    pub engine: Engine,
    /// What drove it.
    pub stimulus: StimulusKind,
    /// Clocks from the start on.
    pub clocks: u64,
    /// Lanes that shared them.
    pub lanes: Option<usize>,
}

/// Runs photons in lanes, and a part of them in lock-step before.
///
/// # Errors
/// What of the run has no place in lanes, and is to be done in lock-step; or a tool
/// fails.
pub(super) fn in_lanes(
    sensor: &Sensor,
    request: &Request,
    mut on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, Refusal> {
    let interface = sensor.interface();
    let clocks = request
        .clocks
        .unwrap_or_else(|| clocks_for_scans(interface, 1));
    if request.stimulus != StimulusKind::Photons {
        return Err(Unfit::new("lanes are for photons").into());
    }
    refuse_memories(interface)?;
    let is_auto = request.engine == Engine::Auto;
    if is_auto && clocks < LEAST_CLOCKS {
        return Err(Unfit::new(format!("{clocks} clocks are few")).into());
    }
    if let Window::Clocks(asked) = &request.window
        && asked.end > WITNESSED_CLOCKS
    {
        let reason = format!("waveforms of clocks from {WITNESSED_CLOCKS} on are for lock-step");
        return Err(Unfit::new(reason).into());
    }
    let (built, prepared) = thread::scope(|scope| {
        let built = scope.spawn(|| {
            let registers = request.registers.as_ref();
            build::build_with(
                &request.top,
                &request.sources,
                interface,
                registers,
                &request.cache,
            )
        });
        let prepared = Prepared::new(
            &request.top,
            &request.sources,
            interface,
            clocks,
            &request.cache,
        );
        let built = built
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        (built, prepared)
    });
    // Of Verilog that does not compile Verilator speaks, whose words are known.
    let (built, prepared) = (built?, prepared?);
    let witness = |stimulus| {
        let part = Request {
            stimulus,
            clocks: Some(WITNESSED_CLOCKS.min(clocks)),
            engine: Engine::Lockstep,
            ..request.clone()
        };
        let reference = Reference::new(interface.clone()).map_err(super::CosimError::from)?;
        run(sensor, reference, &built, &part, |_, _| ())
    };
    let photons = witness(StimulusKind::Photons)?;
    if photons.outcome.first.is_some() {
        return Err(Unfit::new("the first clocks differ").into());
    }
    let mut parts = vec![part_of(&photons.report)];
    if is_auto {
        let adversarial = witness(StimulusKind::Adversarial)?;
        if adversarial.report.verdict == Verdict::Mismatch {
            // No distance rests on such counts.
            return Ok(Cosimulation {
                counts: vec![Vec::new(); sensor.scene().detectors.len()],
                ..adversarial
            });
        }
        parts.push(part_of(&adversarial.report));
    }
    let started = Instant::now();
    let models: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    let lanes = thread::scope(|scope| {
        let (done, progress) = channel();
        let lanes = scope.spawn(|| {
            let done = done;
            prepared.run(&models, request.seed, clocks, |clocks| {
                // Who listens may have ended.
                let _ = done.send(clocks);
            })
        });
        progress.iter().for_each(|done| on_progress(done, clocks));
        lanes
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })?;
    if let Some(clock) = lanes.differs {
        return Err(Unfit::new(format!("lanes differ at clock {clock}")).into());
    }
    let outcome = Outcome {
        clocks,
        exercise: lanes.exercise.clone(),
        last_outputs: lanes.last_outputs.clone(),
        elapsed: started.elapsed(),
        ..photons.outcome.clone()
    };
    Ok(told(sensor, request, photons, outcome, lanes, parts))
}

/// The run in lanes as a co-simulation; its waveforms are those of the part in
/// lock-step.
fn told(
    sensor: &Sensor,
    request: &Request,
    photons: Cosimulation,
    outcome: Outcome,
    lanes: LanesOutcome,
    parts: Vec<EnginePart>,
) -> Cosimulation {
    let mut counts = vec![Vec::new(); sensor.scene().detectors.len()];
    for &sent in &lanes.sent {
        counts[sent.detector].push(sent);
    }
    let coverage = coverage(sensor, &CoverTable::of(sensor.interface()), &outcome, None);
    let mut report = report(sensor, request, &outcome, &photons.layout, coverage);
    if outcome.clocks >= clocks_for_scans(sensor.interface(), 1) {
        report.peaks = peaks(sensor, &photons.layout, &outcome.last_outputs);
    }
    report.engines = vec![EnginePart {
        engine: Engine::Lanes,
        stimulus: StimulusKind::Photons,
        clocks: outcome.clocks,
        lanes: Some(lanes.lanes),
    }];
    report.engines.extend(parts);
    Cosimulation {
        report,
        counts,
        hits: lanes.hits,
        outcome,
        ..photons
    }
}

/// A run in lock-step.
pub(super) fn part_of(report: &Report) -> EnginePart {
    EnginePart {
        engine: Engine::Lockstep,
        stimulus: report.stimulus,
        clocks: report.clocks,
        lanes: None,
    }
}

/// What was done in lanes and what in lock-step, in a few words.
pub fn text(report: &Report) -> String {
    let part = |part: &EnginePart| {
        let drive = match part.stimulus {
            StimulusKind::Photons => "photons",
            StimulusKind::Adversarial => "adversarial stimulus",
        };
        match part.lanes {
            Some(lanes) => format!(
                "{} clocks of {drive} in {lanes} lanes, each of which ends in every register as the \
                 next one starts",
                part.clocks
            ),
            None => format!("{} clocks of {drive} in lock-step", part.clocks),
        }
    };
    let mut text = report
        .engines
        .iter()
        .map(part)
        .collect::<Vec<String>>()
        .join("; ");
    if let Some(why) = &report.not_in_lanes {
        text += &format!(" (not in lanes: {why})");
    }
    text
}

//! A run in lanes, and the Verilog itself in lock-step beside it for a stated part of it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread::{self, ScopedJoinHandle};
use std::time::Instant;

use super::build::{self, Built};
use super::engine::{Engine, EnginePart};
use super::error::CosimError;
use super::lanes::run::LanesOutcome;
use super::lanes::{LaneRefusal, PreparedLanes, Unfit, refuse_memories};
use super::lockstep::LockstepOutcome;
use super::report::{Verdict, coverage, part_of, peaks, report};
use super::side_by_side::run;
use super::source::Verilog;
use super::window::Window;
use super::{CosimOptions, Cosimulation, StimulusKind};
use crate::photons::DetectorModel;
use crate::reference::coverage::CoverTable;
use crate::reference::predictor::ReferenceModel;
use crate::reference::stimulus::clocks_for_scans;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Shorter runs are done before lanes have started.
const LEAST_CLOCKS: u64 = 20_000_000;
/// Clocks of photons, and as many of the adversary, that the RTL itself is clocked
/// beside lanes.
const WITNESSED_CLOCKS: u64 = 500_000;

/// Runs photons in lanes, and beside that a part of them in lock-step.
///
/// # Errors
/// What of the run has no place in lanes, and is to be done in lock-step; or a tool
/// fails.
pub(super) fn in_lanes(
    sensor: &Sensor,
    verilog: &Verilog,
    options: &CosimOptions,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<Cosimulation, LaneRefusal> {
    let clocks = options.clocks.unwrap_or_else(|| clocks_for_scans(sensor.interface(), 1));
    refuse_unfit(sensor, options, clocks)?;
    let (built, prepared) = built(sensor, verilog, clocks)?;
    let stop = AtomicBool::new(false);
    let started = Instant::now();
    let (photons, adversarial, lanes) = thread::scope(|scope| {
        let witness = |stimulus| {
            let (built, stop) = (&built, &stop);
            scope.spawn(move || {
                let found = witness(sensor, options, built, clocks, stimulus);
                let is_match = |found: &Cosimulation| found.report.verdict != Verdict::Mismatch;
                // What the lanes say is not asked for any more.
                if !found.as_ref().is_ok_and(is_match) {
                    stop.store(true, Ordering::Relaxed);
                }
                found
            })
        };
        let photons = witness(StimulusKind::Photons);
        let adversarial =
            (options.engine == Engine::Auto).then(|| witness(StimulusKind::Adversarial));
        let lanes = of_scan(sensor, &prepared, (options.seed, clocks), &stop, on_progress);
        (joined(photons), adversarial.map(joined), lanes)
    });
    let photons = photons?;
    if photons.outcome.first.is_some() {
        return Err(Unfit::new("the first clocks differ").into());
    }
    let mut parts = vec![part_of(&photons.report)];
    if let Some(adversarial) = adversarial.transpose()? {
        if adversarial.report.verdict == Verdict::Mismatch {
            // No distance rests on such counts.
            return Ok(Cosimulation {
                counts: vec![Vec::new(); sensor.scene().detectors.len()],
                ..adversarial
            });
        }
        parts.push(part_of(&adversarial.report));
    }
    let lanes = lanes?;
    if let Some(clock) = lanes.differs {
        return Err(LaneRefusal::NoVerdict(format!(
            "in a lane an output differs at clock {clock}; lanes begin with guesses of the registers, \
             and either one was wrong or the design is"
        )));
    }
    let outcome = LockstepOutcome {
        clocks,
        exercise: lanes.exercise.clone(),
        last_outputs: lanes.last_outputs.clone(),
        elapsed: started.elapsed(),
        ..photons.outcome.clone()
    };
    Ok(told(sensor, options, photons, outcome, lanes, parts))
}

/// # Errors
/// What of a run is for lock-step, before anything is built.
fn refuse_unfit(sensor: &Sensor, options: &CosimOptions, clocks: u64) -> Result<(), Unfit> {
    if options.stimulus != StimulusKind::Photons {
        return Err(Unfit::new("lanes are for photons"));
    }
    if options.recorded.is_some() {
        return Err(Unfit::new("recorded photons are for lock-step"));
    }
    refuse_memories(sensor.interface())?;
    if sensor.interface().registers.is_some() {
        return Err(Unfit::new(
            "slices of a scan that a host sets begin in no state that is known",
        ));
    }
    if options.engine == Engine::Auto && clocks < LEAST_CLOCKS {
        return Err(Unfit::new(format!("{clocks} clocks are few")));
    }
    match &options.window {
        Window::Clocks(asked) if asked.end > WITNESSED_CLOCKS => Err(Unfit::new(format!(
            "waveforms of clocks from {WITNESSED_CLOCKS} on are for lock-step"
        ))),
        _ => Ok(()),
    }
}

/// The model for lock-step and the one for lanes, built side by side.
fn built(
    sensor: &Sensor,
    verilog: &Verilog,
    clocks: u64,
) -> Result<(Built, PreparedLanes), LaneRefusal> {
    let (interface, cache) = (sensor.interface(), &verilog.cache);
    let (top, sources) = (&verilog.top, &verilog.sources);
    let (built, prepared) = thread::scope(|scope| {
        let registers = verilog.registers.as_ref();
        let built =
            scope.spawn(move || build::build_with(top, sources, interface, registers, cache));
        let prepared = PreparedLanes::new(top, sources, interface, clocks, cache);
        (joined(built), prepared)
    });
    // Where Verilog does not compile, Verilator's message comes first: users know it.
    Ok((built?, prepared?))
}

/// The RTL itself beside the reference model, for a stated part of the clocks.
fn witness(
    sensor: &Sensor,
    options: &CosimOptions,
    built: &Built,
    clocks: u64,
    stimulus: StimulusKind,
) -> Result<Cosimulation, CosimError> {
    let part = CosimOptions {
        stimulus,
        clocks: Some(WITNESSED_CLOCKS.min(clocks)),
        engine: Engine::Lockstep,
        ..options.clone()
    };
    let reference = ReferenceModel::new(sensor.interface().clone())?;
    run(sensor, reference, built, &part, &mut |_, _| ())
}

/// All clocks in lanes. The caller's thread tells how far they are.
fn of_scan(
    sensor: &Sensor,
    prepared: &PreparedLanes,
    (seed, clocks): (u64, u64),
    stop: &AtomicBool,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<LanesOutcome, LaneRefusal> {
    let models: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    thread::scope(|scope| {
        let (done, progress) = channel();
        let lanes = scope.spawn(|| {
            let done = done;
            prepared.run(&models, seed, clocks, stop, &|clocks| {
                // Who listens may have ended.
                let _ = done.send(clocks);
            })
        });
        progress.iter().for_each(|done| on_progress(done, clocks));
        joined(lanes)
    })
}

/// The result of a thread; its panic is passed on.
fn joined<T>(thread: ScopedJoinHandle<T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// The run in lanes as a co-simulation; its waveforms are those of the part in
/// lock-step.
fn told(
    sensor: &Sensor,
    options: &CosimOptions,
    photons: Cosimulation,
    outcome: LockstepOutcome,
    lanes: LanesOutcome,
    parts: Vec<EnginePart>,
) -> Cosimulation {
    let mut counts = vec![Vec::new(); sensor.scene().detectors.len()];
    for &sent in &lanes.sent {
        counts[sent.detector].push(sent);
    }
    let coverage = coverage(sensor, &CoverTable::of(sensor.interface()), &outcome, None);
    let mut report = report(sensor, options, &outcome, &photons.layout, coverage);
    if outcome.clocks >= clocks_for_scans(sensor.interface(), 1) {
        report.peaks = peaks(sensor, &photons.layout, &outcome.last_outputs);
    }
    report.engines = vec![EnginePart {
        engine: Engine::Lanes,
        stimulus: StimulusKind::Photons,
        clocks: outcome.clocks,
        lanes: Some(lanes.lanes),
        refereed_clocks: Some(lanes.refereed_clocks),
    }];
    report.engines.extend(parts);
    Cosimulation { report, counts, hits: lanes.hits, outcome, ..photons }
}

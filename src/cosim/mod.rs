//! Co-simulation: Verilog in Verilator, beside the reference model, clock by clock.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use goldtof::cosim::StimulusKind;
//! use goldtof::cosim::engine::Engine;
//! use goldtof::cosim::latency::Latency;
//! use goldtof::cosim::own::OwnRtl;
//! use goldtof::cosim::window::Window;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let options = goldtof::CosimOptions {
//!     rtl: goldtof::Rtl::Own(OwnRtl::folder("my_rtl")),
//!     stimulus: StimulusKind::Photons,
//!     engine: Engine::Auto,
//!     latency: Latency::Auto,
//!     window: Window::Found,
//!     clocks: Some(100_000),
//!     seed: 1,
//! };
//! let found = goldtof::cosim(&scene, &options, |done, of| eprintln!("{done} of {of} clocks"))?;
//! println!("{}: {} phase steps", found.report.verdict, found.report.phase_steps);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[doc(hidden)]
pub mod build;
pub(crate) mod cache;
pub(crate) mod comparison;
pub mod engine;
pub mod error;
pub mod exercised;
mod falling_edge;
pub(crate) mod image;
#[doc(hidden)]
pub mod lanes;
pub mod latency;
#[doc(hidden)]
pub mod lockstep;
pub mod mismatch;
pub mod own;
#[doc(hidden)]
pub mod ports;
mod process;
mod rejected;
#[doc(hidden)]
pub mod sent;
mod sent_count;
mod sent_frames;
pub mod shift;
pub mod source;
pub(crate) mod tools;
#[doc(hidden)]
pub mod verilated;
mod viewers;
mod wave;
pub mod window;

use crate::scene::DetectorIndex;
use std::path::{Path, PathBuf};

pub(crate) use self::viewers::views_beside;
use serde::Serialize;

use self::build::Built;
use self::comparison::Comparison;
use self::engine::{Engine, EnginePart};
use self::error::{CosimError, When};
use self::exercised::Exercised;
use self::lanes::Refusal;
use self::latency::HeldLatency;
use self::lockstep::{Lockstep, Outcome};
use self::mismatch::FirstMismatch;
pub(crate) use self::rejected::in_users_terms;
use self::sent::SentCount;
use self::shift::{PortDifference, differences};
use self::source::{SourceFile, is_users};
use self::verilated::Verilated;
use self::window::{Shown, Window};
use crate::document::Body;
use crate::files::stage;
use crate::photons::DetectorModel;
use crate::reference::adversarial::{Adversarial, LONGEST_DEFAULT, Means};
use crate::reference::cover_report::Coverage;
use crate::reference::coverage::CoverTable;
use crate::reference::photons::Photons;
use crate::reference::predictor::Reference;
use crate::reference::stimulus::{Stimulus, clocks_for_scans};
use crate::rtl::blocks::ScanRegisters;
use crate::scan::{Clock, Timescale};
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;

/// Name of the module that is compared, unless a manifest says otherwise.
pub const TOP: &str = crate::deliver::TOP;

/// What drives a co-simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum StimulusKind {
    /// Simulated detections of the scene.
    Photons,
    /// Inputs chosen to hurt.
    Adversarial,
}

/// What to co-simulate, and how long.
#[derive(Debug, Clone)]
pub struct Request {
    /// Its top module, with exactly the interface's ports.
    pub top: String,
    /// The Verilog.
    pub sources: Vec<SourceFile>,
    /// The scan's counters in it, if they may be moved on: with them the adversary
    /// shortens steps and scans.
    pub registers: Option<ScanRegisters>,
    /// Where built models are kept.
    pub cache: PathBuf,
    /// What drives both sides.
    pub stimulus: StimulusKind,
    /// Number of clocks; `None` runs one whole scan of photons, or until the adversary
    /// has covered all that it can, at most [`LONGEST_DEFAULT`].
    pub clocks: Option<u64>,
    /// Seed of the stimulus.
    pub seed: u64,
    /// The clocks to keep for waveforms.
    pub window: Window,
    /// How both sides are clocked.
    pub engine: Engine,
}

/// What a co-simulation found; the JSON of `goldtof cosim`.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Report {
    /// What the comparison says.
    pub verdict: Verdict,
    /// Clocks compared.
    pub clocks: u64,
    /// Output ports compared at every clock.
    pub compared_ports: Vec<String>,
    /// Phase steps that ended within these clocks.
    pub phase_steps: u64,
    /// What the compared outputs have shown: a match says no more than that.
    pub exercised: Exercised,
    /// Why equal outputs say nothing of the sensor, and what would; with an
    /// inconclusive verdict.
    pub missing: Vec<String>,
    /// How much of what the sensor can be made to do has shown.
    pub coverage: Coverage,
    /// What else was not exercised.
    pub not_exercised: Vec<&'static str>,
    /// Clocks at which a port differed.
    pub mismatches: u64,
    /// The first difference.
    pub first_mismatch: Option<FirstMismatch>,
    /// Clocks per second of wall time, photons, reference model and comparison
    /// included, building excluded.
    pub clocks_per_s: f64,
    /// What the peak detector's ports showed at the end, detector by detector;
    /// none without a peak detector, or if no scan of a run without resets had
    /// come to its peak.
    pub peaks: Vec<PortPeak>,
    /// What drove both sides.
    pub stimulus: StimulusKind,
    /// Its seed.
    pub seed: u64,
    /// How each port differs round the first mismatch.
    pub differences: Vec<PortDifference>,
    /// The latency that the Verilog was held to, if not the emitted design's.
    pub latency: Option<HeldLatency>,
    /// What was ignored of the Verilog, or assumed.
    pub remarks: Vec<String>,
    /// What was done in lanes and what in lock-step.
    pub engines: Vec<EnginePart>,
    /// Why nothing was done in lanes, if that was asked for or left to goldtof.
    pub not_in_lanes: Option<String>,
    /// The waveform file, if one was written; bytes of its name that are no text are
    /// replaced in JSON.
    #[serde(serialize_with = "path_text")]
    #[cfg_attr(feature = "schemas", schemars(with = "Option<String>"))]
    pub vcd: Option<PathBuf>,
    /// The clocks in it.
    pub vcd_clocks: Option<VcdClocks>,
}

/// The clocks of a waveform file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct VcdClocks {
    /// The first clock, counted from the start of the run.
    pub from: u64,
    /// Number of clocks.
    pub clocks: u64,
}

impl Body for Report {
    const NAME: &'static str = "cosim";
}

/// What a comparison says of the Verilog.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every output was as expected at every clock, and the sensor has worked.
    Match,
    /// Some output was not.
    Mismatch,
    /// Every output was as expected, but too little has happened to tell.
    Inconclusive,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Verdict::Match => "match",
            Verdict::Mismatch => "mismatch",
            Verdict::Inconclusive => "inconclusive",
        })
    }
}

/// A peak as the hardware's ports show it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PortPeak {
    /// The detector's name.
    pub detector: String,
    /// Phase step k of a scan's largest count.
    pub phase_step: u64,
    /// That count.
    pub count: i64,
}

/// A finished co-simulation.
#[derive(Debug, Clone)]
pub struct Cosimulation {
    /// What it found.
    pub report: Report,
    /// For each detector the counts of the first scan's steps, in order, as the
    /// Verilog sent them ([`sent::SentReader`]); complete when the run was long
    /// enough, and the two sides did not differ before.
    pub counts: Vec<Vec<SentCount>>,
    /// For each detector the hits of the first scan's steps, in order, as the reference
    /// model counts them.
    pub(crate) hits: Vec<Vec<u64>>,
    outcome: Outcome,
    layout: Layout,
    clock: Clock,
}

impl Cosimulation {
    /// Writes waveforms of the clocks that were asked for, or else of those round the
    /// first mismatch or the first result, and names the file in the report. Beside a
    /// file go a save file for GTKWave (`.gtkw`) and a command file for Surfer (`.sucl`),
    /// unless others stand there.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_vcd(&mut self, path: &Path) -> Result<(), CosimError> {
        let shown = self.outcome.asked.as_ref().unwrap_or(&self.outcome.found);
        self.report.vcd_clocks = Some(self.write_shown(path, shown)?);
        self.report.vcd = Some(path.to_owned());
        Ok(())
    }

    /// [`Cosimulation::write_vcd`] of the clocks round the first mismatch, whichever were
    /// asked for.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_mismatch(&mut self, path: &Path) -> Result<(), CosimError> {
        self.report.vcd_clocks = Some(self.write_shown(path, &self.outcome.found)?);
        self.report.vcd = Some(path.to_owned());
        Ok(())
    }

    fn write_shown(&self, path: &Path, shown: &Shown) -> Result<VcdClocks, CosimError> {
        let comparison = Comparison {
            layout: &self.layout,
            ignores_idle_payload: self.outcome.ignores_idle_payload,
        };
        let clocks = shown.records.clocks(&self.layout);
        let time = Timescale::of(self.clock, clocks.end);
        let waves = stage(path, |out| {
            wave::write(out, &shown.records, comparison, time)
        })?;
        let views = viewers::views(path, &self.layout, time, shown.clock);
        let views = views
            .iter()
            .map(|view| stage(&view.path, |out| out.write_all(view.text.as_bytes())))
            .collect::<Result<Vec<_>, _>>()?;
        waves.publish()?;
        for view in views {
            view.publish()?;
        }
        Ok(VcdClocks {
            from: clocks.start,
            clocks: clocks.end - clocks.start,
        })
    }
}

/// A path in JSON, which has no bytes that are not text.
fn path_text<S: serde::Serializer>(path: &Option<PathBuf>, json: S) -> Result<S::Ok, S::Error> {
    path.as_ref()
        .map(|path| path.to_string_lossy())
        .serialize(json)
}

/// Builds the Verilog and runs it beside the reference model.
///
/// # Errors
/// When a tool is missing or fails, the Verilog does not compile, its ports do not
/// fit, or it ends the simulation. A mismatch is a result.
pub fn cosimulate(
    sensor: &Sensor,
    request: &Request,
    on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    cosimulate_by_engine(sensor, request, on_progress).map_err(|error| match error {
        CosimError::Halted { when, reason } => CosimError::Halted {
            when,
            reason: in_users_terms(&reason, &request.sources),
        },
        other => other,
    })
}

fn cosimulate_by_engine(
    sensor: &Sensor,
    request: &Request,
    mut on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let mut not_in_lanes = None;
    if request.engine != Engine::Lockstep {
        match engine::in_lanes(sensor, request, &mut on_progress) {
            Ok(done) => return Ok(done),
            Err(Refusal::Unfit(reason)) if request.engine == Engine::Lanes => {
                return Err(CosimError::NoLanes(reason.to_string()));
            }
            Err(Refusal::Unfit(reason)) => not_in_lanes = Some(reason.to_string()),
            Err(Refusal::Failed(error)) => return Err(error),
        }
    }
    let interface = sensor.interface();
    let reference = Reference::new(interface.clone())?;
    let registers = request
        .registers
        .as_ref()
        .filter(|_| request.stimulus == StimulusKind::Adversarial);
    let build = |registers| {
        build::build_with(
            &request.top,
            &request.sources,
            interface,
            registers,
            &request.cache,
        )
    };
    let built = match build(registers) {
        // A manifest names counters that its Verilog has not, or no longer.
        Err(CosimError::ToolFailed { .. }) if registers.is_some() && is_users(&request.sources) => {
            build(None)?
        }
        built => built?,
    };
    let mut done = run(sensor, reference, &built, request, on_progress)?;
    done.report.not_in_lanes = not_in_lanes;
    Ok(done)
}

fn run(
    sensor: &Sensor,
    mut reference: Reference,
    built: &Built,
    request: &Request,
    mut on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let mut model = Verilated::load(built, &layout)?;
    let detectors: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    let means = Means::cosim(built.registers.is_some());
    let (mut stimulus, clocks) = stimulus(sensor, &detectors, request, means)?;
    let mut counts: Vec<Vec<SentCount>> = vec![Vec::new(); sensor.scene().detectors.len()];
    let mut hits: Vec<Vec<u64>> = vec![Vec::new(); counts.len()];
    let outcome = Lockstep {
        model: &mut model,
        reference: &mut reference,
        stimulus: stimulus.as_mut(),
        layout: &layout,
        window: request.window.clone(),
    }
    .run_and_read(
        clocks,
        |result| {
            if result.scan == 0 {
                hits[result.detector].push(result.total);
            }
        },
        |sent| {
            if sent.scan == 0 {
                counts[sent.detector].push(sent);
            }
        },
        |done| on_progress(done, clocks),
    )?;
    finish(&mut model, &outcome)?;
    let means = (request.stimulus == StimulusKind::Adversarial).then_some(means);
    let coverage = coverage(sensor, reference.cover_table(), &outcome, means);
    let mut report = report(sensor, request, &outcome, &layout, coverage);
    if request.stimulus == StimulusKind::Photons && outcome.clocks >= clocks_for_scans(interface, 1)
    {
        report.peaks = peaks(sensor, &layout, &outcome.last_outputs);
    }
    Ok(Cosimulation {
        report,
        counts,
        hits,
        outcome,
        layout,
        clock: sensor.clock(),
    })
}

/// Where the inputs come from, and for how many clocks: as many as asked for, or one scan of
/// photons, or all that an adversary needs.
fn stimulus<'d>(
    sensor: &'d Sensor,
    detectors: &'d [DetectorModel],
    request: &Request,
    means: Means,
) -> Result<(Box<dyn Stimulus + 'd>, u64), CosimError> {
    let interface = sensor.interface();
    let (stimulus, clocks): (Box<dyn Stimulus + 'd>, u64) = match request.stimulus {
        StimulusKind::Photons => {
            let photons = Photons::new(detectors, interface, request.seed);
            let clocks = request.clocks;
            let clocks = clocks.unwrap_or_else(|| clocks_for_scans(interface, 1));
            (Box::new(photons), clocks)
        }
        StimulusKind::Adversarial => {
            let adversarial = Adversarial::with_means(interface, request.seed, means)?;
            let clocks = request.clocks;
            let clocks =
                clocks.unwrap_or_else(|| adversarial.clone().clocks_to_cover(LONGEST_DEFAULT));
            (Box::new(adversarial), clocks)
        }
    };
    match &request.window {
        Window::Clocks(asked) if asked.start >= clocks => Err(CosimError::BeyondTheRun {
            asked: asked.start,
            clocks,
        }),
        _ => Ok((stimulus, clocks)),
    }
}

/// How much of what can be covered an outcome has shown; `means` of an adversary.
fn coverage(
    sensor: &Sensor,
    table: &CoverTable,
    outcome: &Outcome,
    means: Option<Means>,
) -> Coverage {
    let detectors = sensor.scene().detectors.iter();
    let names: Vec<String> = detectors.map(|detector| detector.name.clone()).collect();
    let covered = &outcome.exercise.covered;
    Coverage::new(sensor.interface(), table, covered, &names, means)
}

/// Runs the final blocks; they have no say where a port differs already.
fn finish(model: &mut Verilated, outcome: &Outcome) -> Result<(), CosimError> {
    let when = When::End;
    match model.finish() {
        Err(reason) if outcome.first.is_none() => Err(CosimError::Halted { when, reason }),
        _ => Ok(()),
    }
}

/// Reads the peak detector's ports, if there are any.
fn peaks(sensor: &Sensor, layout: &Layout, outputs: &[u64]) -> Vec<PortPeak> {
    let Some(peak) = &sensor.interface().peak else {
        return Vec::new();
    };
    let [steps, counts] = ["o_peak_step", "o_peak_count"].map(|name| layout.outputs.field(name));
    sensor
        .scene()
        .detectors
        .iter()
        .zip(0u32..)
        .map(|(detector, number)| {
            let unsigned = counts.bits(outputs, number * peak.count_bits, peak.count_bits);
            let unused = u64::BITS - peak.count_bits;
            PortPeak {
                detector: detector.name.clone(),
                phase_step: steps.bits(outputs, number * peak.step_bits, peak.step_bits),
                count: (unsigned << unused).cast_signed() >> unused,
            }
        })
        .collect()
}

fn report(
    sensor: &Sensor,
    request: &Request,
    outcome: &Outcome,
    layout: &Layout,
    coverage: Coverage,
) -> Report {
    let fields = &layout.outputs.fields;
    let detectors = sensor.scene().detectors.iter();
    let names = detectors.map(|detector| detector.name.as_str());
    let exercised = Exercised::new(&outcome.exercise, names);
    let missing = match &outcome.first {
        Some(_) => Vec::new(),
        None => exercised.missing(sensor.interface(), request.stimulus),
    };
    let mut report = Report {
        verdict: match &outcome.first {
            Some(_) => Verdict::Mismatch,
            None if missing.is_empty() => Verdict::Match,
            None => Verdict::Inconclusive,
        },
        clocks: outcome.clocks,
        compared_ports: fields.iter().map(|field| field.port.name.clone()).collect(),
        phase_steps: exercised.phase_steps,
        not_exercised: exercised.not_reached(sensor.interface()),
        exercised,
        coverage,
        missing,
        mismatches: outcome.mismatches,
        first_mismatch: outcome.first.as_ref().map(|first| {
            let words = [&first.expected[..], &first.got[..]];
            FirstMismatch::new(sensor, first.clock, &fields[first.field], words)
        }),
        clocks_per_s: outcome.clocks as f64 / outcome.elapsed.as_secs_f64(),
        peaks: Vec::new(),
        stimulus: request.stimulus,
        seed: request.seed,
        differences: match &outcome.first {
            Some(_) => differences(&outcome.found.records, layout, is_users(&request.sources)),
            None => Vec::new(),
        },
        latency: HeldLatency::of(sensor),
        remarks: Vec::new(),
        engines: Vec::new(),
        not_in_lanes: None,
        vcd: None,
        vcd_clocks: None,
    };
    report.engines.push(engine::part_of(&report));
    report
}

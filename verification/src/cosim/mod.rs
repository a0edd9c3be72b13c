//! Co-simulation: Verilog in Verilator, beside the reference model, clock by clock.

mod beside_lanes;
#[doc(hidden)]
pub mod build;
pub(crate) mod cache;
pub(crate) mod comparison;
mod drivers;
pub mod engine;
pub mod error;
pub mod exercised;
pub(crate) mod image;
#[doc(hidden)]
pub mod lanes;
pub mod latency;
#[doc(hidden)]
pub mod lockstep;
mod low_half;
pub mod mismatch;
pub mod own;
#[doc(hidden)]
pub mod ports;
mod process;
mod rejected;
mod report;
#[doc(hidden)]
pub mod sent;
mod sent_count;
mod sent_frames;
pub mod shift;
mod side_by_side;
pub mod source;
pub(crate) mod tools;
mod undefined;
#[doc(hidden)]
pub mod verilated;
mod viewers;
mod wave;
pub mod window;

use std::path::{Path, PathBuf};

use serde::Serialize;

use self::comparison::Comparison;
use self::engine::Engine;
use self::error::CosimError;
use self::lanes::Refusal;
use self::lockstep::Outcome;
pub(crate) use self::rejected::in_users_terms;
pub use self::report::{PortPeak, Report, VcdClocks, Verdict};
use self::sent::SentCount;
use self::source::{SourceFile, is_users};
pub use self::viewers::views_beside;
use self::window::{Shown, Window};
use crate::files::stage;
use crate::reference::predictor::Reference;
use crate::rtl::blocks::ScanRegisters;
use crate::scan::{Clock, Timescale};
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;

/// Name of the module that is compared, unless a manifest says otherwise.
pub const TOP: &str = crate::deliver::TOP;

/// Most clocks of a co-simulation: years of them, whose samples 64 bits number.
pub const MOST_CLOCKS: u64 = 1 << 50;

/// What drives a co-simulation.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, schemars::JsonSchema, clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum StimulusKind {
    /// Simulated detections of the scene.
    #[default]
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
    /// has covered all that it can, at most [`LONGEST_DEFAULT`](crate::reference::adversarial::LONGEST_DEFAULT).
    pub clocks: Option<u64>,
    /// Seed of the stimulus.
    pub seed: u64,
    /// The clocks to keep for waveforms.
    pub window: Window,
    /// How both sides are clocked.
    pub engine: Engine,
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
    pub hits: Vec<Vec<u64>>,
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
        let waves = stage(path, |out| wave::write(out, &shown.records, comparison, time))?;
        let views = viewers::views(path, &self.layout, time, shown.clock);
        let views = views
            .iter()
            .map(|view| stage(&view.path, |out| out.write_all(view.text.as_bytes())))
            .collect::<Result<Vec<_>, _>>()?;
        waves.publish()?;
        for view in views {
            view.publish()?;
        }
        Ok(VcdClocks { from: clocks.start, clocks: clocks.end - clocks.start })
    }
}

/// Builds the Verilog and runs it beside the reference model.
///
/// # Errors
/// When a tool is missing or fails, the Verilog does not compile, its ports do not
/// fit, or it ends the simulation. A mismatch is a result.
pub fn cosimulate(
    sensor: &Sensor,
    request: &Request,
    mut on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let done = cosimulate_by_engine(sensor, request, &mut on_progress);
    let mut done = done.map_err(|error| match error {
        CosimError::Halted { when, reason } => {
            CosimError::Halted { when, reason: in_users_terms(&reason, &request.sources) }
        }
        other => other,
    })?;
    if is_users(&request.sources) {
        done.report.remarks =
            lanes::meaning::remarks(&request.top, &request.sources, &request.cache)?;
    }
    Ok(done)
}

fn cosimulate_by_engine(
    sensor: &Sensor,
    request: &Request,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let mut not_in_lanes = None;
    if request.engine != Engine::Lockstep {
        match beside_lanes::in_lanes(sensor, request, on_progress) {
            Ok(done) => return Ok(done),
            Err(Refusal::Unfit(reason)) if request.engine == Engine::Lanes => {
                return Err(CosimError::NoLanes(reason.to_string()));
            }
            Err(Refusal::NoVerdict(reason)) if request.engine == Engine::Lanes => {
                return Err(CosimError::NoVerdict(reason));
            }
            Err(Refusal::Unfit(reason)) => not_in_lanes = Some(reason.to_string()),
            Err(Refusal::NoVerdict(reason)) => not_in_lanes = Some(reason),
            Err(Refusal::Failed(error)) => return Err(error),
        }
    }
    let interface = sensor.interface();
    let reference = Reference::new(interface.clone())?;
    let registers =
        request.registers.as_ref().filter(|_| request.stimulus == StimulusKind::Adversarial);
    let build = |registers| {
        build::build_with(&request.top, &request.sources, interface, registers, &request.cache)
    };
    let built = match build(registers) {
        // A manifest names counters that its Verilog has not, or no longer.
        Err(CosimError::ToolFailed { .. }) if registers.is_some() && is_users(&request.sources) => {
            build(None)?
        }
        built => built?,
    };
    let mut done = side_by_side::run(sensor, reference, &built, request, on_progress)?;
    done.report.not_in_lanes = not_in_lanes;
    Ok(done)
}

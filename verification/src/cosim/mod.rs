//! Co-simulation: Verilog in Verilator, beside the reference model, clock by clock.

pub mod asked_latency;
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
mod options;
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

use std::path::Path;

use serde::Serialize;

use self::comparison::OutputComparison;
use self::engine::Engine;
use self::error::CosimError;
use self::lanes::LaneRefusal;
use self::latency::held_to;
use self::lockstep::LockstepOutcome;
pub use self::options::CosimOptions;
pub(crate) use self::rejected::in_users_terms;
pub use self::report::{PortPeak, Report, VcdClocks, Verdict};
use self::sent::SentCount;
use self::source::Verilog;
pub use self::viewers::views_beside;
use self::window::Shown;
use crate::files::stage;
use crate::reference::predictor::ReferenceModel;
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
    outcome: LockstepOutcome,
    layout: Layout,
    clock: Clock,
}

impl Cosimulation {
    /// Writes waveforms of the clocks that were asked for, or else of those round the
    /// first mismatch or the first result, and names the file in the report. Beside a
    /// file go a save file for GTKWave (`.gtkw`) and command files for Surfer (`.sucl`) and Questa (`.do`),
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
        let comparison = OutputComparison {
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

/// Builds Verilog and runs it beside the reference model, whatever Verilog the options name. Without
/// a number of clocks it runs one whole scan of photons, or until the adversary has covered all
/// that it can and gone on by chance ([`clocks_of_a_run`](crate::reference::adversarial::Adversarial::clocks_of_a_run)), at most [`LONGEST_DEFAULT`](crate::reference::adversarial::LONGEST_DEFAULT).
///
/// # Errors
/// When a tool is missing or fails, the Verilog does not compile, its ports do not
/// fit, or it ends the simulation. A mismatch is a result.
pub fn cosimulate(
    sensor: &Sensor,
    verilog: &Verilog,
    options: &CosimOptions,
    mut on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let sensor = &held_to(sensor, verilog, options)?;
    let done = by_engine(sensor, verilog, options, &mut on_progress);
    let mut done = done.map_err(|error| match error {
        CosimError::Halted { when, reason } => {
            CosimError::Halted { when, reason: in_users_terms(&reason, &verilog.sources) }
        }
        other => other,
    })?;
    if verilog.is_users() {
        done.report.remarks =
            lanes::meaning::remarks(&verilog.top, &verilog.sources, &verilog.cache)?;
    }
    Ok(done)
}

fn by_engine(
    sensor: &Sensor,
    verilog: &Verilog,
    options: &CosimOptions,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let mut not_in_lanes = None;
    if options.engine != Engine::Lockstep {
        match beside_lanes::in_lanes(sensor, verilog, options, on_progress) {
            Ok(done) => return Ok(done),
            Err(LaneRefusal::Unfit(reason)) if options.engine == Engine::Lanes => {
                return Err(CosimError::NoLanes(reason.to_string()));
            }
            Err(LaneRefusal::NoVerdict(reason)) if options.engine == Engine::Lanes => {
                return Err(CosimError::NoVerdict(reason));
            }
            Err(LaneRefusal::Unfit(reason)) => not_in_lanes = Some(reason.to_string()),
            Err(LaneRefusal::NoVerdict(reason)) => not_in_lanes = Some(reason),
            Err(LaneRefusal::Failed(error)) => return Err(error),
        }
    }
    let interface = sensor.interface();
    let reference = ReferenceModel::new(interface.clone())?;
    let registers =
        verilog.registers.as_ref().filter(|_| options.stimulus == StimulusKind::Adversarial);
    let build = |registers| {
        build::build_with(&verilog.top, &verilog.sources, interface, registers, &verilog.cache)
    };
    let built = match build(registers) {
        // A manifest names counters that its Verilog has not, or no longer.
        Err(CosimError::ToolFailed { .. }) if registers.is_some() && verilog.is_users() => {
            build(None)?
        }
        built => built?,
    };
    let mut done = side_by_side::run(sensor, reference, &built, options, on_progress)?;
    done.report.not_in_lanes = not_in_lanes;
    Ok(done)
}

//! The same RTL, many copies at once: *lanes*.
//!
//! Yosys turns the RTL into gates and registers of one bit ([`yosys`], [`netlist`]).
//! Written as C++ in which every net is a vector of 256 bits ([`vectors`]), one pass
//! through them clocks 256 independent copies. Written as Verilog in which every net is a word of
//! 64 bits ([`verilog`]), Verilator makes another program of them, which sees a part of each
//! run ([`referee`]).

pub mod design;
mod expected;
mod high_samples;
pub(in crate::cosim) mod meaning;
mod model;
pub mod mutants;
pub mod netlist;
mod places;
mod planes;
mod pulses;
mod recurrence;
mod referee;
pub mod run;
mod slices;
mod starts;
mod storage;
mod synthesis;
mod tables;
mod tally;
#[cfg(test)]
mod tests;
pub mod variants;
mod vectors;
pub mod verilog;
mod watch;
mod word;
mod yosys;

pub use self::yosys::Memories;

use std::num::NonZero;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::thread::available_parallelism;

use self::design::LaneDesign;
use self::expected::ExpectedRun;
use self::meaning::refuse_ambiguous;
use self::pulses::LaneStimulus;
use self::run::{LanesOutcome, LanesRun};
use self::slices::Slices;
use self::starts::Starts;
use self::vectors::LANES;
use self::word::Setup;
use super::error::CosimError;
use super::source::SourceFile;
use crate::photons::DetectorModel;
use crate::sensor::interface::Interface;

/// Why a design or a run has no place in lanes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unfit(String);

impl Unfit {
    pub(crate) fn new(reason: impl Into<String>) -> Unfit {
        Unfit(reason.into())
    }
}

/// Why lanes gave no answer.
#[derive(Debug, thiserror::Error)]
pub enum LaneRefusal {
    /// It has no place in lanes: lock-step does it.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// Lanes have run, and tell nothing: a lane began with a guess that was wrong, or the
    /// design differs. Lock-step tells which.
    #[error("{0}")]
    NoVerdict(String),
    /// Something fails.
    #[error(transparent)]
    Failed(#[from] CosimError),
}

impl LaneRefusal {
    pub(crate) fn unfit(reason: impl Into<String>) -> LaneRefusal {
        LaneRefusal::Unfit(Unfit::new(reason))
    }
}

/// A design that can run a scene's photons in lanes.
#[derive(Debug, Clone)]
pub struct PreparedLanes {
    design: LaneDesign,
    starts: Starts,
    interface: Interface,
}

/// Lanes hold registers of one bit, and a histogram's bins lie in memories.
///
/// # Errors
/// When the hardware keeps a histogram.
pub fn refuse_memories(interface: &Interface) -> Result<(), Unfit> {
    match interface.histogram() {
        None => Ok(()),
        Some(_) => Err(Unfit::new("a histogram is kept in memories, which have no place in lanes")),
    }
}

impl PreparedLanes {
    /// Builds a design, and finds the states in which lanes start; both are kept.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn new(
        top: &str,
        sources: &[SourceFile],
        interface: &Interface,
        clocks: u64,
        cache: &Path,
    ) -> Result<PreparedLanes, LaneRefusal> {
        refuse_memories(interface)?;
        if interface.input_cells.count > 1 {
            return Err(LaneRefusal::unfit(
                "a detector whose cells have an input each (cell_outputs = \"separate\") has a level when \
                 a lane starts that one pulse does not tell",
            ));
        }
        Slices::of(interface, clocks, lanes())?;
        refuse_ambiguous(top, sources, cache)?;
        let design = LaneDesign::build(top, sources, interface, cache)?;
        Ok(PreparedLanes {
            starts: Starts::of(&design, interface, cache)?,
            design,
            interface: interface.clone(),
        })
    }

    /// Runs the first `clocks` clocks of a scan's photons in lanes, and compares every
    /// output at every clock with the reference model. `on_progress` gets the number
    /// of clocks compared so far; where `stop` is set the run ends early.
    ///
    /// # Errors
    /// When the run has no place in lanes, its registers do not stitch, a model fails,
    /// or it was stopped.
    pub fn run(
        &self,
        models: &[DetectorModel],
        seed: u64,
        clocks: u64,
        stop: &AtomicBool,
        on_progress: &(dyn Fn(u64) + Sync),
    ) -> Result<LanesOutcome, LaneRefusal> {
        self.lanes_run(models, seed, clocks, stop)?.run(on_progress)
    }

    /// Makes the photons of [`PreparedLanes::run`], and nothing of them: for a bench.
    ///
    /// # Errors
    /// When there are too many, or it was stopped.
    pub fn photons(
        &self,
        models: &[DetectorModel],
        seed: u64,
        clocks: u64,
        stop: &AtomicBool,
    ) -> Result<(), LaneRefusal> {
        let run = self.lanes_run(models, seed, clocks, stop)?;
        run.light.pulses(clocks, run.threads, stop, |_, _| ())?;
        Ok(())
    }

    /// Makes the photons of [`PreparedLanes::run`], and what the reference model expects of them: for
    /// a bench.
    ///
    /// # Errors
    /// As [`PreparedLanes::photons`].
    pub fn expectations(
        &self,
        models: &[DetectorModel],
        seed: u64,
        clocks: u64,
        stop: &AtomicBool,
    ) -> Result<(), LaneRefusal> {
        let run = self.lanes_run(models, seed, clocks, stop)?;
        ExpectedRun::of(&run.light, &run.setup.slices, run.threads, stop)?;
        Ok(())
    }

    fn lanes_run<'a>(
        &'a self,
        models: &'a [DetectorModel],
        seed: u64,
        clocks: u64,
        stop: &'a AtomicBool,
    ) -> Result<LanesRun<'a>, LaneRefusal> {
        Ok(LanesRun {
            setup: Setup {
                design: &self.design,
                interface: &self.interface,
                starts: &self.starts,
                slices: Slices::of(&self.interface, clocks, lanes())?,
                stop,
            },
            light: LaneStimulus { models, interface: &self.interface, seed },
            threads: threads(),
        })
    }
}

/// Threads that work at once.
pub(crate) fn threads() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

/// Lanes that this machine clocks at once: a vector's for each of its cores.
fn lanes() -> u64 {
    (threads() * LANES) as u64
}

//! The score of a stimulus on a design: how many faults and mutants it finds.
//!
//! Lane 0 is the good design, every other lane has one fault, or is one mutant; all get
//! the same stimulus. One is caught at the first clock at which an output differs from
//! lane 0's. What is not caught gets the hostile inputs of a co-simulation, if it was
//! another stimulus that is graded; and what these do not show either is compared with
//! the design by a model checker, from the state after reset on ([`proof`]): it is
//! equivalent, or inputs exist that show it, or nobody knows.

mod aiger;
mod labels;
mod options;
mod outcome;
mod proof;
mod run;
#[cfg(test)]
mod tests;
mod tried;
mod variant_set;

use std::thread;

use serde::{Deserialize, Serialize};

pub use self::options::{GradeOptions, GradeStimulus};
pub use self::outcome::{FaultOutcome, Outcomes};
pub use self::proof::Bounds;
use self::proof::{ProofAnswer, prove};
use self::run::Stream;
use self::tried::Tried;
use self::variant_set::VariantSet;
use crate::cosim::error::CosimError;
use crate::cosim::lanes::design::LaneDesign;
use crate::cosim::lanes::{LaneRefusal, Memories};
use crate::cosim::source::Verilog;
use crate::document::Body;
use crate::sensor::Sensor;

/// What a stimulus is worth; the JSON of `goldtof grade`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Grade {
    /// The stimulus.
    pub stimulus: GradeStimulus,
    /// Its seed.
    pub seed: u64,
    /// Its clocks.
    pub clocks: u64,
    /// The smaller of the shares of faults and mutants.
    pub caught_fraction: f64,
    /// The share that was asked for.
    pub asked_fraction: Option<f64>,
    /// Nets stuck at 0 or at 1.
    pub faults: Score,
    /// Mutants of Yosys, if they were asked for.
    pub mutants: Option<Score>,
    /// How long the model checker may take.
    pub proof_bounds: Bounds,
}

impl Body for Grade {
    const NAME: &'static str = "grade";
}

/// How many of a kind are caught. All of them are either caught, or proven equivalent,
/// or not caught, or undecided.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Score {
    /// All.
    pub total: usize,
    /// Those that an output shows.
    pub caught: usize,
    /// Those of the others that no stimulus could show, as proven.
    pub proven_equivalent: usize,
    /// Those that inputs would show, but not these.
    pub not_caught: usize,
    /// Those that were not shown, and of which nothing was proven in the time allowed.
    pub undecided: usize,
    /// Caught of all that are not proven equivalent.
    pub caught_fraction: f64,
    /// Clock by which the last of the caught ones had been.
    pub last_caught_clock: Option<u64>,
    /// Those that are neither caught nor proven equivalent.
    pub survivors: Vec<Judged>,
    /// All of them, in the order of their numbers: the grade can be worked out from these.
    pub list: Vec<Judged>,
}

/// A fault or mutant, and its verdict.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Judged {
    /// What it is: stuck at 0, stuck at 1, or Yosys's name of what a mutant does.
    pub change: String,
    /// Where: the net with its bit, or the cell and its port.
    pub net: String,
    /// File and lines of the Verilog; empty where Yosys knows none.
    pub source: String,
    /// What is known of it.
    pub verdict: FaultVerdict,
    /// If it is caught, the clock of the stimulus at which an output showed it.
    pub clock: Option<u64>,
    /// If it is proven equivalent, how.
    pub proof: Option<String>,
    /// If it is neither, what would have to happen.
    pub needs: Option<String>,
}

/// What is known of a fault or mutant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FaultVerdict {
    /// An output showed it.
    Caught,
    /// No stimulus could show it, as proven.
    ProvenEquivalent,
    /// Inputs exist that show it, but not these.
    NotCaught,
    /// Neither were such inputs found, nor that there are none.
    Undecided,
}

/// What became of some of a design's faults and mutants, or of all.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Graded {
    /// Clocks of the stimulus.
    pub clocks: u64,
    /// Nets stuck at 0 or at 1.
    pub faults: Outcomes,
    /// Mutants of Yosys, if they were asked for.
    pub mutants: Option<Outcomes>,
}

impl Graded {
    /// What a stimulus is worth by what became of all.
    pub fn grade(self, options: &GradeOptions) -> Grade {
        let faults = self.faults.score();
        let mutants = self.mutants.map(Outcomes::score);
        let share = |score: &Score| score.caught_fraction;
        Grade {
            stimulus: options.stimulus,
            seed: options.seed,
            clocks: self.clocks,
            caught_fraction: share(&faults).min(mutants.as_ref().map_or(1.0, share)),
            asked_fraction: options.asked_fraction,
            faults,
            mutants,
            proof_bounds: options.proof_bounds(),
        }
    }
}

/// Most bits of a memory that is graded: each is a register of its own.
const MOST_MEMORY_BITS: u128 = 2048;

/// Refuses a sensor of which no design can be graded.
///
/// # Errors
/// When its hardware keeps a large histogram.
pub fn refuse(sensor: &Sensor) -> Result<(), CosimError> {
    memories_of(sensor).map(|_| ()).map_err(not_graded)
}

/// What becomes of the memories of a sensor's hardware.
fn memories_of(sensor: &Sensor) -> Result<Memories, LaneRefusal> {
    let interface = sensor.interface();
    let histogram =
        interface.histogram().map(|plan| plan.memory_bits(interface.reference_codes.len()));
    // What a host has set, and what identifies the design.
    let registers = interface.registers.as_ref().map(|plan| 32 << plan.word_bits());
    match histogram.or(registers) {
        None => Ok(Memories::Refused),
        Some(bits) if bits <= MOST_MEMORY_BITS => Ok(Memories::Registers),
        Some(bits) => Err(LaneRefusal::unfit(format!(
            "its histogram has {bits} bits, and at most {MOST_MEMORY_BITS} are graded, each as a \
             register; grade the same hardware with a shorter code, fewer samples per chip, or \
             buffers = 1"
        ))),
    }
}

/// Why there is no grade.
pub fn not_graded(refusal: LaneRefusal) -> CosimError {
    match refusal {
        LaneRefusal::Unfit(reason) => CosimError::NotGraded(reason.to_string()),
        LaneRefusal::NoVerdict(reason) => CosimError::NotGraded(reason),
        LaneRefusal::Failed(error) => error,
    }
}

/// Tries a stimulus on faults and mutants of a design: on those that `choose` says, by
/// their numbers in order, given how many there are of a kind.
///
/// # Errors
/// What of the design has no place in lanes; or a tool fails.
pub fn grade(
    sensor: &Sensor,
    verilog: &Verilog,
    options: &GradeOptions,
    choose: impl Fn(usize) -> Vec<usize> + Sync,
    mut on_progress: impl FnMut(&'static str),
) -> Result<Graded, LaneRefusal> {
    let memories = memories_of(sensor)?;
    let design = LaneDesign::netlist(&verilog.top, &verilog.sources, memories, &verilog.cache)?;
    let stream = Stream::of(sensor, verilog, options, &design)?;
    on_progress("comparing the design with the reference model");
    stream.check()?;
    on_progress("running faults and mutants");
    let witness = stream.witness()?;
    let run = |set: VariantSet| {
        let chosen = choose(set.count());
        Tried::new(set, chosen, &stream, witness.as_ref())
    };
    let (faults, mutants) = thread::scope(|scope| {
        let mutants = scope.spawn(|| match options.mutants {
            0 => Ok(None),
            count => run(VariantSet::mutants(verilog, options, memories, count)?).map(Some),
        });
        let faults = run(VariantSet::faults(&design));
        let mutants = mutants.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok::<_, LaneRefusal>((faults?, mutants?))
    })?;
    on_progress("proving what is left");
    let tried = || std::iter::once(&faults).chain(&mutants);
    let questions: Vec<_> = tried().flat_map(Tried::questions).collect();
    let mut answers = prove(&questions, verilog.is_users(), options.proof_bounds())?.into_iter();
    let mut outcomes = |tried: &Tried| {
        let answers: Vec<ProofAnswer> = answers.by_ref().take(tried.open.len()).collect();
        Outcomes {
            total: tried.total(),
            of: tried.outcomes(&answers, &verilog.sources, options.seed),
        }
    };
    Ok(Graded {
        clocks: stream.clocks,
        faults: outcomes(&faults),
        mutants: mutants.as_ref().map(outcomes),
    })
}

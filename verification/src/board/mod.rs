//! A board's Verilog among hostile surroundings: what stands round the core is right, or has a fault.
//!
//! The board is taken as a black box between its pins, with models of the vendor's cells, and the ports of its core.
//! For most runs something else stands in the core's place, which sends whatever results and answers AXI4-Lite as
//! slowly as it likes ([`crate::deliver::board::CORE_BENCH`]); a last one has the core itself, and its results are
//! those of the reference model.

mod cover;
mod line;
mod maker;
mod model;
mod own_core;
mod runs;
mod script;

use serde::Serialize;

pub use self::cover::BoardCoverPoint;
use self::cover::Cover;
pub use self::model::Facts;
use crate::cosim::Verdict;
use crate::cosim::error::CosimError;
use crate::cosim::own::OwnRtl;
use crate::deliver::Emission;
use crate::document::Body;
use crate::sensor::Sensor;

/// What was found of a board; the JSON of `goldtof cosim --board`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct BoardReport {
    /// What the runs say.
    pub verdict: Verdict,
    /// Name of the board.
    pub board: String,
    /// Seed of all that is random.
    pub seed: u64,
    /// The runs, up to the one before that which found a fault.
    pub runs: Vec<BoardRun>,
    /// What is wrong, and in which run.
    pub fault: Option<String>,
    /// How often each situation came up that the runs are there for. One that never did makes the verdict
    /// inconclusive.
    pub cover: Vec<BoardCoverPoint>,
    /// What was ignored of the Verilog, or assumed.
    pub remarks: Vec<String>,
}

impl Body for BoardReport {
    const NAME: &'static str = "board";
}

/// A run of the board.
#[derive(Debug, Clone, Default, Serialize, schemars::JsonSchema)]
pub struct BoardRun {
    /// What is done to the board.
    pub name: &'static str,
    /// Chips that it ran.
    pub chips: u64,
    /// Bytes that the host read.
    pub bytes: u64,
    /// Results in them.
    pub results: u64,
    /// Requests that were answered as they have to be.
    pub answers: u64,
}

/// Runs a board: the emitted one, or that of the user's folder.
///
/// # Errors
/// When a tool is missing or fails, or the Verilog does not compile. A fault is a result.
pub fn check(
    sensor: &Sensor,
    emission: &Emission,
    own: &OwnRtl,
    seed: u64,
    mut on_run: impl FnMut(&'static str),
) -> Result<BoardReport, CosimError> {
    let facts = Facts::of(sensor, emission)?;
    on_run("compiling models of the board");
    let (bench, remarks) = model::build(sensor, emission, own, true)?;
    let mut cover = Cover::of(&facts);
    let mut report = BoardReport {
        verdict: Verdict::Match,
        board: facts.board.clone(),
        seed,
        runs: Vec::new(),
        fault: None,
        cover: Vec::new(),
        remarks,
    };
    let mut first = 0;
    for run in runs::RUNS.iter().filter(|run| (run.is_meant)(&facts)) {
        on_run(run.name);
        let mut script = (run.script)(sensor, &facts, seed)?;
        script.first = first;
        let outcome = if script.is_whole() {
            let (whole, others) = model::build(sensor, emission, own, false)?;
            let is_new = |remark: &String| !report.remarks.contains(remark);
            let new: Vec<String> = others.into_iter().filter(is_new).collect();
            report.remarks.extend(new);
            whole.run(&script, seed)?
        } else {
            bench.run(&script, seed)?
        };
        first = outcome.first.unwrap_or(first);
        match facts.check(&script, &outcome, &mut cover) {
            Ok(told) => report.runs.push(BoardRun { name: run.name, ..told }),
            Err(fault) => {
                report.fault = Some(format!("{}: {fault}", run.name));
                report.verdict = Verdict::Mismatch;
                break;
            }
        }
    }
    if report.fault.is_none() && !cover.is_whole() {
        report.verdict = Verdict::Inconclusive;
    }
    report.cover = cover.0;
    Ok(report)
}

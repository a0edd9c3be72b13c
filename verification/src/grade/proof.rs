//! Yosys's ABC: whether two designs are equal at every clock, whatever comes.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

use super::aiger::{Started, miter};
use super::variant_set::VariantSet;
use crate::cosim::error::CosimError;
use crate::cosim::tools::Tool;
use crate::programs;

/// Time of the first look at each, in seconds: most are settled at once, and none is to
/// wait behind those that take long.
const FIRST_LOOK_S: u32 = 1;
/// What a program may take beyond its own time limit, which it looks at only now and
/// then, before it is ended.
const GRACE: Duration = Duration::from_secs(2);

/// What a proof is, for those who read a grade.
pub(super) const PROOF: &str = "ABC (scorr; pdr): from the state after reset on no output differs \
     from the design's, whatever the inputs";

/// How long the model checker may take, in seconds of wall time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Bounds {
    /// For each fault or mutant.
    pub each_s: u32,
    /// For all together; as many are looked at at once as there are cores.
    pub all_s: u32,
}

impl Default for Bounds {
    fn default() -> Bounds {
        Bounds { each_s: 5, all_s: 60 }
    }
}

/// What the model checker says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ProofAnswer {
    /// No stimulus shows a difference.
    Equivalent,
    /// What would show it.
    Shown(String),
    /// Why nobody knows.
    Undecided(String),
}

/// A variant that is to be compared with the good design.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    /// Where it is from.
    pub(super) set: &'a VariantSet,
    /// Which one it is.
    pub(super) number: usize,
    /// The good design's registers after reset.
    pub(super) good_values: &'a [bool],
    /// Its own.
    pub(super) values: &'a [bool],
}

/// Compares variants with their good designs, several at once: first a short look at
/// each, then a longer one at what is left, until the time for all is up. With
/// `ignores_idle_payload` what the result stream shows while it is not valid may differ.
///
/// # Errors
/// When ABC is missing or fails.
pub(super) fn prove(
    questions: &[Question],
    ignores_idle_payload: bool,
    bounds: Bounds,
) -> Result<Vec<ProofAnswer>, CosimError> {
    let until = Instant::now() + Duration::from_secs(bounds.all_s.into());
    let out_of_time = || ProofAnswer::Undecided(format!("not looked at within {} s", bounds.all_s));
    let mut answers: Vec<ProofAnswer> = questions.iter().map(|_| out_of_time()).collect();
    let mut left: Vec<usize> = (0..questions.len()).collect();
    for limit_s in [FIRST_LOOK_S.min(bounds.each_s), bounds.each_s] {
        let ask = |&place: &usize| {
            let is_time = Instant::now() < until;
            let found = is_time.then(|| questions[place].ask(ignores_idle_payload, limit_s));
            found.transpose()
        };
        let found: Result<Vec<_>, CosimError> = left.par_iter().with_max_len(1).map(ask).collect();
        for (&place, found) in left.iter().zip(found?) {
            if let Some(found) = found {
                answers[place] = found;
            }
        }
        left.retain(|&place| matches!(answers[place], ProofAnswer::Undecided(_)));
        if limit_s == bounds.each_s {
            break;
        }
    }
    Ok(answers)
}

impl Question<'_> {
    fn ask(&self, ignores_idle_payload: bool, limit_s: u32) -> Result<ProofAnswer, CosimError> {
        let folder = tempfile::tempdir().map_err(CosimError::cache(std::env::temp_dir()))?;
        let good = Started { netlist: &self.set.good, values: self.good_values };
        let variant = self.set.variant(self.number);
        let variant = Started { netlist: &variant, values: self.values };
        let bytes = miter(good, variant, ignores_idle_payload);
        let path = folder.path().join("miter.aig");
        fs::write(&path, bytes).map_err(CosimError::cache(&path))?;
        let undecided = || ProofAnswer::Undecided(format!("not decided within {limit_s} s"));
        match abc(folder.path(), limit_s) {
            Ok(said) => Ok(answer(&said).unwrap_or_else(undecided)),
            Err(CosimError::ToolTimeout { .. }) => Ok(undecided()),
            Err(error) => Err(error),
        }
    }
}

fn abc(folder: &Path, limit_s: u32) -> Result<String, CosimError> {
    let script = format!("read_aiger miter.aig; scorr; pdr -T {limit_s}");
    let limit = Duration::from_secs(limit_s.into()) + GRACE;
    Tool::abc().run_for(
        |command| command.current_dir(folder).args(["-q", &script]),
        Stdio::piped(),
        limit.min(programs::time_limit()),
    )
}

/// What ABC said, if it came to an end.
fn answer(said: &str) -> Option<ProofAnswer> {
    said.lines().find_map(|line| {
        if line.contains("Property proved") {
            return Some(ProofAnswer::Equivalent);
        }
        let (_, frame) = line.split_once("was asserted in frame ")?;
        let digits: String = frame.chars().take_while(char::is_ascii_digit).collect();
        Some(ProofAnswer::Shown(format!("inputs that show it {digits} clocks after reset exist")))
    })
}

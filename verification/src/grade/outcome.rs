//! What became of faults and mutants, one by one, and the score that they are together.

use serde::{Deserialize, Serialize};

use super::{FaultVerdict, Judged, Score};

/// A fault or a mutant, and what became of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(rename = "Outcome")]
pub struct FaultOutcome {
    /// Its number among all of its kind, from 0.
    pub number: usize,
    /// What it is, and what became of it.
    pub judged: Judged,
}

/// Faults, or mutants: how many there are, and what became of those that were run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Outcomes {
    /// All of the kind.
    pub total: usize,
    /// Those that were run, in order.
    pub of: Vec<FaultOutcome>,
}

impl Outcomes {
    /// Takes those that another run has of the same variants.
    pub fn append(&mut self, others: Outcomes) {
        self.of.extend(others.of);
        self.of.sort_by_key(|outcome| outcome.number);
    }

    /// The score, once all are there.
    pub fn score(self) -> Score {
        let list: Vec<Judged> = self.of.into_iter().map(|outcome| outcome.judged).collect();
        let of = |verdict| list.iter().filter(|judged| judged.verdict == verdict).count();
        let (total, caught) = (list.len(), of(FaultVerdict::Caught));
        let proven_equivalent = of(FaultVerdict::ProvenEquivalent);
        Score {
            total,
            caught,
            proven_equivalent,
            not_caught: of(FaultVerdict::NotCaught),
            undecided: of(FaultVerdict::Undecided),
            caught_fraction: match total - proven_equivalent {
                // There is nothing that could have been missed.
                0 => 1.0,
                shown => caught as f64 / shown as f64,
            },
            last_caught_clock: list.iter().filter_map(|judged| judged.clock).max(),
            survivors: list.iter().filter(|judged| judged.survives()).cloned().collect(),
            list,
        }
    }
}

impl Judged {
    /// What would have to happen, or why nothing could: empty of what is caught.
    pub fn reason(&self) -> &str {
        self.needs.as_deref().or(self.proof.as_deref()).unwrap_or_default()
    }

    /// Whether it is neither caught nor proven equivalent.
    fn survives(&self) -> bool {
        matches!(self.verdict, FaultVerdict::NotCaught | FaultVerdict::Undecided)
    }
}

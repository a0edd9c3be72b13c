//! What became of faults and mutants, one by one, and the score that they are together.

use serde::{Deserialize, Serialize};

use super::{Score, Survivor, Verdict};

/// A fault or a mutant, and what became of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Outcome {
    /// Its number among all of its kind, from 0.
    pub number: usize,
    /// What became of it.
    pub fate: Fate,
}

/// What became of a fault or a mutant.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// An output showed it.
    Caught(
        /// The clock at which an output showed it.
        u64,
    ),
    /// No stimulus could show it, as proven.
    Equivalent,
    /// It was not shown.
    Survives(
        /// What it is, and what is known of it.
        Survivor,
    ),
}

/// Faults, or mutants: how many there are, and what became of those that were run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Outcomes {
    /// All of the kind.
    pub total: usize,
    /// Those that were run, in order.
    pub of: Vec<Outcome>,
}

impl Outcomes {
    /// Takes those that another run has of the same variants.
    pub fn append(&mut self, others: Outcomes) {
        self.of.extend(others.of);
        self.of.sort_by_key(|outcome| outcome.number);
    }

    /// The score, once all are there.
    pub fn score(self) -> Score {
        let total = self.of.len();
        let (mut caught, mut proven_equivalent) = (0, 0);
        let mut last_caught_clock = None;
        let mut survivors = Vec::new();
        for outcome in self.of {
            match outcome.fate {
                Fate::Caught(clock) => {
                    caught += 1;
                    last_caught_clock = last_caught_clock.max(Some(clock));
                }
                Fate::Equivalent => proven_equivalent += 1,
                Fate::Survives(survivor) => survivors.push(survivor),
            }
        }
        let of = |verdict| {
            let found = survivors.iter();
            found.filter(|found: &&Survivor| found.verdict == verdict).count()
        };
        Score {
            total,
            caught,
            proven_equivalent,
            not_caught: of(Verdict::NotCaught),
            undecided: of(Verdict::Undecided),
            caught_fraction: match total - proven_equivalent {
                // There is nothing that could have been missed.
                0 => 1.0,
                shown => caught as f64 / shown as f64,
            },
            last_caught_clock,
            survivors,
        }
    }
}

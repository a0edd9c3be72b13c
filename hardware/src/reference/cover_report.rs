//! How much of what a sensor can be made to do a co-simulation has seen.

use serde::Serialize;

use crate::reference::adversarial::{Adversarial, Means};
use crate::reference::coverage::{CoverPoint, CoverTable, Covered};
use crate::sensor::interface::Interface;

/// Points that the text names at most.
const MOST_NAMED: usize = 6;

/// Cover points of a scene, and which of them were covered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Coverage {
    /// Points that can be reached.
    pub points: usize,
    /// Those that were covered.
    pub covered: usize,
    /// Those that were not, and that the stimulus cannot cover in such a run: each has its reason.
    pub out_of_reach: usize,
    /// By what they belong to.
    pub families: Vec<FamilyCoverage>,
    /// Points that were not covered.
    pub not_covered: Vec<Missed>,
    /// Points that no inputs of this scene reach, with the reason.
    pub unreachable: Vec<Missed>,
}

/// Cover points of one kind.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct FamilyCoverage {
    /// Their kind.
    pub family: &'static str,
    /// Points that can be reached.
    pub points: usize,
    /// Those that were covered.
    pub covered: usize,
}

/// A cover point that was not covered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Missed {
    /// What it is.
    pub point: String,
    /// Why; none where a longer run may cover it.
    pub reason: Option<String>,
}

impl Coverage {
    /// What was covered, with the detectors' names. `means` are those of the adversary
    /// that was to cover it, if it was one.
    pub fn new(
        interface: &Interface,
        table: &CoverTable,
        covered: &Covered,
        names: &[String],
        means: Option<Means>,
    ) -> Coverage {
        let mut families: Vec<FamilyCoverage> = Vec::new();
        let mut not_covered = Vec::new();
        for (number, point) in table.points().iter().enumerate() {
            let is_covered = covered.contains(number);
            let family = point.family();
            let place = families.iter().position(|f| f.family == family);
            let place = place.unwrap_or_else(|| {
                let (points, covered) = (0, 0);
                families.push(FamilyCoverage { family, points, covered });
                families.len() - 1
            });
            families[place].points += 1;
            families[place].covered += usize::from(is_covered);
            if !is_covered {
                not_covered.push(Missed {
                    point: point.text(names),
                    reason: means
                        .and_then(|means| Adversarial::hindrance(interface, means, *point)),
                });
            }
        }
        let unreachable = table.unreachable().iter();
        Coverage {
            points: table.points().len(),
            covered: covered.count(),
            out_of_reach: not_covered.iter().filter(|missed| missed.reason.is_some()).count(),
            families,
            not_covered,
            unreachable: unreachable
                .map(|(point, reason): &(CoverPoint, _)| Missed {
                    point: point.text(names),
                    reason: Some((*reason).to_owned()),
                })
                .collect(),
        }
    }

    /// How many were covered, of how many, and how many are out of reach.
    pub fn score(&self) -> String {
        let score = format!("{} of {} cover points reached", self.covered, self.points);
        match self.out_of_reach {
            0 => score,
            some => format!("{score}, {some} out of reach"),
        }
    }

    /// In one line.
    pub fn summary(&self) -> String {
        let families: Vec<String> = self
            .families
            .iter()
            .map(|f| format!("{} {}/{}", f.family, f.covered, f.points))
            .collect();
        format!("{} of {} cover points ({})", self.covered, self.points, families.join(", "))
    }

    /// In a few lines: how much, what not, and what cannot be.
    pub fn text(&self) -> String {
        let mut text = format!("covered: {}\n", self.summary());
        for (title, missed) in
            [("not covered", &self.not_covered), ("cannot be covered", &self.unreachable)]
        {
            if missed.is_empty() {
                continue;
            }
            let named: Vec<String> = missed.iter().take(MOST_NAMED).map(Missed::text).collect();
            let more = match missed.len().saturating_sub(MOST_NAMED) {
                0 => String::new(),
                more => format!("; and {more} more (--json names them)"),
            };
            text += &format!("{title}: {}{more}\n", named.join("; "));
        }
        text
    }
}

impl Missed {
    /// In words, with the reason.
    pub fn text(&self) -> String {
        match &self.reason {
            Some(reason) => format!("{} ({reason})", self.point),
            None => self.point.clone(),
        }
    }
}

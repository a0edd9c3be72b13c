//! The SPADs of a detector, and what their pulses make of its level.

use std::ops::Range;

use crate::scan::Sample;
use crate::scene::{Combination, Detector};

/// SPADs whose pulses make the level of one detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cells {
    /// How many there are, at most 64.
    pub count: u32,
    /// What their pulses make of the level.
    pub combination: Combination,
    /// How many pulses have to overlap, if that is what makes it high.
    pub coincidence: u32,
}

/// What gives the level of a sample from those of some cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gates {
    /// High where an odd number of them is.
    Xor,
    /// High where any of them is.
    Or,
    /// High where all of them are.
    And,
    /// High where so many of them are, more than one and fewer than all.
    AtLeast(u32),
}

impl Cells {
    /// A single SPAD.
    pub const ONE: Cells = Cells { count: 1, combination: Combination::Or, coincidence: 1 };

    /// Those of a detector.
    pub fn of(detector: &Detector) -> Cells {
        let Detector { cells: count, combination, coincidence, .. } = *detector;
        Cells { count, combination, coincidence }
    }

    /// What gives their level; none where each has its own.
    pub fn gates(&self) -> Option<Gates> {
        match (self.combination, self.coincidence) {
            _ if self.count == self.edges() => None,
            (Combination::Xor, _) => Some(Gates::Xor),
            (Combination::Or, all) if all == self.count => Some(Gates::And),
            (Combination::Or, least) if least > 1 => Some(Gates::AtLeast(least)),
            _ => Some(Gates::Or),
        }
    }

    /// Levels whose rising edges are counted: the one that all cells make together, or each cell's.
    #[inline]
    pub fn edges(&self) -> u32 {
        if self.combination == Combination::Adder { self.count } else { 1 }
    }

    /// The level while so many of their pulses are high.
    #[inline]
    pub fn level(&self, high: u32) -> bool {
        match self.combination {
            Combination::Or | Combination::Adder => high >= self.coincidence,
            Combination::Xor => high % 2 == 1,
        }
    }
}

/// Pulses of a detector's cells begin and end at a sample: bit c is cell c's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellChange {
    /// The sample.
    pub sample: Sample,
    /// Cells with a pulse at the one before.
    pub before: u64,
    /// Cells with a pulse at it.
    pub after: u64,
}

impl CellChange {
    /// Those of some changes, in order, that are at these samples.
    pub fn within<'c>(changes: &'c [CellChange], samples: &Range<Sample>) -> &'c [CellChange] {
        let before = |sample: Sample| changes.partition_point(|change| change.sample < sample);
        &changes[before(samples.start)..before(samples.end)]
    }

    /// Hits at the sample: of the level that rises, or of each cell that does.
    pub fn hits(&self, cells: &Cells) -> u32 {
        match cells.combination {
            Combination::Adder => self.begun().count_ones(),
            Combination::Or | Combination::Xor => {
                let [before, after] =
                    [self.before, self.after].map(|high| cells.level(high.count_ones()));
                u32::from(!before && after)
            }
        }
    }

    /// Cells whose pulse begins.
    pub fn begun(&self) -> u64 {
        self.after & !self.before
    }
}

//! The SPADs of a detector, and what their pulses make of its level.

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

impl Cells {
    /// A single SPAD.
    pub const ONE: Cells = Cells { count: 1, combination: Combination::Or, coincidence: 1 };

    /// Those of a detector.
    pub fn of(detector: &Detector) -> Cells {
        let Detector { cells: count, combination, coincidence, .. } = *detector;
        Cells { count, combination, coincidence }
    }

    /// The level while so many of their pulses are high.
    pub fn level(&self, high: u32) -> bool {
        match self.combination {
            Combination::Or => high >= self.coincidence,
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
    /// Whether the level rises: a hit.
    pub fn is_hit(&self, cells: &Cells) -> bool {
        !cells.level(self.before.count_ones()) && cells.level(self.after.count_ones())
    }
}

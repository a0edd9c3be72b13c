//! What hostile inputs are to reach: a table of cover points that follows from the
//! interface alone, and which of them the reference model has seen.
//!
//! A point is covered when what it names has shown at the ports: a hit with the
//! result that counts it, a reset with the first result after it. So an error
//! there would have been a mismatch.

mod point;
mod reach;
mod running;
mod wording;

use std::collections::HashMap;
use std::sync::Arc;

pub use self::point::{BinPoint, CoverPoint, Family, PeakKind, Place, ResetState};
pub(super) use self::reach::{rows_at_borders, rows_that_may_be_lost};
pub(super) use self::running::{CountedHit, Running};
use crate::sensor::interface::Interface;

/// Cover points of an interface.
#[derive(Debug, Clone)]
pub struct CoverTable {
    points: Vec<CoverPoint>,
    numbers: HashMap<CoverPoint, usize>,
    /// Points that no inputs reach, with the reason.
    unreachable: Vec<(CoverPoint, &'static str)>,
}

/// Which points of a table were covered.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Covered {
    bits: Vec<u64>,
}

impl Covered {
    /// Marks a point; says whether it is new.
    pub(super) fn mark(&mut self, number: usize) -> bool {
        let (word, bit) = (number / 64, 1 << (number % 64));
        if self.bits.len() <= word {
            self.bits.resize(word + 1, 0);
        }
        let is_new = self.bits[word] & bit == 0;
        self.bits[word] |= bit;
        is_new
    }

    /// Whether a point was covered.
    pub fn contains(&self, number: usize) -> bool {
        let word = self.bits.get(number / 64).copied().unwrap_or(0);
        word >> (number % 64) & 1 == 1
    }

    /// Points that were covered.
    pub fn count(&self) -> usize {
        self.bits.iter().map(|word| word.count_ones() as usize).sum()
    }
}

impl CoverTable {
    /// The points of an interface.
    pub fn of(interface: &Interface) -> Arc<CoverTable> {
        let mut table =
            CoverTable { points: Vec::new(), numbers: HashMap::new(), unreachable: Vec::new() };
        reach::fill(interface, &mut table);
        Arc::new(table)
    }

    fn add(&mut self, point: CoverPoint) {
        self.numbers.insert(point, self.points.len());
        self.points.push(point);
    }

    /// Adds a point, or says why it cannot be reached.
    fn add_or(&mut self, point: CoverPoint, hindrance: Option<&'static str>) {
        match hindrance {
            None => self.add(point),
            Some(reason) => self.unreachable.push((point, reason)),
        }
    }

    /// Every point that can be reached.
    pub fn points(&self) -> &[CoverPoint] {
        &self.points
    }

    /// A point's number, if the table has it.
    pub fn number(&self, point: CoverPoint) -> Option<usize> {
        self.numbers.get(&point).copied()
    }

    /// Points that no inputs reach, each with the reason.
    pub fn unreachable(&self) -> &[(CoverPoint, &'static str)] {
        &self.unreachable
    }
}

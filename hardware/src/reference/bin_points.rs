//! Cover points of a histogram's bins: their numbers, looked up once, and those that a frame
//! proves.

use super::coverage::{BinPoint, CoverPoint, CoverTable};
use crate::scene::DetectorIndex;
use crate::sensor::histogram::HistogramPlan;

/// Cover points that a frame proves, each once.
#[derive(Debug, Clone, Default)]
pub(super) struct Proofs {
    numbers: Vec<usize>,
    /// Whether each point is among them.
    has: Vec<bool>,
}

impl Proofs {
    /// Adds a point, if the table has it.
    pub(super) fn add(&mut self, number: Option<usize>) {
        let Some(number) = number else {
            return;
        };
        if self.has.len() <= number {
            self.has.resize(number + 1, false);
        }
        if !std::mem::replace(&mut self.has[number], true) {
            self.numbers.push(number);
        }
    }

    /// All of them, which leaves none.
    pub(super) fn take(&mut self) -> Vec<usize> {
        for &number in &self.numbers {
            self.has[number] = false;
        }
        std::mem::take(&mut self.numbers)
    }
}

/// Numbers of the cover points of a detector's bins.
#[derive(Debug, Clone)]
pub(super) struct BinPoints {
    /// By lane; in the first code period, and later.
    pub(super) hit: Vec<[Option<usize>; 2]>,
    pub(super) full: Vec<Option<usize>>,
    /// By adder, and by bit.
    pub(super) carry: Vec<Vec<Option<usize>>>,
    pub(super) extra: Vec<Option<usize>>,
    pub(super) full_row: Option<usize>,
    /// At the last sample, and at the first.
    pub(super) border: [Option<usize>; 2],
}

impl BinPoints {
    pub(super) fn new(
        plan: &HistogramPlan,
        table: &CoverTable,
        detector: DetectorIndex,
    ) -> BinPoints {
        let number = |point| table.number(CoverPoint::of(detector, point));
        let (lanes, adders) = (0..plan.row_bins, 0..plan.adders());
        let carries = |adder| {
            let bits = 0..plan.bin_bits;
            bits.map(|bit| number(BinPoint::Carry { adder, bit })).collect()
        };
        BinPoints {
            hit: lanes
                .clone()
                .map(|lane| [false, true].map(|later| number(BinPoint::Hit { lane, later })))
                .collect(),
            full: lanes.map(|lane| number(BinPoint::Full { lane })).collect(),
            carry: adders.clone().map(carries).collect(),
            extra: adders.map(|adder| number(BinPoint::Extra { adder })).collect(),
            full_row: number(BinPoint::FullRow),
            border: [false, true].map(|first| number(BinPoint::Border { first })),
        }
    }
}

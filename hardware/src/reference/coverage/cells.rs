//! Cover points of detectors whose cells have an input each.

use super::{Hindered, PointFamily};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Length, PlannedGroup};
use crate::scene::Combination;
use crate::sensor::cells::{CellChange, Cells};

/// What the cells of a detector do. That the hardware sees it so shows in the result that counts the hit,
/// or does not count another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CellPoint {
    /// A hit with so many pulses.
    Hit {
        /// Cells with a pulse at its sample.
        high: u32,
    },
    /// A pulse begins, and with so many of them there is no hit.
    NoHit {
        /// Cells with a pulse.
        high: u32,
    },
    /// A hit that nothing but the pulse of one cell makes.
    Alone {
        /// The cell.
        cell: u32,
    },
    /// A hit as pulses end.
    Ends,
    /// Some pulses begin as others end, and the level stays high.
    TakesOver,
    /// So many cells have a hit at one sample, where each one's count.
    Together {
        /// The cells.
        cells: u32,
    },
    /// A hit of a cell while another one's pulse goes on, where each one's count.
    Beside,
}

/// Those of a detector with these cells.
pub(super) fn points(cells: &Cells) -> Vec<Hindered<CellPoint>> {
    let alone = (0..cells.count).map(|cell| CellPoint::Alone { cell });
    if cells.edges() > 1 {
        let together = (1..=cells.count).map(|cells| CellPoint::Together { cells });
        let all = together.chain(alone).chain([CellPoint::Beside]);
        return all.map(|point| (point, None)).collect();
    }
    let (can_rise, stay_low): (Vec<u32>, Vec<u32>) =
        (1..=cells.count).partition(|&high| cells.level(high));
    let hits = can_rise.into_iter().map(|high| CellPoint::Hit { high });
    let no_hits = stay_low.into_iter().map(|high| CellPoint::NoHit { high });
    let is_odd = cells.combination == Combination::Xor;
    let ends = is_odd.then_some(CellPoint::Ends);
    // All pulses that there can be leave none to take over.
    let takes_over = (is_odd || cells.coincidence < cells.count).then_some(CellPoint::TakesOver);
    let all = hits.chain(no_hits).chain(alone).chain(ends).chain(takes_over);
    all.map(|point| (point, None)).collect()
}

impl PointFamily for CellPoint {
    fn text(&self) -> String {
        match self {
            CellPoint::Hit { high } => format!("a hit with pulses of {high} cells"),
            CellPoint::NoHit { high } => {
                format!("no hit as a pulse begins, with those of {high} cells")
            }
            CellPoint::Alone { cell } => format!("a hit by cell {cell} alone"),
            CellPoint::Ends => "a hit as pulses end".to_owned(),
            CellPoint::TakesOver => "pulses that take over from others without a hit".to_owned(),
            CellPoint::Together { cells } => format!("hits of {cells} cells at one sample"),
            CellPoint::Beside => "a hit of a cell while another one's pulse goes on".to_owned(),
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        // Chance has cells do all of it.
        Ok(maker.again(2, Hits::Random, Length::AtLeast(128)))
    }
}

/// What the cells of a detector have done in the present step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CellsSeen {
    /// Bit n: a hit with pulses of n cells, and none as one begins.
    hits: u128,
    no_hits: u128,
    /// Bit c: a hit by cell c alone.
    alone: u64,
    ends: bool,
    takes_over: bool,
    /// Bit n: hits of n cells at once, where each one's count.
    together: u128,
    beside: bool,
}

impl CellsSeen {
    pub(super) fn add(&mut self, cells: &Cells, change: &CellChange) {
        let &CellChange { before, after, .. } = change;
        let (begun, ended, high) = (change.begun(), before & !after, after.count_ones());
        let hits = change.hits(cells);
        if cells.edges() > 1 {
            self.together |= u128::from(hits > 0) << hits;
            self.beside |= hits > 0 && before & after != 0;
            self.alone |= if hits == 1 { begun } else { 0 };
        } else if hits > 0 {
            self.hits |= 1 << high;
            self.ends |= begun == 0;
            if begun.count_ones() == 1 && ended == 0 {
                self.alone |= begun;
            }
        } else if !cells.level(high) {
            self.no_hits |= u128::from(begun != 0) << high;
        } else {
            self.takes_over |= begun != 0 && ended != 0;
        }
    }

    /// The points that the step's results prove.
    pub(super) fn points(self) -> impl Iterator<Item = CellPoint> {
        let hits = bits(self.hits).map(|high| CellPoint::Hit { high });
        let no_hits = bits(self.no_hits).map(|high| CellPoint::NoHit { high });
        let alone = bits(self.alone.into()).map(|cell| CellPoint::Alone { cell });
        let ends = self.ends.then_some(CellPoint::Ends);
        let takes_over = self.takes_over.then_some(CellPoint::TakesOver);
        let together = bits(self.together).map(|cells| CellPoint::Together { cells });
        let beside = self.beside.then_some(CellPoint::Beside);
        let of_level = hits.chain(no_hits).chain(alone).chain(ends).chain(takes_over);
        of_level.chain(together).chain(beside)
    }
}

/// The places of a word's ones, most often of none.
fn bits(mut word: u128) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lowest = (word != 0).then(|| word.trailing_zeros())?;
        word &= word - 1;
        Some(lowest)
    })
}

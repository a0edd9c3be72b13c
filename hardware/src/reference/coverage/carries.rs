//! Cover points of carries and borrows of counters.

use super::{Hindered, PointFamily, steps};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Length, PlannedGroup};
use crate::sensor::interface::{Correlator, Interface};

/// Hits for which a total's carry is waited.
const MOST_HITS: u64 = 1 << 22;

/// Where a carry goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CarryPoint {
    /// The running total crosses a multiple of 2^bit, where a carry or a borrow leaves a
    /// segment of the counter.
    Carry {
        /// Step of the group.
        step: usize,
        /// Bits below.
        bit: u32,
        /// Upwards.
        up: bool,
    },
    /// A step's count borrows across this bit.
    Borrow {
        /// Step of the group.
        step: usize,
        /// Bits below.
        bit: u32,
    },
    /// The same of the total of all hits: a carry, or a borrow of its difference.
    OfTotal {
        /// Bits below.
        bit: u32,
        /// A borrow, and not a carry.
        borrow: bool,
    },
}

/// Those of a detector.
pub(super) fn points(interface: &Interface, correlator: &Correlator) -> Vec<Hindered<CarryPoint>> {
    let segments = correlator.count_segments;
    let borders = segments.borders();
    let mut points = Vec::new();
    for step in steps(interface) {
        for bit in borders.clone().chain([segments.bits()]) {
            points.extend([false, true].map(|up| CarryPoint::Carry { step, bit, up }));
        }
        points.extend(borders.clone().map(|bit| CarryPoint::Borrow { step, bit }));
    }
    if correlator.total.is_some() {
        for bit in borders.filter(|&bit| bit <= MOST_HITS.ilog2()) {
            let both = [false, true];
            points.extend(both.map(|borrow| CarryPoint::OfTotal { bit, borrow }));
        }
    }
    points.into_iter().map(|point| (point, None)).collect()
}

impl PointFamily for CarryPoint {
    fn text(&self) -> String {
        match *self {
            CarryPoint::Carry { step, bit, up } => format!(
                "a {} out of bit {} of the total of step {step} of a group",
                if up { "carry" } else { "borrow" },
                bit - 1
            ),
            CarryPoint::Borrow { step, bit } => {
                format!("a count that borrows from bit {bit} in step {step} of a group")
            }
            CarryPoint::OfTotal { bit, borrow } => format!(
                "a {} bit {bit} of the total of all hits",
                if borrow { "difference that borrows from" } else { "carry into" }
            ),
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        Ok(match *self {
            CarryPoint::OfTotal { bit, .. } => {
                let pairs = maker.interface.correlator().map_or(1, |correlator| correlator.pairs);
                let chips = (1u64 << bit).div_ceil(u64::from(pairs)) * 2;
                let groups = chips.div_ceil(maker.interface.timing.scan.integration_chips) + 2;
                maker.again(groups, Hits::EveryOther, Length::AtLeast(chips.div_ceil(2)))
            }
            CarryPoint::Carry { step, .. } | CarryPoint::Borrow { step, .. } => {
                let step = step as u64;
                let side = |up| Hits::OneSided { step, up };
                let plain =
                    |up, chips| PlannedGroup::random().with(side(up)).long(Length::AtLeast(chips));
                vec![
                    maker.fresh().with(side(false)).long(Length::AtLeast(64)),
                    plain(true, 160),
                    plain(false, 320),
                    plain(true, 640),
                ]
            }
        })
    }
}

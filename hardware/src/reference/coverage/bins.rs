//! Cover points of the bins of a histogram.

use super::{Hindered, PointFamily};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, PlannedGroup};
use crate::sensor::histogram::{CLOCKS_TO_FLAG, CLOCKS_TO_TURN, HistogramPlan};

/// What a detector's histogram does. Lanes are samples of a word; adders serve neighbouring lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BinPoint {
    /// A hit of this lane counts in the first code period of a frame, or in a later one.
    Hit {
        /// Sample of the word.
        lane: u32,
        /// In a later one.
        later: bool,
    },
    /// A bin of this lane had counts in the frame that its memory held before, and has
    /// none now.
    Emptied {
        /// Sample of the word.
        lane: u32,
    },
    /// A bin's count comes to 2^bit.
    Carry {
        /// Adder.
        adder: u32,
        /// The bit.
        bit: u32,
    },
    /// A bin of this lane with its top bit set is read out of this memory.
    Top {
        /// Sample of the word.
        lane: u32,
        /// The memory.
        memory: usize,
    },
    /// A word with a hit at each adder.
    FullRow,
    /// Several hits at one adder in a word.
    Extra {
        /// Adder.
        adder: u32,
    },
    /// A hit on the first sample of a frame, or on its last.
    Border {
        /// The first.
        first: bool,
    },
    /// A bin at its limit.
    Full {
        /// Sample of the word.
        lane: u32,
    },
    /// A hit finds its bin full, alone, and `o_saturated` rises for it.
    Clamped {
        /// Adder.
        adder: u32,
    },
    /// The same so near to a frame's end that words of the next one have come before the flag.
    ClampedAtEnd {
        /// Clocks from its word to the frame's last.
        age: u32,
        /// The memory that counts.
        memory: usize,
    },
}

/// Those of a detector.
pub(super) fn points(plan: &HistogramPlan) -> Vec<Hindered<BinPoint>> {
    let mut points = Vec::new();
    for lane in 0..plan.row_bins {
        for later in [false, true] {
            let single = later && plan.periods == 1;
            let reason = single.then_some("a frame is a single code period");
            points.push((BinPoint::Hit { lane, later }, reason));
        }
        points.push((BinPoint::Emptied { lane }, None));
        for memory in 0..if plan.takes_turns() { 2 } else { 1 } {
            points.push((BinPoint::Top { lane, memory }, None));
        }
        if plan.saturates() {
            points.push((BinPoint::Full { lane }, None));
        }
    }
    for adder in 0..plan.adders() {
        points.extend((0..plan.bin_bits).map(|bit| (BinPoint::Carry { adder, bit }, None)));
        if plan.adder_samples > 2 {
            points.push((BinPoint::Extra { adder }, None));
        }
        if plan.saturates() {
            points.push((BinPoint::Clamped { adder }, None));
        }
    }
    let ages = if plan.saturates() { 0..CLOCKS_TO_FLAG - CLOCKS_TO_TURN } else { 0..0 };
    for memory in 0..if plan.takes_turns() { 2 } else { 1 } {
        let at_end = ages.clone().map(|age| (BinPoint::ClampedAtEnd { age, memory }, None));
        points.extend(at_end);
    }
    // Without a second sample a word after one with a hit has none.
    points.push((BinPoint::FullRow, None));
    points.extend([false, true].map(|first| (BinPoint::Border { first }, None)));
    points
}

impl PointFamily for BinPoint {
    fn text(&self) -> String {
        match *self {
            BinPoint::Hit { lane, later } => format!(
                "a hit of lane {lane} counted in {} code period of a frame",
                if later { "a later" } else { "the first" }
            ),
            BinPoint::Emptied { lane } => {
                format!("a bin of lane {lane} that is 0 in a memory where it was not")
            }
            BinPoint::Carry { adder, bit } => {
                format!("a count of adder {adder} that comes to 2^{bit}")
            }
            BinPoint::Top { lane, memory } => {
                format!("a bin of lane {lane} with its top bit set, read out of memory {memory}")
            }
            BinPoint::FullRow => "a word with a hit at each adder".to_owned(),
            BinPoint::Extra { adder } => format!("several hits at adder {adder} in a word"),
            BinPoint::Border { first } => {
                format!("a hit on the {} sample of a frame", if first { "first" } else { "last" })
            }
            BinPoint::Full { lane } => format!("a bin of lane {lane} at its limit"),
            BinPoint::Clamped { adder } => {
                format!("a bin of adder {adder} alone beyond its limit")
            }
            BinPoint::ClampedAtEnd { age, memory } => format!(
                "a bin alone beyond its limit {age} clocks before the last word of a frame in memory {memory}"
            ),
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let Some(plan) = maker.interface.histogram() else {
            return Ok(Vec::new());
        };
        let lane = |lane: u32| Hits::Lane { detector: maker.detector, lane: lane.into() };
        let of_adder = |adder| lane(adder * plan.adder_samples);
        let (fresh, plain) = (maker.fresh(), PlannedGroup::random);
        Ok(match *self {
            BinPoint::Hit { lane: l, .. } | BinPoint::Full { lane: l } => {
                vec![fresh.with(lane(l))]
            }
            // The frame after the next has the first one's memory, or the next.
            BinPoint::Emptied { lane: l } => {
                vec![fresh.with(lane(l)), plain().with(Hits::None), plain().with(Hits::None)]
            }
            // Each frame that is read has the other memory.
            BinPoint::Top { lane: l, memory } => {
                let behind = (0..memory).map(|_| plain().with(lane(l)));
                std::iter::once(fresh.with(lane(l))).chain(behind).collect()
            }
            BinPoint::Carry { adder, .. } => vec![fresh.with(of_adder(adder))],
            BinPoint::Clamped { adder } => {
                vec![fresh.with(Hits::None), plain().with(of_adder(adder))]
            }
            BinPoint::ClampedAtEnd { age, memory } => {
                let at_end = Hits::BeyondLimitAtEnd {
                    detector: maker.detector,
                    // Each has its turn.
                    lane: (age % plan.row_bins).into(),
                    age: age.into(),
                };
                // The first frame has memory 0.
                let dark = std::iter::once(fresh).chain((memory..1).map(|_| plain()));
                let dark = dark.map(|frame| frame.with(Hits::None));
                dark.chain([plain().with(at_end)]).collect()
            }
            BinPoint::FullRow | BinPoint::Extra { .. } => vec![fresh.with(Hits::EveryOther)],
            BinPoint::Border { first } => {
                vec![fresh.with(Hits::None), plain().with(Hits::Border { first })]
            }
        })
    }
}

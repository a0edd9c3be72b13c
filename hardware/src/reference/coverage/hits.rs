//! Cover points of single hits.

use super::signs::Signs;
use super::{Hindered, PointFamily, steps};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Lead, Length, PlannedGroup};
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;

const ONE_SIGN: &str = "no step has a chip of that sign for that lane";

const NO_FULL_WORD: &str = "no word lies within chips of that sign";

/// What a hit does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HitPoint {
    /// A result counts a hit of this lane, with this sign.
    Hit {
        /// Step of the group.
        step: usize,
        /// Sample of the word.
        lane: u32,
        /// Counted up.
        up: bool,
    },
    /// A word with as many hits as it can hold, all of one sign.
    FullWord {
        /// Counted up.
        up: bool,
    },
    /// A hit on the very first sample of a scan.
    FirstSample,
    /// A hit on the last sample before a scan, which does not count.
    BeforeScan,
    /// A hit on the last sample of a step, or on the first of one that follows another.
    StepBorder {
        /// The first sample, and not the last.
        first: bool,
    },
}

/// Those of a detector.
pub(super) fn points(interface: &Interface, detector: DetectorIndex) -> Vec<Hindered<HitPoint>> {
    let signs = Signs::of(interface, detector);
    let mut points = Vec::new();
    for step in steps(interface) {
        for lane in 0..interface.lanes() {
            let reached = signs.reached(interface, step, lane);
            for up in [false, true] {
                let point = HitPoint::Hit { step, lane, up };
                points.push((point, (!reached[usize::from(up)]).then_some(ONE_SIGN)));
            }
        }
    }
    if interface.correlator().is_some_and(|counts| counts.pairs > 1) {
        let filled = signs.fill_words(interface);
        let hindrance = |up| (!filled[usize::from(up)]).then_some(NO_FULL_WORD);
        points.extend([false, true].map(|up| (HitPoint::FullWord { up }, hindrance(up))));
    }
    points.push((HitPoint::FirstSample, None));
    points.push((HitPoint::BeforeScan, None));
    for first in [false, true] {
        let single = first && interface.groups() == 1;
        let hindrance = single.then_some("a scan has a single group of steps");
        points.push((HitPoint::StepBorder { first }, hindrance));
    }
    points
}

impl PointFamily for HitPoint {
    fn text(&self) -> String {
        let sign = |up| if up { "up" } else { "down" };
        match *self {
            HitPoint::Hit { step, lane, up } => {
                format!("a hit of lane {lane} counted {} in step {step} of a group", sign(up))
            }
            HitPoint::FullWord { up } => {
                format!("a word full of hits, all counted {}", sign(up))
            }
            HitPoint::FirstSample => "a hit on a scan's first sample".to_owned(),
            HitPoint::BeforeScan => "a hit on the last sample before a scan".to_owned(),
            HitPoint::StepBorder { first } => {
                format!("a hit on the {} sample of a step", if first { "first" } else { "last" })
            }
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let (interface, detector) = (maker.interface, maker.detector);
        let plain = PlannedGroup::random;
        // The sign that is wanted may come only later.
        let code = interface.reference_codes[detector].len();
        let groups = (code / interface.timing.scan.integration_chips).clamp(1, 40) + 1;
        Ok(match *self {
            HitPoint::Hit { step, lane, up } => {
                let one = Hits::One { detector, step: step as u64, lane: u64::from(lane), up };
                maker.again(groups, one, Length::AtLeast(code.min(512)))
            }
            HitPoint::FullWord { .. } => {
                maker.again(groups, Hits::EveryOther, Length::AtLeast(code.min(128)))
            }
            HitPoint::BeforeScan => {
                vec![PlannedGroup { lead: Lead::LastSample, ..maker.fresh() }]
            }
            HitPoint::FirstSample => {
                vec![maker.fresh().with(Hits::Border { first: true })]
            }
            HitPoint::StepBorder { first } => {
                vec![maker.fresh().with(Hits::None), plain().with(Hits::Border { first })]
            }
        })
    }
}

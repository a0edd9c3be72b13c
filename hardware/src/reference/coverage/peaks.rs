//! Cover points of a scan's largest count.

use super::{Hindered, PointFamily, steps};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Length, PlannedGroup};
use crate::sensor::interface::Interface;

/// A scan's largest count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PeakPoint {
    /// Below zero.
    Negative,
    /// Above zero.
    Positive,
    /// That of the first step.
    First,
    /// That of the last step.
    Last,
    /// There is an equal one behind it.
    Equal,
    /// That of this step of its group, with no equal one.
    Step(usize),
}

/// Those of a detector.
pub(super) fn points(interface: &Interface) -> Vec<Hindered<PeakPoint>> {
    let single = interface.timing.scan.steps == 1;
    let of_steps = steps(interface).filter(|_| interface.parallel() > 1).map(PeakPoint::Step);
    let points = of_steps.chain([
        PeakPoint::Negative,
        PeakPoint::Positive,
        PeakPoint::First,
        PeakPoint::Last,
        PeakPoint::Equal,
    ]);
    let hindrance = |point| match point {
        PeakPoint::First | PeakPoint::Equal if single => Some("a scan has a single step"),
        PeakPoint::First if interface.groups() == 1 => Some("a scan has a single group of steps"),
        _ => None,
    };
    points.map(|point| (point, hindrance(point))).collect()
}

impl PointFamily for PeakPoint {
    fn text(&self) -> String {
        let text = match *self {
            PeakPoint::Negative => "a scan's largest count below zero",
            PeakPoint::Positive => "a scan's largest count above zero",
            PeakPoint::First => "the peak in a scan's first group",
            PeakPoint::Last => "the peak in a scan's last group",
            PeakPoint::Equal => "the first of equal peaks",
            PeakPoint::Step(step) => return format!("the peak in step {step} of a group"),
        };
        text.to_owned()
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let side = |up| Hits::AllSteps { up };
        // Of the first group, of those between, and of the last one.
        let [first, middle, last] = match *self {
            PeakPoint::Step(step) => {
                let limit = 1i64 << (maker.interface.count_bits() - 1);
                let (detector, step, count) = (maker.detector, step as u64, 4.min(limit - 1));
                [Hits::Count { detector, step, count }, Hits::None, Hits::None]
            }
            PeakPoint::Negative => [side(false); 3],
            PeakPoint::Positive => [side(true); 3],
            PeakPoint::First => [Hits::OneSided { step: 0, up: true }, Hits::None, Hits::None],
            PeakPoint::Last => [Hits::None, Hits::None, Hits::OneSided { step: 0, up: true }],
            PeakPoint::Equal => [Hits::None; 3],
        };
        let long = Length::AtLeast(96);
        let begin = maker.fresh().with(first).long(long);
        let end = PlannedGroup::random().with(last).long(long);
        if matches!(self, PeakPoint::First) && maker.reach.leaves_out {
            // A group behind which others are left out is no longer the first.
            let left_out = maker.scan(PlannedGroup::random().with(middle), end)?;
            return Ok([vec![begin], left_out].concat());
        }
        let mut plans = maker.scan(begin, end)?;
        let between = plans.len().saturating_sub(2);
        plans.iter_mut().skip(1).take(between).for_each(|plan| plan.hits = middle);
        Ok(plans)
    }
}

//! Cover points of a scan's largest count.

use super::{Family, Hindered, steps};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Length, PlannedGroup};
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;

/// A scan's largest count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PeakPoint {
    /// Detector.
    pub detector: DetectorIndex,
    /// Which.
    pub kind: PeakKind,
}

/// A kind of a scan's largest count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PeakKind {
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
pub(super) fn points(interface: &Interface, detector: DetectorIndex) -> Vec<Hindered<PeakPoint>> {
    let single = interface.timing.scan.steps == 1;
    let of_steps = steps(interface).filter(|_| interface.parallel() > 1).map(PeakKind::Step);
    let kinds = of_steps.chain([
        PeakKind::Negative,
        PeakKind::Positive,
        PeakKind::First,
        PeakKind::Last,
        PeakKind::Equal,
    ]);
    let hindrance = |kind| match kind {
        PeakKind::First | PeakKind::Equal if single => Some("a scan has a single step"),
        PeakKind::First if interface.groups() == 1 => Some("a scan has a single group of steps"),
        _ => None,
    };
    kinds.map(|kind| (PeakPoint { detector, kind }, hindrance(kind))).collect()
}

impl Family for PeakPoint {
    fn detector(&self) -> Option<DetectorIndex> {
        Some(self.detector)
    }

    fn text(&self) -> String {
        let text = match self.kind {
            PeakKind::Negative => "a scan's largest count below zero",
            PeakKind::Positive => "a scan's largest count above zero",
            PeakKind::First => "the peak in a scan's first group",
            PeakKind::Last => "the peak in a scan's last group",
            PeakKind::Equal => "the first of equal peaks",
            PeakKind::Step(step) => return format!("the peak in step {step} of a group"),
        };
        text.to_owned()
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let side = |up| Hits::AllSteps { up };
        // Of the first group, of those between, and of the last one.
        let [first, middle, last] = match self.kind {
            PeakKind::Step(step) => {
                let limit = 1i64 << (maker.interface.count_bits() - 1);
                let (detector, step, count) = (self.detector, step as u64, 4.min(limit - 1));
                [Hits::Count { detector, step, count }, Hits::None, Hits::None]
            }
            PeakKind::Negative => [side(false); 3],
            PeakKind::Positive => [side(true); 3],
            PeakKind::First => [side(true), side(false), side(false)],
            PeakKind::Last => [side(false), side(false), side(true)],
            PeakKind::Equal => [Hits::None; 3],
        };
        let long = Length::AtLeast(96);
        let begin = maker.fresh().with(first).long(long);
        let mut plans = maker.scan(begin, PlannedGroup::random().with(last).long(long))?;
        let between = plans.len().saturating_sub(2);
        plans.iter_mut().skip(1).take(between).for_each(|plan| plan.hits = middle);
        Ok(plans)
    }
}

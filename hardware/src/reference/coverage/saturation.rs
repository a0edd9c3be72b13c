//! Cover points of counts at their limits.

use super::signs::Signs;
use super::{Hindered, PointFamily, steps};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, PlannedGroup};
use crate::scene::DetectorIndex;
use crate::sensor::interface::{Correlator, Interface};
use crate::sensor::layout::mask;

const FEW_CHIPS: &str = "a step has too few chips of that sign for so many hits";

/// A count, or a total, at its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SaturationPoint {
    /// A count exactly at the end of its range, which is not saturated.
    Limit {
        /// Step of the group.
        step: usize,
        /// The largest count, and not the smallest.
        up: bool,
    },
    /// This count is saturated, alone, and `o_saturated` rises for it.
    Beyond {
        /// Step of the group.
        step: usize,
        /// Beyond the largest count.
        up: bool,
    },
    /// The same in a scan's last group.
    InLastGroup {
        /// Step of the group.
        step: usize,
        /// Beyond the largest count.
        up: bool,
    },
    /// A step that a scan's last group does not have would be saturated, alone: the flag
    /// stays low.
    Absent {
        /// Step of the group.
        step: usize,
        /// Beyond the largest count.
        up: bool,
    },
    /// A total of hits at its limit, or beyond it with no count saturated.
    OfTotal {
        /// Beyond, and not at it.
        beyond: bool,
    },
}

/// Those of a detector.
pub(super) fn points(
    interface: &Interface,
    detector: DetectorIndex,
    correlator: &Correlator,
) -> Vec<Hindered<SaturationPoint>> {
    let mut points = Vec::new();
    if correlator.total.is_some_and(|total| total.saturates()) {
        points.extend([false, true].map(|beyond| SaturationPoint::OfTotal { beyond }));
    }
    let sides = if correlator.saturates() { &[false, true][..] } else { &[] };
    for &up in sides {
        for step in steps(interface) {
            points.push(SaturationPoint::Limit { step, up });
            points.push(SaturationPoint::Beyond { step, up });
        }
        let last_steps = interface.last_group_steps() as usize;
        let of_last = (0..last_steps).filter(|_| interface.groups() > 1);
        points.extend(of_last.map(|step| SaturationPoint::InLastGroup { step, up }));
        let absent = last_steps..interface.parallel() as usize;
        points.extend(absent.map(|step| SaturationPoint::Absent { step, up }));
    }
    let signs = Signs::of(interface, detector);
    let counted = if sides.is_empty() { 0..0 } else { steps(interface) };
    let most: Vec<_> = counted.map(|step| signs.most_hits(interface, step)).collect();
    let limit = 1u64 << (correlator.count_bits - 1);
    let hindrance = |point| {
        let (step, up, needed) = match point {
            SaturationPoint::Limit { step, up } => (step, up, limit - u64::from(up)),
            SaturationPoint::Beyond { step, up } | SaturationPoint::InLastGroup { step, up } => {
                (step, up, limit + 1 - u64::from(up))
            }
            SaturationPoint::Absent { .. } | SaturationPoint::OfTotal { .. } => return None,
        };
        (most[step][usize::from(up)] < needed).then_some(FEW_CHIPS)
    };
    points.into_iter().map(|point| (point, hindrance(point))).collect()
}

/// Why nothing is seen beyond the largest count in a group's first step, if nothing is.
pub(super) fn hindrance(interface: &Interface) -> Option<&'static str> {
    let limit = 1u64 << (interface.correlator()?.count_bits - 1);
    let [_, most] = Signs::of(interface, DetectorIndex(0)).most_hits(interface, 0);
    (most < limit).then_some(FEW_CHIPS)
}

impl PointFamily for SaturationPoint {
    fn text(&self) -> String {
        let extreme = |up| if up { "largest" } else { "smallest" };
        match *self {
            SaturationPoint::Limit { step, up } => {
                format!("the {} count, not saturated, in step {step} of a group", extreme(up))
            }
            SaturationPoint::Beyond { step, up } => {
                format!("step {step} of a group alone saturated at the {} count", extreme(up))
            }
            SaturationPoint::InLastGroup { step, up } => format!(
                "step {step} of a scan's last group alone saturated at the {} count",
                extreme(up)
            ),
            SaturationPoint::Absent { step, up } => format!(
                "step {step}, which a scan's last group has not, alone beyond the {} count",
                extreme(up)
            ),
            SaturationPoint::OfTotal { beyond } => format!(
                "a total of hits {} its limit, no count saturated",
                if beyond { "beyond" } else { "at" }
            ),
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let (interface, detector) = (maker.interface, maker.detector);
        let limit = 1i64 << (interface.count_bits() - 1);
        let count = |step: usize, up: bool, beyond: i64| Hits::Count {
            detector,
            step: step as u64,
            count: if up { limit - 1 + beyond } else { -limit - beyond },
        };
        let hits = match *self {
            SaturationPoint::Limit { step, up } => count(step, up, 0),
            SaturationPoint::Beyond { step, up } => count(step, up, 1),
            SaturationPoint::InLastGroup { step, up } | SaturationPoint::Absent { step, up } => {
                let quiet = maker.fresh().with(Hits::None);
                let last = PlannedGroup::random().with(count(step, up, 1));
                return maker.scan(quiet, last);
            }
            SaturationPoint::OfTotal { beyond } => {
                let most = interface.total().map_or(0, |total| mask(total.bits));
                Hits::Total { detector, hits: most + u64::from(beyond) }
            }
        };
        // The first group of a scan, or a later one: their signs differ.
        let age = u64::from(interface.result_latency_clocks) + maker.beats() + 2;
        let later = PlannedGroup::random().with(hits);
        Ok(vec![maker.fresh().with(hits), later.clone().after_reset(age, 2), later])
    }
}

//! Cover points of steps, scans and codes.

use super::{Hindered, PointFamily};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Length, PlannedGroup};
use crate::scene::SourceIndex;
use crate::sensor::interface::Interface;

/// Where a scan, or a code, comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ScanPoint {
    /// A result of the first scan after a reset, or of a later one.
    Result {
        /// Which step.
        place: GroupPosition,
        /// A scan that follows another.
        later_scan: bool,
    },
    /// A step of the full number of chips.
    WholeStep,
    /// A scan's end after every one of its steps, not one of them left out.
    WholeScan,
    /// The delay grows past a whole chip, or past the code period.
    DelayWraps {
        /// The code period.
        period: bool,
    },
    /// A source's code begins anew.
    CodeWraps {
        /// The source.
        source: SourceIndex,
    },
}

/// Where a group of steps is in its scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GroupPosition {
    /// The first group of steps.
    First,
    /// Neither.
    Middle,
    /// The last.
    Last,
}

impl GroupPosition {
    /// Of a group among so many.
    pub fn of(group: u64, groups: u64) -> GroupPosition {
        match group {
            _ if group + 1 == groups => GroupPosition::Last,
            0 => GroupPosition::First,
            _ => GroupPosition::Middle,
        }
    }

    pub(super) fn text(self) -> &'static str {
        match self {
            GroupPosition::First => "first",
            GroupPosition::Middle => "middle",
            GroupPosition::Last => "last",
        }
    }
}

/// The places that a scan of so many groups has.
pub(super) fn places(groups: u64) -> impl Iterator<Item = GroupPosition> {
    [(GroupPosition::First, 2), (GroupPosition::Middle, 3), (GroupPosition::Last, 1)]
        .into_iter()
        .filter_map(move |(place, least)| (groups >= least).then_some(place))
}

/// Results, in scans of all kinds.
pub(super) fn results(interface: &Interface) -> Vec<Hindered<ScanPoint>> {
    let groups = interface.groups();
    let of_scan =
        |later_scan| places(groups).map(move |place| ScanPoint::Result { place, later_scan });
    [false, true].into_iter().flat_map(of_scan).map(|point| (point, None)).collect()
}

/// Steps and scans, of counts.
pub(super) fn delays(interface: &Interface) -> Vec<Hindered<ScanPoint>> {
    let scan = &interface.timing.scan;
    let grows = (interface.groups() - 1) * u64::from(interface.parallel());
    let lanes = u64::from(interface.lanes());
    let past_chip = scan.first_step % lanes + grows >= lanes;
    let past_period = !interface.realigns() || scan.first_step + grows >= scan.steps_per_period;
    let hindrance = |reached: bool, reason| (!reached).then_some(reason);
    vec![
        (
            ScanPoint::DelayWraps { period: false },
            hindrance(past_chip, "a scan's steps lie within a chip"),
        ),
        (
            ScanPoint::DelayWraps { period: true },
            hindrance(past_period, "a scan's steps do not reach the code's end"),
        ),
        (ScanPoint::WholeStep, None),
        (ScanPoint::WholeScan, None),
    ]
}

/// The sources' codes.
pub(super) fn codes(interface: &Interface) -> Vec<Hindered<ScanPoint>> {
    let sources = SourceIndex::of(&interface.source_codes);
    sources.map(|source| (ScanPoint::CodeWraps { source }, None)).collect()
}

impl PointFamily for ScanPoint {
    fn text(&self) -> String {
        match *self {
            ScanPoint::Result { place, later_scan } => {
                let scan = if later_scan { "a scan behind another" } else { "the first scan" };
                format!("a result of the {} group of {scan}", place.text())
            }
            ScanPoint::WholeStep => "a step of its whole length".to_owned(),
            ScanPoint::WholeScan => "a scan with all its steps".to_owned(),
            ScanPoint::DelayWraps { period } => format!(
                "the delay grows past a whole {}",
                if period { "code period" } else { "chip" }
            ),
            ScanPoint::CodeWraps { source } => format!("the code of source {source} begins anew"),
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let plain = PlannedGroup::random;
        let interface = maker.interface;
        let groups = interface.groups();
        match *self {
            ScanPoint::Result { .. } if maker.reach.leaves_out => {
                let mut plans = Vec::new();
                for first in [maker.fresh(), plain()] {
                    plans.push(first);
                    plans.extend(maker.scan(plain(), plain())?);
                }
                Ok(plans)
            }
            ScanPoint::Result { .. } => walk(maker, 2 * groups + 1),
            ScanPoint::WholeStep => Ok(vec![maker.fresh().long(Length::Whole)]),
            ScanPoint::WholeScan => walk(maker, groups),
            ScanPoint::DelayWraps { period: true } => walk(maker, groups.saturating_add(2)),
            ScanPoint::DelayWraps { period: false } => {
                walk(maker, u64::from(interface.lanes().div_ceil(interface.parallel())) + 2)
            }
            ScanPoint::CodeWraps { source } => {
                let code = interface.source_codes[source].len();
                walk(maker, (code + 2).div_ceil(maker.reach.shortest))
            }
        }
    }
}

/// So many groups, one after another.
fn walk(maker: &GroupMaker, groups: u64) -> Result<Vec<PlannedGroup>, String> {
    let clocks = groups.saturating_mul(maker.reach.shortest);
    if clocks > maker.reach.most_clocks {
        return Err(format!("it takes {clocks} clocks"));
    }
    let mut plans = vec![maker.fresh()];
    plans.extend((1..groups).map(|_| PlannedGroup::random()));
    // A step without a hit shows nothing.
    let last = plans.len().saturating_sub(3);
    let side = Hits::OneSided { step: 0, up: true };
    plans[last..].iter_mut().for_each(|plan| plan.hits = side);
    Ok(plans)
}

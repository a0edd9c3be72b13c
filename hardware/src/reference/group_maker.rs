//! What the ways to cover points are made from: groups of phase steps, and whole scans.

use super::planned::{Hits, Length, PlannedGroup, Shortening};
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;

/// Makes groups for a sensor.
pub(super) struct GroupMaker<'a> {
    pub(super) interface: &'a Interface,
    pub(super) reach: &'a Shortening,
    /// The detector that they are for, if they are for one.
    pub(super) detector: DetectorIndex,
}

impl GroupMaker<'_> {
    pub(super) fn fresh(&self) -> PlannedGroup {
        PlannedGroup::fresh(self.interface)
    }

    /// Beats of a group.
    pub(super) fn beats(&self) -> u64 {
        self.interface.beats_of_group()
    }

    pub(super) fn chips_of(&self, plan: &PlannedGroup) -> u64 {
        let most = self.interface.timing.scan.integration_chips;
        match plan.length {
            _ if plan.cut.is_some_and(|chips| chips < most) => plan.cut.unwrap_or(most),
            Length::Short => self.reach.shortest,
            Length::AtLeast(chips) => self.reach.chips_of_at_least(self.interface, chips),
            Length::Whole => most,
            Length::Exactly(chips) => chips,
        }
    }

    /// Groups up to the scan's last but one, after the `first` one of a scan; the last
    /// one follows.
    pub(super) fn to_the_end(&self, first: PlannedGroup) -> Result<Vec<PlannedGroup>, String> {
        let groups = self.interface.groups();
        if self.reach.leaves_out {
            return Ok(vec![first.then_the_last()]);
        }
        let clocks = self.reach.scan_clocks(self.interface);
        if clocks > self.reach.most_clocks {
            return Err(format!("a scan takes {clocks} clocks"));
        }
        let filler = PlannedGroup { reset: None, ..first.clone() };
        let mut plans = vec![first; usize::from(groups > 1)];
        plans.extend((2..groups).map(|_| filler.clone()));
        Ok(plans)
    }

    /// A whole scan; `last` is its last group.
    pub(super) fn scan(
        &self,
        first: PlannedGroup,
        last: PlannedGroup,
    ) -> Result<Vec<PlannedGroup>, String> {
        let reset = first.reset;
        let mut plans = self.to_the_end(first)?;
        let is_alone = plans.is_empty();
        plans.push(last);
        if is_alone {
            plans[0].reset = reset;
        }
        Ok(plans)
    }

    /// The same hits in a fresh group and in so many after it.
    pub(super) fn again(&self, groups: u64, hits: Hits, length: Length) -> Vec<PlannedGroup> {
        let mut plans = vec![self.fresh().with(hits).long(length)];
        plans.extend((0..groups).map(|_| PlannedGroup::random().with(hits).long(length)));
        plans
    }

    /// Some groups for a row, and for each behind it as far as one recipe may go.
    pub(super) fn row_by_row(
        &self,
        rows: Vec<usize>,
        first: usize,
        of_row: impl Fn(u64) -> Vec<PlannedGroup>,
    ) -> Vec<PlannedGroup> {
        let flush = self.reach.groups_to_flush(self.interface) * self.reach.shortest;
        let mut plans = vec![self.fresh().with(Hits::EveryOther)];
        let mut clocks = self.chips_of(&plans[0]) + flush;
        for row in rows.into_iter().skip_while(|&row| row < first) {
            let more = of_row(row as u64);
            clocks += more.iter().map(|plan| self.chips_of(plan)).sum::<u64>();
            if plans.len() > 1 && clocks > self.reach.most_clocks {
                break;
            }
            plans.extend(more);
        }
        plans
    }

    /// A frame that is cut short after so many clocks, or else the clocks behind it that are left.
    pub(super) fn cut_at(&self, clocks: u64) -> (PlannedGroup, u64) {
        let chips = clocks.min(self.interface.timing.scan.integration_chips);
        (PlannedGroup::random().cut_after(chips), clocks - chips)
    }
}

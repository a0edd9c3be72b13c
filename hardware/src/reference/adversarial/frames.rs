//! The way to cover points of a histogram's rows.

use super::plan::{GroupPlan, Hits, Receiver};
use super::recipes::Kitchen;
use crate::reference::coverage::{CoverPoint, rows_at_borders, rows_that_may_be_lost};
use crate::sensor::histogram::HistogramPlan;

impl Kitchen<'_> {
    /// What frames, their rows and resets between these need.
    pub(super) fn frames(&self, point: CoverPoint) -> Result<Vec<GroupPlan>, String> {
        let Some(plan) = self.interface.histogram() else {
            return Ok(Vec::new());
        };
        Ok(match point {
            // On the way the rows behind it are held, too, or every other one.
            CoverPoint::Held { beat } => {
                let holds = Receiver::HoldsEach { beat: beat as u64 };
                vec![self.fresh(), GroupPlan::random().received(holds)]
            }
            CoverPoint::FirstLost { beat } => {
                let rows = rows_that_may_be_lost(self.interface, plan);
                self.row_by_row(rows, beat, |row| self.first_loss(plan, row))
            }
            CoverPoint::ResetAtRow { beat } => {
                let rows = rows_at_borders(self.interface, plan);
                self.row_by_row(rows, beat, |row| self.reset_at(row))
            }
            CoverPoint::Reset { .. } | CoverPoint::ResetAge { .. } => self.resets(point)?,
            CoverPoint::ResetHit { .. } => self.resets(point)?,
            _ => self.stream(point)?,
        })
    }

    /// Some groups for a row, and for each behind it as far as one recipe may go.
    fn row_by_row(
        &self,
        rows: Vec<usize>,
        first: usize,
        of_row: impl Fn(u64) -> Vec<GroupPlan>,
    ) -> Vec<GroupPlan> {
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

    /// A frame is there to be read: from the second on it is lost, or a row of it, and a reset
    /// ends what was lost.
    fn first_loss(&self, plan: &HistogramPlan, row: u64) -> Vec<GroupPlan> {
        let latency = u64::from(self.interface.result_latency_clocks);
        let plain = GroupPlan::random;
        let before = match plan.takes_turns() {
            // A frame that ends is lost.
            true => Some(row),
            // The frame's first row is, while the last one of the frame before stands.
            false if row == 0 => Some(self.beats() - 1),
            false => None,
        };
        let (mut plans, age) = match before {
            Some(beat) => {
                let holds = Receiver::StopsAt { beat, clocks: latency + 2 };
                let (cut, age) = self.cut_at(latency + 2);
                (vec![plain().received(holds), cut], age)
            }
            None => {
                let (cut, age) = self.cut_at(latency + row + 2);
                let holds = Receiver::StopsAt { beat: row - 1, clocks: age + 2 };
                (vec![cut.received(holds)], age)
            }
        };
        plans.push(plain().after_reset(age, 1));
        plans
    }

    /// A reset while a row stands, and a frame behind it that is read.
    fn reset_at(&self, row: u64) -> Vec<GroupPlan> {
        let latency = u64::from(self.interface.result_latency_clocks);
        let (cut, age) = self.cut_at(latency + row);
        let after = GroupPlan::random().with(Hits::EveryOther).after_reset(age, 1);
        vec![cut, after, GroupPlan::random()]
    }

    /// A frame that is cut short after so many clocks, or else the clocks behind it that are left.
    fn cut_at(&self, clocks: u64) -> (GroupPlan, u64) {
        let chips = clocks.min(self.interface.timing.scan.integration_chips);
        (GroupPlan::random().cut_after(chips), clocks - chips)
    }
}

//! Counts as an AXI4-Stream.
//!
//! | port | |
//! |---|---|
//! | `i_count`, `i_total`, `i_clamped` | counts of a group, detector by detector |
//! | `i_pre_counted`, `i_counted`, `i_last` | new in the next clock; new; the scan's last |
//! | `o_data`, `o_valid`, `i_ready`, `o_last` | the stream, a count a beat |
//! | `o_overrun`, `o_saturated` | a result was lost, or clamped, since reset |
//!
//! Latency 1 clock from `i_counted` to `o_valid`. One register for each count of a group, and the
//! shift between them.
//!
//! Cost (ECP5, docs/resources.md): 3 LUTs, 20 flip-flops; without back-pressure 3 and 1 fewer.

mod plan;

pub use self::plan::StreamPlan;
pub(super) use self::plan::counts_about;
use self::plan::{data_about, describe, total_about};
use super::first_of;
use crate::rtl::front::prelude::*;

/// Offers the counts of a group of phase steps as a stream, one per beat:
/// the first detector's steps, then the next detector's.
#[block(describe(&plan))]
pub struct ResultStream {
    plan: StreamPlan,
    /// Counts, detector by detector.
    #[each(count in 0..plan.counts())]
    #[about(first_of(count, counts_about(plan.detectors, plan.steps)))]
    #[width(plan.count_bits)]
    pub i_count: Vec<Input<Word>>,
    /// Total count of each detector, if they are sent.
    #[each(detector in 0..plan.totals())]
    #[about(first_of(detector, total_about(plan.detectors)))]
    #[width(plan.total_bits())]
    pub i_total: Vec<Input<Word>>,
    /// Which of them were clamped.
    #[each(count in 0..plan.clamped())]
    #[about(first_of(count, "count 0 was clamped, and so on"))]
    pub i_clamped: Vec<Input<bool>>,
    /// new counts are there in the next clock
    #[when(plan.queues())]
    pub i_pre_counted: Optional<Input<bool>>,
    /// new counts are there
    pub i_counted: Input<bool>,
    /// they are the scan's last
    pub i_last: Input<bool>,
    /// the receiver takes the result
    pub i_ready: Input<bool>,
    /// The count, sign-extended, and above it the total, zero-extended.
    #[about(data_about(plan.total))]
    #[width(plan.data_bits)]
    pub o_data: Output<Word>,
    /// a result waits
    pub o_valid: Output<bool>,
    /// the result is the scan's last
    pub o_last: Output<bool>,
    /// a result was lost since reset
    pub o_overrun: Output<bool>,
    /// a count was clamped since reset
    #[when(plan.saturates)]
    pub o_saturated: Optional<Output<bool>>,
    #[each(count in 0..plan.counts())]
    #[about(match plan.counts() {
        1 => "the result",
        _ => first_of(count, "the result, and above it those that come next"),
    })]
    #[width(plan.count_bits)]
    count: Vec<Register<Word>>,
    /// the result's total count
    #[when(plan.total.is_some())]
    #[width(plan.total_bits())]
    total: Optional<Register<Word>>,
    #[each(detector in 1..=plan.further())]
    #[about(first_of(detector - 1, "total counts of the detectors from 1 on"))]
    #[width(plan.total_bits())]
    waiting_total: Vec<Register<Word>>,
    #[each(place in 0..plan.marked())]
    #[about(first_of(place, "detectors of those that come next, one-hot from 1"))]
    #[width(plan.further())]
    detector: Vec<Register<Word>>,
    valid: Register<bool>,
    /// the waiting results are the scan's last
    last: Register<bool>,
    overrun: Register<bool>,
    /// the result is its group's last
    #[when(plan.queues())]
    ends: Optional<Register<bool>>,
    #[each(count in 0..plan.queued())]
    #[about(first_of(count, "the next one is its group's last; then those behind it"))]
    next_ends: Vec<Register<bool>>,
    /// the results behind the first have yet to move up
    #[when(plan.is_deep())]
    moves_up: Optional<Register<bool>>,
    /// others of its group come after the result that waits
    #[when(plan.queues())]
    more: Optional<Register<bool>>,
    /// the results behind the first move up, or new ones come
    #[when(plan.queues())]
    changes: Optional<Register<bool>>,
    #[when(plan.saturates)]
    saturated: Optional<Register<bool>>,
    #[when(plan.saturates)]
    #[width(plan.counts())]
    clamped: Optional<Local<Word>>,
    /// those among them that a scan's last group has
    #[when(plan.saturates && plan.is_short())]
    #[width(plan.counts_of_last_group())]
    clamped_last: Optional<Local<Word>>,
    /// the result after the one that comes next is the group's last
    #[when(plan.queues())]
    later_ends: Optional<Local<bool>>,
    /// the result that comes next
    #[when(plan.queues())]
    #[width(plan.count_bits)]
    next: Optional<Local<Word>>,
    /// its detector, one-hot from 1
    #[when(plan.further() > 0)]
    #[width(plan.further().max(1))]
    next_detector: Optional<Local<Word>>,
    /// the count, signed, in whole bytes
    #[when(plan.total.is_some())]
    #[width(plan.signed_bits())]
    signed_count: Optional<Local<Word>>,
    blocked: Local<bool>,
    load: Local<bool>,
}

#[kernel]
impl Logic for ResultStream {
    fn update(&mut self) {
        self.o_valid.next = self.valid.q.val();
        self.o_overrun.next = self.overrun.q.val();
        if self.plan.queues() {
            self.queue();
        } else {
            self.o_last.next = self.last.q.val();
            self.blocked.next = self.valid.q.val() & !self.i_ready.val();
            self.load.next = self.i_counted.val() & !self.blocked.val();
        }
        if self.load.val() {
            if !self.plan.queues() {
                self.count[0].d.next = self.i_count[0].val();
                if self.total.is_present() {
                    self.total.d.next = self.i_total[0].val();
                }
            }
            self.last.d.next = self.i_last.val();
        }
        if self.o_saturated.is_present() {
            self.flag_clamped();
        }
        self.valid.d.next = self.i_counted.val() | self.blocked.val();
        if self.i_counted.val() & self.blocked.val() {
            self.overrun.d.next = true;
        }
        self.offer();
    }

    /// Several counts: the first is offered, the others wait behind it.
    fn queue(&mut self) {
        self.o_last.next = self.last.q.val() & self.ends.q.val();
        self.blocked.next = self.more.q.val() | (self.valid.q.val() & !self.i_ready.val());
        self.load.next = self.i_counted.val() & !self.blocked.val();
        if self.plan.is_short_at_once() {
            self.more.d.next = self.load.val() & !self.i_last.val();
        } else {
            self.more.d.next = self.load.val();
        }
        if self.plan.back_to_back {
            self.changes.d.next = self.i_pre_counted.val() & !self.load.val();
        } else {
            self.changes.d.next = self.i_pre_counted.val();
        }
        if self.more.q.val() {
            self.more.d.next = !(self.i_ready.val() & self.next_ends[0].q.val());
            self.changes.d.next = self.i_ready.val();
        }
        self.find_next();
        if self.i_ready.val() | !self.valid.q.val() {
            self.fill_first();
        }
        if self.changes.q.val() {
            self.fill_behind();
        }
    }

    /// What comes next: the second result, or the third if they have yet to move up.
    fn find_next(&mut self) {
        if self.moves_up.is_present() {
            self.moves_up.d.next = self.more.q.val() & self.i_ready.val();
            if self.moves_up.q.val() {
                self.next.next = self.count[2].q.val();
                self.later_ends.next = self.next_ends[2].q.val();
                if self.next_detector.is_present() {
                    self.next_detector.next = self.detector[1].q.val();
                }
            } else {
                self.next.next = self.count[1].q.val();
                self.later_ends.next = self.next_ends[1].q.val();
                if self.next_detector.is_present() {
                    self.next_detector.next = self.detector[0].q.val();
                }
            }
        } else {
            self.next.next = self.count[1].q.val();
            self.later_ends.next = self.next_ends[1].q.val();
            if self.next_detector.is_present() {
                self.next_detector.next = self.detector[0].q.val();
            }
        }
    }

    /// The result that is offered, when it is taken or there is none.
    fn fill_first(&mut self) {
        if self.more.q.val() {
            self.count[0].d.next = self.next.val();
            self.ends.d.next = self.next_ends[0].q.val();
            self.next_ends[0].d.next = self.later_ends.val();
            for d in 0..self.plan.further() {
                if self.next_detector.val().get_bit(d) {
                    self.total.d.next = self.waiting_total[d].q.val();
                }
            }
        } else if self.i_counted.val() {
            self.count[0].d.next = self.i_count[0].val();
            if self.total.is_present() {
                self.total.d.next = self.i_total[0].val();
            }
            if self.plan.is_short_at_once() {
                self.ends.d.next = self.i_last.val();
            } else {
                self.ends.d.next = false;
            }
            if self.plan.is_deep() && self.plan.short_end() > 0 {
                self.next_ends[0].d.next = false;
            } else if self.plan.is_deep() {
                self.next_ends[0].d.next = self.i_last.val();
            } else if self.plan.is_short() {
                self.next_ends[0].d.next = !self.i_last.val();
            } else {
                self.next_ends[0].d.next = true;
            }
        }
    }

    /// The results behind it: those that move up, or a new group.
    fn fill_behind(&mut self) {
        if self.plan.is_deep() {
            if self.more.q.val() {
                self.move_up();
            } else {
                self.take_group();
            }
        } else {
            self.take_group();
        }
    }

    fn take_group(&mut self) {
        for c in 1..self.count.len() {
            self.count[c].d.next = self.i_count[c].val();
        }
        for d in 0..self.plan.further() {
            self.waiting_total[d].d.next = self.i_total[d + 1].val();
        }
        if self.next_detector.is_present() {
            self.mark();
        }
        for c in 1..self.next_ends.len() {
            self.next_ends[c].d.next = false;
        }
        let whole = self.plan.whole_end();
        let short = self.plan.short_end();
        if self.plan.is_deep() && self.plan.is_short() {
            self.next_ends[whole].d.next = !self.i_last.val();
        } else if self.plan.is_deep() {
            self.next_ends[whole].d.next = true;
        }
        if short > 0 && short < whole {
            self.next_ends[short].d.next = self.i_last.val();
        }
        if self.plan.compacts() {
            self.compact();
        }
    }

    /// Marks the results behind the first with their detectors.
    fn mark(&mut self) {
        let steps = self.plan.steps;
        let further = self.plan.further();
        for step in 1..steps {
            self.detector[step - 1].d.next = bit_cast(false, further);
        }
        for d in 1..(further + 1) {
            for step in 0..steps {
                self.detector[steps * d + step - 1].d.next =
                    bit_cast(false, further).replace_bit(d - 1, true);
            }
        }
    }

    /// A scan's last group, whose surplus counts are left out.
    fn compact(&mut self) {
        let steps = self.plan.steps;
        let last_steps = self.plan.last_steps;
        let further = self.plan.further();
        if self.i_last.val() {
            for d in 1..self.plan.detectors {
                for step in 0..last_steps {
                    self.count[last_steps * d + step].d.next = self.i_count[steps * d + step].val();
                    if self.next_detector.is_present() {
                        self.detector[last_steps * d + step - 1].d.next =
                            bit_cast(false, further).replace_bit(d - 1, true);
                    }
                }
            }
        }
    }

    /// What comes in behind the last makes no difference.
    fn move_up(&mut self) {
        let last = self.plan.counts().saturating_sub(1);
        for c in 1..last {
            self.count[c].d.next = self.count[c + 1].q.val();
            self.next_ends[c].d.next = self.next_ends[c + 1].q.val();
        }
        self.count[last].d.next = self.i_count[last].val();
        self.next_ends[last].d.next = false;
        for c in 1..self.detector.len() {
            self.detector[c - 1].d.next = self.detector[c].q.val();
        }
        if self.next_detector.is_present() {
            let further = self.plan.further();
            self.detector[last.saturating_sub(1)].d.next =
                bit_cast(false, further).replace_bit(further.saturating_sub(1), true);
        }
    }

    fn flag_clamped(&mut self) {
        self.clamped.next = gather(self.count.len(), |c| self.i_clamped[c].val());
        if self.clamped_last.is_present() {
            let (steps, last_steps) = (self.plan.steps, self.plan.last_steps);
            self.clamped_last.next = gather(self.plan.counts_of_last_group(), |c| {
                self.i_clamped[c / last_steps * steps + c % last_steps].val()
            });
            if self.i_counted.val()
                & ((!self.i_last.val() & self.clamped.val().any()) | self.clamped_last.val().any())
            {
                self.saturated.d.next = true;
            }
        } else if self.i_counted.val() & self.clamped.val().any() {
            self.saturated.d.next = true;
        }
        self.o_saturated.next = self.saturated.q.val();
    }

    /// The word of the stream.
    fn offer(&mut self) {
        let bits = self.plan.data_bits();
        let below = self.plan.signed_bits();
        if self.total.is_present() {
            self.signed_count.next = bit_cast(signed_cast(self.count[0].q.val()), below);
            self.o_data.next = bit_cast(self.signed_count.val(), bits)
                | (bit_cast(self.total.q.val(), bits) << below);
        } else {
            self.o_data.next = bit_cast(signed_cast(self.count[0].q.val()), bits);
        }
    }
}

//! Counts as an AXI4-Stream: one register for each count of a group, and the shift between them.
//!
//! Cost (ECP5, docs/resources.md): 3 LUTs, 20 flip-flops; without back-pressure 3 and 1 fewer.

use crate::rtl::front::prelude::*;
use crate::sensor::interface::TotalCount;

/// The groups of counts that come.
#[derive(Debug, Clone, Copy)]
pub struct Groups {
    /// Detectors, whose counts come together.
    pub detectors: usize,
    /// Phase steps at once.
    pub steps: usize,
    /// Phase steps of a scan's last group.
    pub last_steps: usize,
    /// Whether groups may come in successive clocks.
    pub back_to_back: bool,
}

#[block(result_stream)]
/// counts of the phase steps as AXI4-Stream
///
/// The sensor cannot stall: results that come while others still wait are lost, and o_overrun stays high
/// until reset.
#[when(queues)]
/// A group's {counts} counts leave in the order of detectors, each detector's in the order of steps.
#[when(queues)]
/// The first register is offered. Those behind it move up a clock later, so that i_ready reaches few gates;
/// until they have, what comes next is the third's.
#[when(has_totals)]
/// A detector's steps have seen the same light: their total count is kept once, and goes out with each of
/// them.
#[when(is_short)]
/// A scan's last group has {last_steps} steps; the surplus counts are not sent.
#[when(saturates)]
/// o_saturated stays high until reset.
///
/// - Latency: 1 clock from i_counted to o_valid
pub struct ResultStream {
    /// Bits of the counts.
    count_bits: u32,
    /// Counts may have been clamped.
    saturates: bool,
    /// The totals, if they are sent.
    total_sent: Option<TotalCount>,
    groups: Groups,
    /// Whether each loss, and each clamp, is told besides.
    tells: bool,
    #[set(groups.detectors)]
    detectors: usize,
    /// Phase steps at once.
    #[set(groups.steps)]
    steps: usize,
    /// Phase steps of a scan's last group.
    #[set(groups.last_steps)]
    last_steps: usize,
    /// Groups may come in successive clocks.
    #[set(groups.back_to_back)]
    back_to_back: bool,
    #[set(detectors * steps)]
    counts: usize,
    /// Whether counts wait behind the first.
    #[set(counts > 1)]
    queues: bool,
    /// Whether more than one waits behind the first.
    #[set(counts > 2)]
    is_deep: bool,
    #[set(total_sent.is_some())]
    has_totals: bool,
    #[set(total_sent.map_or(1, |total| total.bits))]
    total_bits: u32,
    /// Bits below the total.
    #[set(total_sent.map_or(0, |total| total.first_bit as usize))]
    signed_bits: usize,
    /// Bits of the stream's words, whole bytes of count and total.
    #[set(match total_sent {
        None => count_bits,
        Some(total) => total.first_bit + total.bits,
    }.next_multiple_of(8) as usize)]
    data_bits: usize,
    /// Detectors whose totals wait for their results' turn.
    #[set(if has_totals { detectors - 1 } else { 0 })]
    further: usize,
    /// Whether a scan's last group has fewer steps.
    #[set(last_steps < steps)]
    is_short: bool,
    /// Whether a scan's last group is a single count.
    #[set(is_short && detectors * last_steps == 1)]
    is_short_at_once: bool,
    /// Counts of a scan's last group.
    #[set(detectors * last_steps)]
    last_counts: usize,
    /// The last count but one of a group.
    #[set(counts.saturating_sub(2))]
    whole_end: usize,
    /// The same of a scan's last group, unless that has only one.
    #[set(if last_counts == 1 { whole_end } else { last_counts - 2 })]
    short_end: usize,
    /// {counts_about(detectors, steps)}
    #[each(_count in 0..counts)]
    #[width(count_bits)]
    pub i_count: Vec<Input<Word>>,
    /// {total_about(detectors)}
    #[each(_detector in 0..if has_totals { detectors } else { 0 })]
    #[width(total_bits)]
    pub i_total: Vec<Input<Word>>,
    /// count 0 was clamped, and so on
    #[each(_count in 0..if saturates { counts } else { 0 })]
    pub i_clamped: Vec<Input<bool>>,
    /// new counts are there in the next clock
    #[when(queues)]
    pub i_pre_counted: Optional<Input<bool>>,
    /// new counts are there
    pub i_counted: Input<bool>,
    /// they are the scan's last
    pub i_last: Input<bool>,
    /// the receiver takes the result
    pub i_ready: Input<bool>,
    /// {data_about(total_sent)}
    #[width(data_bits)]
    pub o_data: Output<Word>,
    /// a result waits
    pub o_valid: Output<bool>,
    /// the result is the scan's last
    pub o_last: Output<bool>,
    /// a result was lost since reset
    pub o_overrun: Output<bool>,
    /// a count was clamped since reset
    #[when(saturates)]
    pub o_saturated: Optional<Output<bool>>,
    /// a group has just been lost
    #[when(tells)]
    pub o_lost: Optional<Output<bool>>,
    /// a count of a group has just been clamped
    #[when(tells && saturates)]
    pub o_clamps: Optional<Output<bool>>,
    /// the result{if queues { ", and above it those that come next" } else { "" }}
    #[each(_count in 0..counts)]
    #[width(count_bits)]
    count: Vec<Register<Word>>,
    /// the result's total count
    #[when(has_totals)]
    #[width(total_bits)]
    total: Optional<Register<Word>>,
    /// total counts of the detectors from 1 on
    #[each(_detector in 1..=further)]
    #[width(total_bits)]
    waiting_total: Vec<Register<Word>>,
    /// detectors of those that come next, one-hot from 1
    #[each(_place in 0..if further > 0 { counts - 1 } else { 0 })]
    #[width(further)]
    detector: Vec<Register<Word>>,
    valid: Register<bool>,
    /// the waiting results are the scan's last
    last: Register<bool>,
    overrun: Register<bool>,
    /// a group was lost
    #[when(tells)]
    lost: Optional<Register<bool>>,
    /// the result is its group's last
    #[when(queues)]
    ends: Optional<Register<bool>>,
    /// the next one is its group's last; then those behind it
    #[each(_count in 0..if queues { counts } else { 0 })]
    next_ends: Vec<Register<bool>>,
    /// the results behind the first have yet to move up
    #[when(is_deep)]
    moves_up: Optional<Register<bool>>,
    /// others of its group come after the result that waits
    #[when(queues)]
    more: Optional<Register<bool>>,
    /// the results behind the first move up, or new ones come
    #[when(queues)]
    changes: Optional<Register<bool>>,
    #[when(saturates)]
    saturated: Optional<Register<bool>>,
    /// a count was clamped
    #[when(tells && saturates)]
    clamps: Optional<Register<bool>>,
    #[when(saturates)]
    #[width(counts)]
    clamped: Optional<Local<Word>>,
    /// those among them that a scan's last group has
    #[when(saturates && is_short)]
    #[width(last_counts)]
    clamped_last: Optional<Local<Word>>,
    /// the result after the one that comes next is the group's last
    #[when(queues)]
    later_ends: Optional<Local<bool>>,
    /// the result that comes next
    #[when(queues)]
    #[width(count_bits)]
    next: Optional<Local<Word>>,
    /// its detector, one-hot from 1
    #[when(further > 0)]
    #[width(further)]
    next_detector: Optional<Local<Word>>,
    /// the count, signed, in whole bytes
    #[when(has_totals)]
    #[width(signed_bits)]
    signed_count: Optional<Local<Word>>,
    blocked: Local<bool>,
    load: Local<bool>,
}

/// What is said of the counts of so many detectors and phase steps at once.
pub(super) fn counts_about(detectors: usize, steps: usize) -> &'static str {
    match (detectors, steps) {
        (1, 1) => "count of the step, signed",
        (1, _) => "counts of the group's steps, signed, step 0 lowest",
        (_, 1) => "counts of the detectors, signed, detector 0 lowest",
        _ => "counts of the detectors' steps, signed, detector 0's step 0 lowest",
    }
}

/// What is said of totals.
fn total_about(detectors: usize) -> &'static str {
    match detectors {
        1 => "total count of the group's steps",
        _ => "total counts of the detectors' steps, detector 0 lowest",
    }
}

/// What is said of a word of the stream.
fn data_about(total: Option<TotalCount>) -> String {
    match total {
        None => "count of the step, signed".to_owned(),
        Some(total) => format!("from bit {} its total, below its signed count", total.first_bit),
    }
}

#[kernel]
impl Logic for ResultStream {
    fn update(&mut self) {
        connect! { self: valid, overrun }
        if self.queues {
            self.queue();
        } else {
            self.o_last.next = self.last.val();
            self.blocked.next = self.valid.val() & !self.i_ready.val();
            self.load.next = self.i_counted.val() & !self.blocked.val();
        }
        if self.load.val() {
            if !self.queues {
                self.count[0].next = self.i_count[0].val();
                if self.total.is_present() {
                    self.total.next = self.i_total[0].val();
                }
            }
            self.last.next = self.i_last.val();
        }
        if self.o_saturated.is_present() {
            self.flag_clamped();
        }
        self.valid.next = self.i_counted.val() | self.blocked.val();
        if self.i_counted.val() & self.blocked.val() {
            self.overrun.next = true;
        }
        if self.lost.is_present() {
            self.lost.next = self.i_counted.val() & self.blocked.val();
            self.o_lost.next = self.lost.val();
        }
        self.offer();
    }

    /// Several counts: the first is offered, the others wait behind it.
    fn queue(&mut self) {
        self.o_last.next = self.last.val() & self.ends.val();
        self.blocked.next = self.more.val() | (self.valid.val() & !self.i_ready.val());
        self.load.next = self.i_counted.val() & !self.blocked.val();
        self.more.next = if self.is_short_at_once {
            self.load.val() & !self.i_last.val()
        } else {
            self.load.val()
        };
        self.changes.next = if self.back_to_back {
            self.i_pre_counted.val() & !self.load.val()
        } else {
            self.i_pre_counted.val()
        };
        if self.more.val() {
            self.more.next = !(self.i_ready.val() & self.next_ends[0].val());
            self.changes.next = self.i_ready.val();
        }
        self.find_next();
        if self.i_ready.val() | !self.valid.val() {
            self.fill_first();
        }
        if self.changes.val() {
            self.fill_behind();
        }
    }

    /// What comes next: the second result, or the third if they have yet to move up.
    fn find_next(&mut self) {
        if self.moves_up.is_present() {
            self.moves_up.next = self.more.val() & self.i_ready.val();
            if self.moves_up.val() {
                self.take_next_from(2);
            } else {
                self.take_next_from(1);
            }
        } else {
            self.take_next_from(1);
        }
    }

    fn take_next_from(&mut self, place: usize) {
        self.next.next = self.count[place].val();
        self.later_ends.next = self.next_ends[place].val();
        if self.next_detector.is_present() {
            self.next_detector.next = self.detector[place - 1].val();
        }
    }

    /// The result that is offered, when it is taken or there is none.
    fn fill_first(&mut self) {
        if self.more.val() {
            self.count[0].next = self.next.val();
            self.ends.next = self.next_ends[0].val();
            self.next_ends[0].next = self.later_ends.val();
            for d in 0..self.further {
                if self.next_detector.val().get_bit(d) {
                    self.total.next = self.waiting_total[d].val();
                }
            }
        } else if self.i_counted.val() {
            self.count[0].next = self.i_count[0].val();
            if self.total.is_present() {
                self.total.next = self.i_total[0].val();
            }
            self.ends.next = if self.is_short_at_once { self.i_last.val() } else { false };
            self.next_ends[0].next = if self.is_deep && self.short_end > 0 {
                false
            } else if self.is_deep {
                self.i_last.val()
            } else if self.is_short {
                !self.i_last.val()
            } else {
                true
            };
        }
    }

    /// The results behind it: those that move up, or a new group.
    fn fill_behind(&mut self) {
        if self.is_deep {
            if self.more.val() {
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
            self.count[c].next = self.i_count[c].val();
        }
        for d in 0..self.further {
            self.waiting_total[d].next = self.i_total[d + 1].val();
        }
        if self.next_detector.is_present() {
            self.mark();
        }
        for c in 1..self.next_ends.len() {
            self.next_ends[c].next = false;
        }
        let whole = self.whole_end;
        let short = self.short_end;
        if self.is_deep && self.is_short {
            self.next_ends[whole].next = !self.i_last.val();
        } else if self.is_deep {
            self.next_ends[whole].next = true;
        }
        if short > 0 && short < whole {
            self.next_ends[short].next = self.i_last.val();
        }
        if self.is_short && self.detectors > 1 {
            self.compact();
        }
    }

    /// Marks the results behind the first with their detectors.
    fn mark(&mut self) {
        let steps = self.steps;
        let further = self.further;
        for step in 1..steps {
            self.detector[step - 1].next = bit_cast(false, further);
        }
        for d in 1..(further + 1) {
            for step in 0..steps {
                self.detector[steps * d + step - 1].next =
                    bit_cast(false, further).replace_bit(d - 1, true);
            }
        }
    }

    /// A scan's last group, whose surplus counts are left out.
    fn compact(&mut self) {
        let steps = self.steps;
        let last_steps = self.last_steps;
        let further = self.further;
        if self.i_last.val() {
            for d in 1..self.detectors {
                for step in 0..last_steps {
                    self.count[last_steps * d + step].next = self.i_count[steps * d + step].val();
                    if self.next_detector.is_present() {
                        self.detector[last_steps * d + step - 1].next =
                            bit_cast(false, further).replace_bit(d - 1, true);
                    }
                }
            }
        }
    }

    /// What comes in behind the last makes no difference.
    fn move_up(&mut self) {
        let last = self.counts - 1;
        for c in 1..last {
            self.count[c].next = self.count[c + 1].val();
            self.next_ends[c].next = self.next_ends[c + 1].val();
        }
        self.count[last].next = self.i_count[last].val();
        self.next_ends[last].next = false;
        for c in 1..self.detector.len() {
            self.detector[c - 1].next = self.detector[c].val();
        }
        if self.next_detector.is_present() {
            let further = self.further;
            self.detector[last - 1].next = bit_cast(false, further).replace_bit(further - 1, true);
        }
    }

    fn flag_clamped(&mut self) {
        self.clamped.next = gather(self.count.len(), |c| self.i_clamped[c].val());
        if self.clamps.is_present() {
            self.clamps.next = false;
            self.o_clamps.next = self.clamps.val();
        }
        if self.clamped_last.is_present() {
            let (steps, last_steps) = (self.steps, self.last_steps);
            self.clamped_last.next = gather(self.last_counts, |c| {
                self.i_clamped[c / last_steps * steps + c % last_steps].val()
            });
            if self.i_counted.val()
                & ((!self.i_last.val() & self.clamped.val().any()) | self.clamped_last.val().any())
            {
                self.saturated.next = true;
                if self.clamps.is_present() {
                    self.clamps.next = true;
                }
            }
        } else if self.i_counted.val() & self.clamped.val().any() {
            self.saturated.next = true;
            if self.clamps.is_present() {
                self.clamps.next = true;
            }
        }
        self.o_saturated.next = self.saturated.val();
    }

    /// The word of the stream.
    fn offer(&mut self) {
        let bits = self.data_bits;
        let below = self.signed_bits;
        if self.total.is_present() {
            self.signed_count.next = bit_cast(signed_cast(self.count[0].val()), below);
            self.o_data.next = bit_cast(self.signed_count.val(), bits)
                | (bit_cast(self.total.val(), bits) << below);
        } else {
            self.o_data.next = bit_cast(signed_cast(self.count[0].val()), bits);
        }
    }
}

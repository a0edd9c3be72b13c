//! What a result stream carries, and what its Verilog says of that.

use crate::rtl::front::prelude::*;
use crate::sensor::interface::TotalCount;

/// What a result stream carries.
#[derive(Debug, Clone, Copy)]
pub struct StreamPlan {
    /// Bits of the counts.
    pub count_bits: u32,
    /// Counts may have been clamped.
    pub saturates: bool,
    /// The totals, if they are sent.
    pub total: Option<TotalCount>,
    /// Bits of the stream's words.
    pub data_bits: u32,
    /// Detectors.
    pub detectors: usize,
    /// Phase steps at once.
    pub steps: usize,
    /// Phase steps of a scan's last group.
    pub last_steps: usize,
    /// Groups may come in successive clocks.
    pub back_to_back: bool,
}

impl StreamPlan {
    pub(super) fn counts(&self) -> usize {
        self.detectors * self.steps
    }

    /// Whether counts wait behind the first.
    pub(super) fn queues(&self) -> bool {
        self.counts() > 1
    }

    /// Whether more than one waits behind the first.
    pub(super) fn is_deep(&self) -> bool {
        self.counts() > 2
    }

    pub(super) fn queued(&self) -> usize {
        if self.queues() { self.counts() } else { 0 }
    }

    pub(super) fn totals(&self) -> usize {
        self.total.map_or(0, |_| self.detectors)
    }

    pub(super) fn total_bits(&self) -> u32 {
        self.total.map_or(1, |total| total.bits)
    }

    pub(super) fn clamped(&self) -> usize {
        if self.saturates { self.counts() } else { 0 }
    }

    /// Detectors whose totals wait for their results' turn.
    pub(super) fn further(&self) -> usize {
        self.totals().saturating_sub(1)
    }

    /// Counts behind the first that are marked with their detector.
    pub(super) fn marked(&self) -> usize {
        if self.further() > 0 { self.counts() - 1 } else { 0 }
    }

    /// Whether a scan's last group has fewer steps.
    pub(super) fn is_short(&self) -> bool {
        self.last_steps < self.steps
    }

    /// Whether a scan's last group is a single count.
    pub(super) fn is_short_at_once(&self) -> bool {
        self.is_short() && self.detectors * self.last_steps == 1
    }

    /// Whether the counts of a scan's last group have gaps between them.
    pub(super) fn compacts(&self) -> bool {
        self.is_short() && self.detectors > 1
    }

    pub(super) fn counts_of_last_group(&self) -> usize {
        self.detectors * self.last_steps
    }

    /// The last count but one of a group.
    pub(super) fn whole_end(&self) -> usize {
        self.counts().saturating_sub(2)
    }

    /// The same of a scan's last group, unless that has only one.
    pub(super) fn short_end(&self) -> usize {
        match self.detectors * self.last_steps {
            1 => self.whole_end(),
            sent => sent - 2,
        }
    }

    pub(super) fn data_bits(&self) -> usize {
        self.data_bits as usize
    }

    /// Bits below the total.
    pub(super) fn signed_bits(&self) -> usize {
        self.total.map_or(1, |total| total.first_bit as usize)
    }
}

/// What is said of the counts of so many detectors and phase steps at once.
pub(in crate::rtl::blocks) fn counts_about(detectors: usize, steps: usize) -> &'static str {
    match (detectors, steps) {
        (1, 1) => "count of the step, signed",
        (1, _) => "counts of the group's steps, signed, step 0 lowest",
        (_, 1) => "counts of the detectors, signed, detector 0 lowest",
        _ => "counts of the detectors' steps, signed, detector 0's step 0 lowest",
    }
}

/// What is said of totals.
pub(super) fn total_about(detectors: usize) -> &'static str {
    match detectors {
        1 => "total count of the group's steps",
        _ => "total counts of the detectors' steps, detector 0 lowest",
    }
}

/// What is said of a word of the stream.
pub(super) fn data_about(total: Option<TotalCount>) -> String {
    match total {
        None => "count of the step, signed".to_owned(),
        Some(total) => format!("from bit {} its total, below its signed count", total.first_bit),
    }
}

/// What stands above the module.
pub(super) fn describe(plan: &StreamPlan) -> About {
    let mut about = About::new("result_stream", "counts of the phase steps as AXI4-Stream").note(
        "The sensor cannot stall: results that come while others still wait are lost, and \
         o_overrun stays high until reset.",
    );
    if plan.detectors * plan.steps > 1 {
        about = about
            .note(format!(
                "A group's {} counts leave in the order of detectors, each detector's in the \
                 order of steps.",
                plan.detectors * plan.steps
            ))
            .note(
                "The first register is offered. Those behind it move up a clock later, so that \
                 i_ready reaches few gates; until they have, what comes next is the third's.",
            );
    }
    if plan.total.is_some() {
        about = about.note(
            "A detector's steps have seen the same light: their total count is kept once, and \
             goes out with each of them.",
        );
    }
    if plan.last_steps < plan.steps {
        about = about.note(format!(
            "A scan's last group has {} steps; the surplus counts are not sent.",
            plan.last_steps
        ));
    }
    if plan.saturates {
        about = about.note("o_saturated stays high until reset.");
    }
    about.fact("Latency", "1 clock from i_counted to o_valid")
}

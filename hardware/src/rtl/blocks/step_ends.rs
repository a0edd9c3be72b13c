//! When the hits of a phase step, and its count, are there.
//!
//! Shift registers behind the last chips of steps and scans; whoever finds those has them.

use crate::rtl::front::prelude::*;

/// Ports behind the ends of steps and scans.
#[block]
pub struct StepEnds {
    /// Heading over the ports, empty without one.
    heading: &'static str,
    /// Clocks from a step's last one until its hits are in the total.
    clocks_to_dump: u32,
    /// Segments of the total.
    segments: u32,
    /// Clocks from the dump of the lowest segment to the whole count.
    clocks_to_count: u32,
    /// Whether `o_pre_counted` is there.
    counts_early: bool,
    #[set((clocks_to_dump + clocks_to_count) as usize)]
    to_counted: usize,
    /// {dump_about(segments)}
    #[under(heading)]
    #[width(segments)]
    pub o_dump: Output<Word>,
    /// the step's count is there in the next clock
    #[when(counts_early)]
    pub o_pre_counted: Optional<Output<bool>>,
    /// the step's count is there
    pub o_counted: Output<bool>,
    /// the count of the scan's last step is there
    pub o_scan_counted: Output<bool>,
    /// bit n: a step's last chip was n + 1 clocks ago
    #[width(to_counted)]
    step_done: Register<Word>,
    /// bit n: a scan's last chip was n + 1 clocks ago
    #[width(to_counted)]
    scan_done: Register<Word>,
    /// the present chip is a step's last
    pub(super) step_ends: Local<bool>,
    /// it is a scan's last
    pub(super) scan_ends: Local<bool>,
}

/// What stands beside a port that dumps totals of some segments.
pub(super) fn dump_about(segments: u32) -> &'static str {
    match segments {
        1 => "the total has just taken in a step's last hits",
        _ => "bit s: segment s has just taken in a step's last hits",
    }
}

#[kernel]
impl StepEnds {
    /// Tells the rest when a step's hits, and its count, are there.
    pub(super) fn report(&mut self) {
        self.step_done.next = self.step_done.val().shifted_in(self.step_ends.val());
        self.scan_done.next = self.scan_done.val().shifted_in(self.scan_ends.val());
        let (dump, counted) = (self.clocks_to_dump as usize - 1, self.to_counted - 1);
        if self.counts_early {
            self.o_pre_counted.next = self.step_done.val().get_bit(counted - 1);
        }
        self.o_counted.next = self.step_done.val().get_bit(counted);
        self.o_scan_counted.next = self.scan_done.val().get_bit(counted);
        self.o_dump.next = self.step_done.val().slice(dump, self.segments as usize);
    }
}

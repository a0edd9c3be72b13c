//! The histogram of one detector.
//!
//! Latency 1 clock from samples to hits, then that of the adders.
//!
//! Cost: an edge detector, and an adder with its banks for each group of samples.

use super::{BinAdder, EdgeDetector, WordPorts};
use crate::rtl::front::prelude::*;
use crate::sensor::histogram::HistogramPlan;

#[block(histogram_channel)]
/// histogram of one detector's arrival times
///
/// - Bins: {plan.rows} rows of {plan.row_bins}, {plan.bin_bits} bits each{about_clamping(plan.saturates())}
/// - Adders: {plan.adders()}, each for {plan.adder_samples} neighbouring samples
pub struct HistogramChannel {
    plan: HistogramPlan,
    /// level of the SPAD, bit 0 earliest
    #[width(plan.row_bins)]
    pub i_samples: Input<Word>,
    /// words count
    pub i_run: Input<bool>,
    /// of the word on its way
    #[shown]
    #[is(WordPorts::new(plan))]
    io: WordPorts,
    /// bins of the row that was read, {plan.bin_data_bits()} bits each, bit 0 earliest
    #[width(plan.row_data_bits())]
    pub o_bins: Output<Word>,
    /// a hit found its bin full
    #[when(plan.saturates())]
    pub o_clamped: Optional<Output<bool>>,
    #[is(EdgeDetector::new(plan.row_bins as usize, 1))]
    edges: EdgeDetector,
    #[each(_adder in 0..plan.adders())]
    #[is(BinAdder::new(plan))]
    adder: Vec<BinAdder>,
    #[when(plan.saturates())]
    #[width(plan.adders())]
    clamped: Optional<Local<Word>>,
}

/// What is said behind the bits of a count.
pub(super) fn about_clamping(saturates: bool) -> &'static str {
    if saturates { ", clamped" } else { "; no stimulus can overflow them" }
}

#[kernel]
impl Logic for HistogramChannel {
    fn update(&mut self) {
        connect! { self.edges from self: i_samples, i_run }
        self.hand_hits();
        for a in 0..self.adder.len() {
            connect! {
                self.adder[a] from self.io: i_row, i_half, i_read_row, i_go, i_come_first,
                    i_come_half, i_held_first, i_held_half, i_added_first, i_write_row, i_write_half
            }
        }
        self.make_row();
        if self.o_clamped.is_present() {
            self.clamped.next = gather(self.adder.len(), |a| self.adder[a].o_clamped.val());
            self.o_clamped.next = self.clamped.val().any();
        }
    }

    fn hand_hits(&mut self) {
        let pairs = self.plan.adder_samples.div_ceil(2) as usize;
        for a in 0..self.adder.len() {
            self.adder[a].i_hits.next = self.edges.o_hits.val().slice(pairs * a, pairs);
            if self.plan.row_bins > 1 {
                self.adder[a].i_early.next = self.edges.o_early.val().slice(pairs * a, pairs);
            }
        }
    }

    /// The bins of all adders, each filled up to whole bytes.
    fn make_row(&mut self) {
        let (bits, data_bits) = (self.plan.bin_bits as usize, self.plan.bin_data_bits() as usize);
        let bins = self.plan.adder_samples as usize;
        self.o_bins.next = gather(self.plan.row_data_bits() as usize, |b| {
            if b % data_bits < bits {
                let bin = b / data_bits;
                self.adder[bin / bins].o_bins.val().get_bit(bits * (bin % bins) + b % data_bits)
            } else {
                false
            }
        });
    }
}

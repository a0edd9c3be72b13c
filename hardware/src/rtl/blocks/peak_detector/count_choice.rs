//! One of several counts.
//!
//! One bit says whose turn it is, so that a count costs an AND and an OR, and no number of the turn has to
//! be decoded.

use crate::rtl::front::prelude::*;

#[block(count_choice)]
/// one of several counts
///
/// - Latency: 1 clock
pub struct CountChoice {
    bits: u32,
    /// counts
    #[size(1..=usize::MAX)]
    counts: usize,
    /// at most one bit: which count's turn it is
    #[width(counts)]
    pub i_turn: Input<Word>,
    /// counts, count 0 lowest
    #[each(_count in 0..counts)]
    #[width(bits)]
    pub i_count: Vec<Input<Word>>,
    /// the count whose turn it was, or 0
    #[width(bits)]
    pub o_count: Output<Word>,
    /// the count whose turn it is, or 0
    #[width(bits)]
    present: Local<Word>,
    #[width(bits)]
    chosen: Register<Word>,
}

#[kernel]
impl Logic for CountChoice {
    fn update(&mut self) {
        self.present.next = self.i_count[0].val() & signed_cast(self.i_turn.val().get_bit(0));
        for c in 1..self.counts {
            self.present.next = self.present.val()
                | (self.i_count[c].val() & signed_cast(self.i_turn.val().get_bit(c)));
        }
        self.chosen.next = self.present.val();
        self.o_count.next = self.chosen.val();
    }
}

//! Compares signed counts, some bits in a clock.
//!
//! Both counts stand still meanwhile, so that no piece waits in a register for those below it.

use super::CountPiece;
use crate::rtl::front::prelude::*;
use crate::sensor::peak::PeakPlan;

#[block(count_comparison)]
/// whether a signed count is greater
///
/// With their signs exchanged, signed numbers compare as unsigned
/// ones{if sizes.len() > 1 { ": a piece a clock, the lowest bits first. Both counts stand still meanwhile" } else { "" }}.
#[when(sizes.len() == 1)]
/// - Latency: 1 clock
#[when(sizes.len() > 1)]
/// - Latency: {sizes.len()} clocks
pub struct CountComparison {
    plan: PeakPlan,
    #[set(plan.count_bits as usize)]
    width: usize,
    /// Bits of each piece, the lowest first; all but the top one are equal.
    #[set((0..plan.pieces).map(|piece| plan.piece_bits(piece) as usize).collect())]
    sizes: Vec<usize>,
    /// a count, signed
    #[width(width)]
    pub i_count: Input<Word>,
    /// what it is compared with, signed
    #[width(width)]
    pub i_other: Input<Word>,
    /// the count is greater
    pub o_greater: Output<bool>,
    /// the count with the other's sign
    #[width(width)]
    unsigned_count: Local<Word>,
    /// the other with the count's sign
    #[width(width)]
    unsigned_other: Local<Word>,
    #[each(size in sizes.iter())]
    #[is(CountPiece::new(*size))]
    piece: Vec<CountPiece>,
}

#[kernel]
impl Logic for CountComparison {
    fn update(&mut self) {
        let sign = self.width - 1;
        self.unsigned_count.next =
            self.i_count.val().replace_bit(sign, self.i_other.val().get_bit(sign));
        self.unsigned_other.next =
            self.i_other.val().replace_bit(sign, self.i_count.val().get_bit(sign));
        for p in 0..self.sizes.len() {
            let (low, size) = (self.sizes[0] * p, self.sizes[p]);
            self.piece[p].i_count.next = self.unsigned_count.val().slice(low, size);
            self.piece[p].i_other.next = self.unsigned_other.val().slice(low, size);
        }
        self.piece[0].i_below.next = false;
        for p in 1..self.piece.len() {
            self.piece[p].i_below.next = self.piece[p - 1].o_greater.val();
        }
        self.o_greater.next = self.piece[self.sizes.len() - 1].o_greater.val();
    }
}

//! Clamps a count to fewer bits.
//!
//! The count fits if its low bits extend to it, one comparison in place of two with the largest and the
//! smallest. The sign is the exact count's either way, so that only the bits below it have a choice.
//!
//! Cost (ECP5, docs/resources.md): 15 LUTs for 8 bits out of 17, which save 8 flip-flops.

use crate::rtl::front::prelude::*;

#[block(count_clamp)]
/// the nearest count of fewer bits
///
/// The sign is that of the exact count. The largest count has the opposite of its sign in all bits
/// below it, and so has the smallest.
///
/// - Latency: 0 clocks
pub struct CountClamp {
    exact_bits: usize,
    count_bits: usize,
    /// exact count, signed
    #[width(exact_bits)]
    pub i_count: Input<Word>,
    /// the nearest count that fits, signed
    #[width(count_bits)]
    pub o_count: Output<Word>,
    /// it is not the exact one
    pub o_clamped: Output<bool>,
    /// bits below the sign
    #[width(count_bits - 1)]
    low: Local<Word>,
}

#[kernel]
impl Logic for CountClamp {
    fn update(&mut self) {
        let sign = self.exact_bits - 1;
        let top = self.count_bits - 1;
        self.o_clamped.next =
            bit_cast(signed_cast(bit_cast(self.i_count.val(), self.count_bits)), self.exact_bits)
                != self.i_count.val();
        if self.o_clamped.val() {
            self.low.next = signed_cast(!self.i_count.val().get_bit(sign)).into();
        } else {
            self.low.next = bit_cast(self.i_count.val(), top);
        }
        self.o_count.next = bit_cast(self.low.val(), self.count_bits)
            .replace_bit(top, self.i_count.val().get_bit(sign));
    }
}

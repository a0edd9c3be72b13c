//! Clamps a count to fewer bits.
//!
//! | port | |
//! |---|---|
//! | `i_count` | the exact count |
//! | `o_count`, `o_clamped` | the nearest that fits; it is another |
//!
//! Latency 0 clocks. The count fits if its low bits extend to it, one comparison in place of two
//! with the largest and the smallest.
//!
//! Cost (ECP5, docs/resources.md): 15 LUTs for 8 bits out of 17, which save 8 flip-flops.

use crate::rtl::front::prelude::*;

/// The nearest count that fits.
#[block(About::new("count_clamp", "the nearest count of fewer bits").fact("Latency", "0 clocks"))]
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
    #[width(count_bits)]
    #[value((1 << (count_bits - 1)) - 1)]
    largest: Constant,
    #[width(count_bits)]
    #[value(1 << (count_bits - 1))]
    smallest: Constant,
}

#[kernel]
impl Logic for CountClamp {
    fn update(&mut self) {
        let sign = self.exact_bits - 1;
        self.o_clamped.next =
            bit_cast(signed_cast(bit_cast(self.i_count.val(), self.count_bits)), self.exact_bits)
                != self.i_count.val();
        if !self.o_clamped.val() {
            self.o_count.next = bit_cast(self.i_count.val(), self.count_bits);
        } else if self.i_count.val().get_bit(sign) {
            self.o_count.next = self.smallest.val();
        } else {
            self.o_count.next = self.largest.val();
        }
    }
}

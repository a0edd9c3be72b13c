//! Clamps a count to fewer bits.

use crate::hdl::front::prelude::*;

/// The nearest count that fits.
#[derive(Debug, Clone, LogicBlock)]
pub struct CountClamp {
    /// The exact count.
    pub i_count: Input<Word>,
    /// The nearest one that fits.
    pub o_count: Output<Word>,
    /// They differ.
    pub o_clamped: Output<bool>,
    about: About,
    largest: Constant,
    smallest: Constant,
    _exact_bits: usize,
    _count_bits: usize,
}

impl CountClamp {
    /// From `exact_bits` to `count_bits`, which are fewer.
    pub fn new(exact_bits: u32, count_bits: u32) -> CountClamp {
        let half = 1u128 << (count_bits - 1);
        CountClamp {
            i_count: Input::word(exact_bits, "exact count, signed"),
            o_count: Output::word(count_bits, "the nearest count that fits, signed"),
            o_clamped: Output::bit("it is not the exact one"),
            about: About::new("count_clamp", "the nearest count of fewer bits")
                .fact("Latency", "0 clocks"),
            largest: Constant::new(half - 1, count_bits, "Largest count"),
            smallest: Constant::new(half, count_bits, "Smallest count"),
            _exact_bits: exact_bits as usize,
            _count_bits: count_bits as usize,
        }
    }
}

impl Logic for CountClamp {
    #[hdl_gen]
    fn update(&mut self) {
        self.o_clamped.next = bit_cast(
            signed_cast(bit_cast(self.i_count.val(), self._count_bits)),
            self._exact_bits,
        ) != self.i_count.val();
        for sign in (self._exact_bits - 1)..self._exact_bits {
            if !self.o_clamped.val() {
                self.o_count.next = bit_cast(self.i_count.val(), self._count_bits);
            } else if self.i_count.val().get_bit(sign) {
                self.o_count.next = self.smallest.val();
            } else {
                self.o_count.next = self.largest.val();
            }
        }
    }
}

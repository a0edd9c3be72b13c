//! Counts the hits in four pairs of samples.
//!
//! Every bit of a count of four ones is one gate of four inputs, so that hits and hits that count down are
//! counted within a clock without a carry chain.
//!
//! Cost (ECP5, docs/resources.md): 10 LUTs, 10 flip-flops.

use crate::rtl::front::prelude::*;

#[block(quad_counter)]
/// signed count of four pairs of samples
///
/// A hit adds 1, and a hit that counts down takes 2 off again. Four ones are counted by two half adders
/// whose sums and carries meet in one gate each.
///
/// - Latency: 2 clocks
pub struct QuadCounter {
    /// pairs with a hit
    #[width(4)]
    pub i_hit: Input<Word>,
    /// those whose hit counts down
    #[width(4)]
    pub i_down: Input<Word>,
    /// hits that count up less hits that count down, signed
    #[width(4)]
    pub o_sum: Output<Word>,
    /// or three
    two_hits: Local<bool>,
    /// or three
    two_downs: Local<bool>,
    #[width(3)]
    hits: Register<Word>,
    #[width(3)]
    downs: Register<Word>,
    #[width(4)]
    sum: Register<Word>,
}

#[kernel]
impl Logic for QuadCounter {
    fn update(&mut self) {
        self.two_hits.next = (self.i_hit.val().get_bit(0) & self.i_hit.val().get_bit(1))
            ^ (self.i_hit.val().get_bit(2) & self.i_hit.val().get_bit(3))
            ^ ((self.i_hit.val().get_bit(0) ^ self.i_hit.val().get_bit(1))
                & (self.i_hit.val().get_bit(2) ^ self.i_hit.val().get_bit(3)));
        self.two_downs.next = (self.i_down.val().get_bit(0) & self.i_down.val().get_bit(1))
            ^ (self.i_down.val().get_bit(2) & self.i_down.val().get_bit(3))
            ^ ((self.i_down.val().get_bit(0) ^ self.i_down.val().get_bit(1))
                & (self.i_down.val().get_bit(2) ^ self.i_down.val().get_bit(3)));
        self.hits.next = bit_cast(self.i_hit.val().xor(), 3)
            .replace_bit(1, self.two_hits.val())
            .replace_bit(2, self.i_hit.val().all());
        self.downs.next = bit_cast(self.i_down.val().xor(), 3)
            .replace_bit(1, self.two_downs.val())
            .replace_bit(2, self.i_down.val().all());
        self.sum.next = bit_cast(self.hits.val(), 4) - (bit_cast(self.downs.val(), 4) << 1);
        self.o_sum.next = self.sum.val();
    }
}

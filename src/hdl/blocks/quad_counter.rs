//! Counts the hits in four pairs of samples.

use crate::hdl::front::prelude::*;

/// The signed count of four pairs.
#[derive(Debug, Clone, LogicBlock)]
pub struct QuadCounter {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Pairs with a hit.
    pub i_hit: Input<Word>,
    /// Pairs whose hit counts down.
    pub i_down: Input<Word>,
    /// Hits that count up less hits that count down.
    pub o_sum: Output<Word>,
    about: About,
    two_hits: Local<bool>,
    two_downs: Local<bool>,
    hits: Register<Word>,
    downs: Register<Word>,
    sum: Register<Word>,
}

impl QuadCounter {
    /// The counter.
    pub fn new() -> QuadCounter {
        QuadCounter {
            i_clk: Input::bit("four pairs per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_hit: Input::word(4, "pairs with a hit"),
            i_down: Input::word(4, "those whose hit counts down"),
            o_sum: Output::word(4, "hits that count up less hits that count down, signed"),
            about: About::new("quad_counter", "signed count of four pairs of samples")
                .note(
                    "A hit adds 1, and a hit that counts down takes 2 off again. Four ones are \
                     counted by two half adders whose sums and carries meet in one gate each.",
                )
                .fact("Latency", "2 clocks")
                .fact("Rate", "four pairs per clock"),
            two_hits: Local::bit("two or three hits"),
            two_downs: Local::bit("two or three hits that count down"),
            hits: Register::word(3, 0, "number of hits"),
            downs: Register::word(3, 0, "number of hits that count down"),
            sum: Register::word(4, 0, "hits that count up less hits that count down"),
        }
    }
}

impl Default for QuadCounter {
    fn default() -> QuadCounter {
        QuadCounter::new()
    }
}

impl Logic for QuadCounter {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, hits, downs, sum);
        self.two_hits.next = (self.i_hit.val().get_bit(0) & self.i_hit.val().get_bit(1))
            ^ (self.i_hit.val().get_bit(2) & self.i_hit.val().get_bit(3))
            ^ ((self.i_hit.val().get_bit(0) ^ self.i_hit.val().get_bit(1))
                & (self.i_hit.val().get_bit(2) ^ self.i_hit.val().get_bit(3)));
        self.two_downs.next = (self.i_down.val().get_bit(0) & self.i_down.val().get_bit(1))
            ^ (self.i_down.val().get_bit(2) & self.i_down.val().get_bit(3))
            ^ ((self.i_down.val().get_bit(0) ^ self.i_down.val().get_bit(1))
                & (self.i_down.val().get_bit(2) ^ self.i_down.val().get_bit(3)));
        self.hits.d.next = bit_cast(self.i_hit.val().xor(), 3)
            .replace_bit(1, self.two_hits.val())
            .replace_bit(2, self.i_hit.val().all());
        self.downs.d.next = bit_cast(self.i_down.val().xor(), 3)
            .replace_bit(1, self.two_downs.val())
            .replace_bit(2, self.i_down.val().all());
        self.sum.d.next = bit_cast(self.hits.q.val(), 4) - (bit_cast(self.downs.q.val(), 4) << 1);
        self.o_sum.next = self.sum.q.val();
    }
}

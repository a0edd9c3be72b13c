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
    pairs: Vec<Local<Word>>,
    ones: Vec<Register<Word>>,
    sum: Register<Word>,
}

impl QuadCounter {
    /// The counter.
    pub fn new() -> QuadCounter {
        let ones = |name: &str, about: &str| Register::word(3, 0, about).named(name);
        QuadCounter {
            i_clk: Input::bit("four pairs per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_hit: Input::word(4, "pairs with a hit"),
            i_down: Input::word(4, "those whose hit counts down"),
            o_sum: Output::word(4, "hits that count up less hits that count down, signed"),
            about: About::new("quad_counter", "signed count of four pairs of samples")
                .note(
                    "Ones are counted as carry-save adders do: two half adders, whose sums and \
                     carries are added.",
                )
                .fact("Latency", "2 clocks")
                .fact("Rate", "four pairs per clock"),
            pairs: vec![
                Local::word(4, "pairs with a hit"),
                Local::word(4, "pairs whose hit counts down"),
            ],
            ones: vec![
                ones("hits", "number of hits"),
                ones("downs", "number of hits that count down"),
            ],
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
        dff_setup!(self, i_clk, sum);
        self.pairs[0].next = self.i_hit.val();
        self.pairs[1].next = self.i_down.val();
        for w in 0..2 {
            dff_setup!(self, i_clk, ones[w]);
            self.ones[w].d.next = bit_cast(false, 3)
                .replace_bit(0, self.pairs[w].val().xor())
                .replace_bit(
                    1,
                    (self.pairs[w].val().get_bit(0) & self.pairs[w].val().get_bit(1))
                        ^ (self.pairs[w].val().get_bit(2) & self.pairs[w].val().get_bit(3))
                        ^ ((self.pairs[w].val().get_bit(0) ^ self.pairs[w].val().get_bit(1))
                            & (self.pairs[w].val().get_bit(2) ^ self.pairs[w].val().get_bit(3))),
                )
                .replace_bit(2, self.pairs[w].val().all());
        }
        self.sum.d.next =
            bit_cast(self.ones[0].q.val(), 4) - (bit_cast(self.ones[1].q.val(), 4) << 1);
        self.o_sum.next = self.sum.q.val();
    }
}

//! One of several counts.

use crate::hdl::front::prelude::*;

/// Keeps the count whose turn it is.
#[derive(Debug, Clone, LogicBlock)]
pub struct CountChoice {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// At most one bit: which count's turn it is.
    pub i_turn: Input<Word>,
    /// The counts.
    pub i_count: Vec<Input<Word>>,
    /// The count whose turn it was a clock ago, or 0 if it was none's.
    pub o_count: Output<Word>,
    about: About,
    up_to: Vec<Local<Word>>,
    chosen: Register<Word>,
    _counts: usize,
}

impl CountChoice {
    /// Out of `counts` counts of `bits` bits.
    pub fn new(bits: u32, counts: u32) -> CountChoice {
        CountChoice {
            i_clk: Input::bit("one choice per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_turn: Input::word(counts, "at most one bit: which count's turn it is"),
            i_count: (0..counts)
                .map(|count| Input::word(bits, format!("count {count}")))
                .collect(),
            o_count: Output::word(bits, "the count whose turn it was, or 0"),
            about: About::new("count_choice", "one of several counts")
                .fact("Latency", "1 clock")
                .fact("Rate", "one choice per clock"),
            up_to: (0..counts)
                .map(|count| match count {
                    0 => Local::word(bits, "count 0 if it is its turn"),
                    _ => Local::word(bits, format!("one of counts 0 to {count}")),
                })
                .collect(),
            chosen: Register::word(bits, 0, "the count whose turn it was, or 0"),
            _counts: counts as usize,
        }
    }
}

impl Logic for CountChoice {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, chosen);
        self.up_to[0].next = self.i_count[0].val() & signed_cast(self.i_turn.val().get_bit(0));
        for c in 1..self._counts {
            self.up_to[c].next = self.up_to[c - 1].val()
                | (self.i_count[c].val() & signed_cast(self.i_turn.val().get_bit(c)));
        }
        for last in (self._counts - 1)..self._counts {
            self.chosen.d.next = self.up_to[last].val();
        }
        self.o_count.next = self.chosen.q.val();
    }
}

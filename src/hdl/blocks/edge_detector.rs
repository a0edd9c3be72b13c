//! Hits: rising edges of the sampled SPAD level.

use crate::hdl::front::prelude::*;

/// Marks every pair of samples that holds a rising edge, and says which.
#[derive(Debug, Clone, LogicBlock)]
pub struct EdgeDetector {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// One word of samples, the earliest in bit 0.
    pub i_samples: Input<Word>,
    /// Whether hits count.
    pub i_run: Input<bool>,
    /// Pairs of samples with a hit.
    pub o_hits: Output<Word>,
    /// Where it is the earlier sample of the pair.
    pub o_early: Optional<Output<Word>>,
    about: About,
    rising: Local<Word>,
    pairs: Wiring,
    earlier: Optional<Wiring>,
    last_sample: Register<bool>,
    hits: Register<Word>,
    early: Optional<Register<Word>>,
    _lanes: usize,
}

impl EdgeDetector {
    /// For words of `lanes` samples.
    pub fn new(lanes: u32) -> EdgeDetector {
        let pairs = lanes.div_ceil(2);
        let has_pairs = lanes > 1;
        let all = || (0..pairs as usize).collect();
        EdgeDetector {
            i_clk: Input::bit("one sample word per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_samples: Input::word(lanes, "level of the SPAD, bit 0 earliest"),
            i_run: Input::bit("the word belongs to a scan"),
            o_hits: Output::word(pairs, "pairs of samples with a high one after a low one"),
            o_early: Optional::new(
                has_pairs,
                Output::word(pairs, "the hit is the earlier sample of its pair"),
            ),
            about: About::new(
                "edge_detector",
                "one hit per rising edge of the SPAD's level",
            )
            .note(
                "Of two neighbouring samples at most one is a rising edge, and it is the earlier \
                 one exactly when that sample is high: two bits say all about a pair.",
            )
            .note(
                "The last sample of a word is kept outside scans too, so that a pulse that \
                 began before a scan is no hit of it.",
            )
            .fact("Latency", "1 clock")
            .fact("Rate", "one word per clock"),
            rising: Local::word(lanes, "samples that are high after a low one"),
            pairs: Wiring::new(pairs as usize, all(), "pairs with such a sample"),
            earlier: Optional::new(
                has_pairs,
                Wiring::new(pairs as usize, all(), "the earlier sample of each pair"),
            ),
            last_sample: Register::bit(false, "last sample of the word before"),
            hits: Register::word(pairs, 0, "pairs of samples with a high one after a low one"),
            early: Optional::new(
                has_pairs,
                Register::word(pairs, 0, "the hit is the earlier sample of its pair"),
            ),
            _lanes: lanes as usize,
        }
    }
}

impl Logic for EdgeDetector {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, last_sample, hits);
        for last in (self._lanes - 1)..self._lanes {
            self.last_sample.d.next = self.i_samples.val().get_bit(last);
        }
        self.rising.next = self.i_samples.val()
            & !((self.i_samples.val() << 1) | bit_cast(self.last_sample.q.val(), self._lanes))
            & signed_cast(self.i_run.val());
        for j in 0..(self._lanes / 2) {
            self.pairs.i[j].next =
                self.rising.val().get_bit(2 * j) | self.rising.val().get_bit(2 * j + 1);
            self.earlier[0].i[j].next = self.i_samples.val().get_bit(2 * j);
        }
        for _single in 0..(self._lanes % 2) {
            self.pairs.i[0].next = self.rising.val().get_bit(0);
        }
        self.hits.d.next = self.pairs.o.val();
        self.o_hits.next = self.hits.q.val();
        for _pairs in 0..self.early.count() {
            dff_setup!(self, i_clk, early[0]);
            self.early[0].d.next = self.earlier[0].o.val();
            self.o_early[0].next = self.early[0].q.val();
        }
    }
}

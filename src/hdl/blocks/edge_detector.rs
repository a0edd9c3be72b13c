//! Hits: rising edges of the sampled SPAD level.

use crate::hdl::front::prelude::*;

/// Marks every sample that is high after a low one.
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
    /// The samples that begin a pulse.
    pub o_hits: Output<Word>,
    about: About,
    last_sample: Register<bool>,
    hits: Register<Word>,
    _lanes: usize,
}

impl EdgeDetector {
    /// For words of `lanes` samples.
    pub fn new(lanes: u32) -> EdgeDetector {
        EdgeDetector {
            i_clk: Input::bit("one sample word per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_samples: Input::word(lanes, "level of the SPAD, bit 0 earliest"),
            i_run: Input::bit("the word belongs to a scan"),
            o_hits: Output::word(lanes, "samples that are high after a low one"),
            about: About::new(
                "edge_detector",
                "one hit per rising edge of the SPAD's level",
            )
            .note(
                "The last sample of a word is kept outside scans too, so that a pulse that \
                     began before a scan is no hit of it.",
            )
            .fact("Latency", "1 clock")
            .fact("Rate", "one word per clock"),
            last_sample: Register::bit(false, "last sample of the word before"),
            hits: Register::word(lanes, 0, "samples that are high after a low one"),
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
        self.hits.d.next = self.i_samples.val()
            & !((self.i_samples.val() << 1) | bit_cast(self.last_sample.q.val(), self._lanes))
            & signed_cast(self.i_run.val());
        self.o_hits.next = self.hits.q.val();
    }
}

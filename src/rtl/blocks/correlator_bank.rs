//! Correlators of some phase steps that share their light.

use super::UpdownCorrelator;
use super::scan_controller::dump_about;
use crate::rtl::front::prelude::*;
use crate::sensor::contract::CountSegments;

/// Correlates one detector's hits with several delays of its reference, and
/// hands both on to the next bank.
#[derive(Debug, Clone, LogicBlock)]
pub struct CorrelatorBank {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Pairs of samples with a hit.
    pub i_hits: Input<Word>,
    /// Where it is the earlier sample of the pair.
    pub i_early: Optional<Input<Word>>,
    /// Reference of each sample, for the steps of this bank and those after it.
    pub i_window: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the count.
    pub i_dump: Input<Word>,
    /// Counts of the bank's steps.
    pub o_count: Vec<Output<Word>>,
    /// `i_hits` for the next bank, if there is one; and so on.
    pub o_hits: Optional<Output<Word>>,
    /// `i_early` for the next bank.
    pub o_early: Optional<Output<Word>>,
    /// `i_window` for the next bank.
    pub o_window: Optional<Output<Word>>,
    /// `i_dump` for the next bank.
    pub o_dump: Optional<Output<Word>>,
    about: About,
    reference: Vec<Wiring>,
    correlator: Vec<UpdownCorrelator>,
    hits: Optional<Register<Word>>,
    early: Optional<Register<Word>>,
    window: Optional<Register<Word>>,
    dump: Optional<Register<Word>>,
    _lanes: usize,
    _steps: usize,
    _last_tap: usize,
    _next_bits: usize,
}

impl CorrelatorBank {
    /// The first `steps` of the `rest` steps that this bank and those after it
    /// have.
    pub fn new(lanes: u32, segments: CountSegments, steps: u32, rest: u32) -> CorrelatorBank {
        let pairs = lanes.div_ceil(2);
        let window_bits = lanes + rest - 1;
        let next_bits = window_bits - steps;
        let has_next = rest > steps;
        let has_pairs = lanes > 1;
        let all_lanes = || (0..lanes as usize).collect();
        CorrelatorBank {
            i_clk: Input::bit("one word per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_hits: Input::word(pairs, "pairs of samples with a hit"),
            i_early: Optional::new(
                has_pairs,
                Input::word(pairs, "the hit is the earlier sample of its pair"),
            ),
            i_window: Input::word(
                window_bits,
                "reference of each sample; the last step's lowest",
            ),
            i_dump: Input::word(segments.count, dump_about(segments.count)),
            o_count: (0..steps)
                .map(|step| Output::word(segments.bits(), format!("count of step {step}, signed")))
                .collect(),
            o_hits: Optional::new(has_next, Output::word(pairs, "i_hits for the next bank")),
            o_early: Optional::new(
                has_next && has_pairs,
                Output::word(pairs, "i_early for the next bank"),
            ),
            o_window: Optional::new(
                has_next,
                Output::word(next_bits, "i_window for the next bank"),
            ),
            o_dump: Optional::new(
                has_next,
                Output::word(segments.count, "i_dump for the next bank"),
            ),
            about: describe(steps, has_next),
            reference: (0..steps)
                .map(|_| Wiring::new(lanes as usize, all_lanes(), ""))
                .collect(),
            correlator: (0..steps)
                .map(|_| UpdownCorrelator::new(lanes, segments))
                .collect(),
            hits: Optional::new(has_next, Register::word(pairs, 0, "")),
            early: Optional::new(has_next && has_pairs, Register::word(pairs, 0, "")),
            window: Optional::new(has_next, Register::word(next_bits, 0, "")),
            dump: Optional::new(has_next, Register::word(segments.count, 0, "")),
            _lanes: lanes as usize,
            _steps: steps as usize,
            _last_tap: rest as usize - 1,
            _next_bits: next_bits as usize,
        }
    }
}

fn describe(steps: u32, has_next: bool) -> About {
    let about = About::new(
        "correlator_bank",
        &format!("correlators of {steps} phase steps that share their light"),
    )
    .note("Each step takes the reference a sample later than the step before it.");
    if has_next {
        about.note(
            "The next bank works a clock behind this one, so that no register has to reach all \
             correlators within a clock.",
        )
    } else {
        about
    }
}

impl Logic for CorrelatorBank {
    #[hdl_gen]
    fn update(&mut self) {
        for last in self._last_tap..(self._last_tap + 1) {
            for q in 0..self._steps {
                for l in 0..self._lanes {
                    self.reference[q].i[l].next = self.i_window.val().get_bit(l + last - q);
                }
            }
        }
        for q in 0..self._steps {
            self.correlator[q].i_clk.next = self.i_clk.val();
            self.correlator[q].i_rst.next = self.i_rst.val();
            self.correlator[q].i_hits.next = self.i_hits.val();
            for _pairs in 0..self.i_early.count() {
                self.correlator[q].i_early[0].next = self.i_early[0].val();
            }
            self.correlator[q].i_reference.next = self.reference[q].o.val();
            self.correlator[q].i_dump.next = self.i_dump.val();
            self.o_count[q].next = self.correlator[q].o_count.val();
        }
        for _next in 0..self.o_hits.count() {
            dff_setup!(self, i_clk, hits[0], window[0], dump[0]);
            self.hits[0].d.next = self.i_hits.val();
            self.window[0].d.next = bit_cast(self.i_window.val(), self._next_bits);
            self.dump[0].d.next = self.i_dump.val();
            self.o_hits[0].next = self.hits[0].q.val();
            self.o_window[0].next = self.window[0].q.val();
            self.o_dump[0].next = self.dump[0].q.val();
        }
        for _next_pairs in 0..self.o_early.count() {
            dff_setup!(self, i_clk, early[0]);
            self.early[0].d.next = self.i_early[0].val();
            self.o_early[0].next = self.early[0].q.val();
        }
    }
}

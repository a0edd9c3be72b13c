//! Counts hits up or down as the reference says.

use crate::hdl::front::prelude::*;

/// A running total of hits with the sign of the reference.
#[derive(Debug, Clone, LogicBlock)]
pub struct UpdownCorrelator {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Hits of one word.
    pub i_hits: Input<Word>,
    /// Reference of each of its samples.
    pub i_reference: Input<Word>,
    /// Last clock of a phase step, one clock before its hits.
    pub i_step_end: Input<bool>,
    /// Last clock of a scan, one clock before its hits.
    pub i_scan_end: Input<bool>,
    /// Sum of all hits so far.
    pub o_total: Output<Word>,
    /// `o_total` has just taken in the last hits of a step.
    pub o_dump: Output<bool>,
    /// The step is the scan's last.
    pub o_last: Output<bool>,
    about: About,
    down: Local<Word>,
    sum: Vec<Register<Word>>,
    total: Register<Word>,
    step_end: Register<Word>,
    scan_end: Register<Word>,
    _lanes: usize,
    _pairs: usize,
    _delay: usize,
}

impl UpdownCorrelator {
    /// For `lanes` samples per word and a total of `total_bits`.
    pub fn new(lanes: u32, total_bits: u32) -> UpdownCorrelator {
        let pairs = lanes.div_ceil(2);
        let levels = pairs.ilog2();
        // Hits, pairs, adder levels, total.
        let delay = levels + 3;
        UpdownCorrelator {
            i_clk: Input::bit("one word per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_hits: Input::word(lanes, "samples that begin a pulse, bit 0 earliest"),
            i_reference: Input::word(lanes, "1 counts a hit up, 0 down"),
            i_step_end: Input::bit("last clock of a phase step, one clock before its hits"),
            i_scan_end: Input::bit("the step is the scan's last"),
            o_total: Output::word(total_bits, "sum over all hits, modulo its width"),
            o_dump: Output::bit("o_total has just taken in a step's last hits"),
            o_last: Output::bit("the step is the scan's last"),
            about: About::new(
                "updown_correlator",
                "hits counted up or down as the reference says",
            )
            .note(
                "Of two neighbouring samples at most one is a rising edge, so a pair counts -1, \
                 0 or +1 in two bits. The total is never cleared: a step's count is the \
                 difference of two totals, which keeps multiplexers out of the carry chain, and \
                 wrapping does no harm to a difference.",
            )
            .fact(
                "Latency",
                format!("{} clocks from i_hits to o_total", levels + 2),
            )
            .fact("Rate", "one word per clock"),
            down: Local::word(lanes, "hits that count down"),
            sum: (0..2 * pairs - 1)
                .map(|node| sum_register(lanes, pairs, node))
                .collect(),
            total: Register::word(total_bits, 0, "sum over all hits, modulo its width"),
            step_end: Register::word(delay, 0, "i_step_end on its way through the pipeline"),
            scan_end: Register::word(delay, 0, "i_scan_end on its way through the pipeline"),
            _lanes: lanes as usize,
            _pairs: pairs as usize,
            _delay: delay as usize,
        }
    }
}

/// Node `node` of the adder tree: first the pairs, then level by level.
fn sum_register(lanes: u32, pairs: u32, node: u32) -> Register<Word> {
    let (mut level, mut first, mut size) = (0, 0, pairs);
    while node >= first + size {
        first += size;
        size /= 2;
        level += 1;
    }
    let span = (2 << level).min(lanes);
    let low = (node - first) * span;
    let high = low + span - 1;
    Register::word(
        level + 2,
        0,
        format!("signed count of lanes {low} to {high}"),
    )
    .named(format!("sum_{low}_{high}"))
}

impl Logic for UpdownCorrelator {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, total, step_end, scan_end);
        self.down.next = self.i_hits.val() & !self.i_reference.val();
        for j in 0..(self._lanes / 2) {
            dff_setup!(self, i_clk, sum[j]);
            self.sum[j].d.next = bit_cast(false, 2)
                .replace_bit(
                    0,
                    self.i_hits.val().get_bit(2 * j) | self.i_hits.val().get_bit(2 * j + 1),
                )
                .replace_bit(
                    1,
                    self.down.val().get_bit(2 * j) | self.down.val().get_bit(2 * j + 1),
                );
        }
        for _single in 0..(self._lanes % 2) {
            dff_setup!(self, i_clk, sum[0]);
            self.sum[0].d.next = bit_cast(false, 2)
                .replace_bit(0, self.i_hits.val().get_bit(0))
                .replace_bit(1, self.down.val().get_bit(0));
        }
        for p in self._pairs..(self._pairs + 1) {
            for k in 0..(self._pairs - 1) {
                dff_setup!(self, i_clk, sum[p + k]);
                self.sum[p + k].d.next = (signed_cast(self.sum[2 * k].q.val())
                    + signed_cast(self.sum[2 * k + 1].q.val()))
                .into();
            }
            self.total.d.next = self.total.q.val() + signed_cast(self.sum[2 * p - 2].q.val());
        }
        self.step_end.d.next = (self.step_end.q.val() << 1).replace_bit(0, self.i_step_end.val());
        self.scan_end.d.next = (self.scan_end.q.val() << 1).replace_bit(0, self.i_scan_end.val());
        self.o_total.next = self.total.q.val();
        for last in (self._delay - 1)..self._delay {
            self.o_dump.next = self.step_end.q.val().get_bit(last);
            self.o_last.next = self.scan_end.q.val().get_bit(last);
        }
    }
}

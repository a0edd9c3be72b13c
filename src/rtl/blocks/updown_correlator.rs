//! Counts hits up or down as the reference says.

use super::accumulator::Place;
use super::scan_controller::dump_about;
use super::{Accumulator, QuadCounter};
use crate::rtl::front::prelude::*;
use crate::sensor::contract::CountSegments;

/// Counts of one phase step after another, with the sign of the reference.
#[derive(Debug, Clone, LogicBlock)]
pub struct UpdownCorrelator {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Pairs of samples with a hit.
    pub i_hits: Input<Word>,
    /// Where it is the earlier sample of the pair.
    pub i_early: Optional<Input<Word>>,
    /// Reference of each sample.
    pub i_reference: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the count.
    pub i_dump: Input<Word>,
    /// Count of the last step.
    pub o_count: Output<Word>,
    about: About,
    early_reference: Optional<Wiring>,
    late_reference: Optional<Wiring>,
    hit: Register<Word>,
    down: Register<Word>,
    hit_of_quad: Vec<Wiring>,
    down_of_quad: Vec<Wiring>,
    quad: Vec<QuadCounter>,
    sum: Vec<Register<Word>>,
    addend: Local<Word>,
    total: Vec<Accumulator>,
    count: Optional<Wiring>,
    _lanes: usize,
    _quads: usize,
    _one_pair: usize,
    _two_pairs: usize,
    _one_quad: usize,
    _two_quads: usize,
    _segments: usize,
    _segment_bits: usize,
    _top_bits: usize,
}

impl UpdownCorrelator {
    /// For `lanes` samples per word.
    pub fn new(lanes: u32, segments: CountSegments) -> UpdownCorrelator {
        let pairs = lanes.div_ceil(2);
        let quads = if pairs >= 4 { pairs / 4 } else { 0 };
        let levels = pairs.ilog2();
        let addend_bits = levels + 2;
        let whole_bits = segments.bits();
        let lower_bits = segments.lower_bits;
        let sum = |bits: u32| {
            Register::word(
                bits,
                0,
                format!("signed count of samples 0 to {}", lanes - 1),
            )
        };
        let of_pairs = |about: &str| {
            let pairs = pairs as usize;
            Optional::new(lanes > 1, Wiring::new(pairs, (0..pairs).collect(), about))
        };
        let of_quads = |about: &str| -> Vec<Wiring> {
            (0..quads)
                .map(|_| Wiring::new(4, vec![0, 1, 2, 3], about))
                .collect()
        };
        UpdownCorrelator {
            i_clk: Input::bit("one word per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_hits: Input::word(pairs, "pairs of samples with a hit"),
            i_early: Optional::new(
                lanes > 1,
                Input::word(pairs, "the hit is the earlier sample of its pair"),
            ),
            i_reference: Input::word(lanes, "1 counts a hit up, 0 down; bit 0 earliest"),
            i_dump: Input::word(segments.count, dump_about(segments.count)),
            o_count: Output::word(whole_bits, "count of the last step, signed"),
            about: About::new(
                "updown_correlator",
                "hits counted up or down as the reference says",
            )
            .note(
                "A hit adds 1 where the reference is 1, and subtracts 1 where it is 0 (eq. 11): \
                 the sum over a word is the number of hits less twice the number of those that \
                 count down.",
            )
            .fact(
                "Latency",
                format!(
                    "{} clocks from i_hits to o_count",
                    levels + 2 + segments.clocks()
                ),
            ),
            early_reference: of_pairs("reference of each pair's earlier sample"),
            late_reference: of_pairs("reference of each pair's later sample"),
            hit: Register::word(pairs, 0, "pairs with a hit"),
            down: Register::word(pairs, 0, "pairs whose hit counts down"),
            hit_of_quad: of_quads(""),
            down_of_quad: of_quads(""),
            quad: (0..quads).map(|_| QuadCounter::new()).collect(),
            sum: match (pairs, quads) {
                (2, _) | (_, 2) => vec![sum(addend_bits)],
                _ => Vec::new(),
            },
            addend: Local::word(addend_bits, "signed count of one word"),
            total: (0..segments.count)
                .map(|segment| {
                    let place = Place {
                        has_lower: segment > 0,
                        has_higher: segment + 1 < segments.count,
                    };
                    let bits = if place.has_higher {
                        lower_bits
                    } else {
                        segments.top_bits
                    };
                    Accumulator::new(bits, if segment == 0 { addend_bits } else { 2 }, place)
                })
                .collect(),
            count: Optional::new(
                segments.count > 1,
                Wiring::new(
                    whole_bits as usize,
                    (0..whole_bits as usize).collect(),
                    "count of the last step, signed",
                ),
            ),
            _lanes: lanes as usize,
            _quads: quads as usize,
            _one_pair: usize::from(pairs == 1),
            _two_pairs: usize::from(pairs == 2),
            _one_quad: usize::from(quads == 1),
            _two_quads: usize::from(quads == 2),
            _segments: segments.count as usize,
            _segment_bits: lower_bits as usize,
            _top_bits: segments.top_bits as usize,
        }
    }
}

impl Logic for UpdownCorrelator {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, hit, down);
        for _pairs in 0..self.i_early.count() {
            for j in 0..(self._lanes / 2) {
                self.early_reference[0].i[j].next = self.i_reference.val().get_bit(2 * j);
                self.late_reference[0].i[j].next = self.i_reference.val().get_bit(2 * j + 1);
            }
            self.down.d.next = self.i_hits.val()
                & !((self.i_early[0].val() & self.early_reference[0].o.val())
                    | (!self.i_early[0].val() & self.late_reference[0].o.val()));
        }
        for _single in self.i_early.count()..1 {
            self.down.d.next = self.i_hits.val() & !self.i_reference.val();
        }
        self.hit.d.next = self.i_hits.val();
        for q in 0..self._quads {
            self.quad[q].i_clk.next = self.i_clk.val();
            self.quad[q].i_rst.next = self.i_rst.val();
            for j in 0..4 {
                self.hit_of_quad[q].i[j].next = self.hit.q.val().get_bit(4 * q + j);
                self.down_of_quad[q].i[j].next = self.down.q.val().get_bit(4 * q + j);
            }
            self.quad[q].i_hit.next = self.hit_of_quad[q].o.val();
            self.quad[q].i_down.next = self.down_of_quad[q].o.val();
        }
        for _one_quad in 0..self._one_quad {
            self.addend.next = self.quad[0].o_sum.val();
        }
        for _two_quads in 0..self._two_quads {
            dff_setup!(self, i_clk, sum[0]);
            self.sum[0].d.next = (signed_cast(self.quad[0].o_sum.val())
                + signed_cast(self.quad[1].o_sum.val()))
            .into();
            self.addend.next = self.sum[0].q.val();
        }
        for _two_pairs in 0..self._two_pairs {
            dff_setup!(self, i_clk, sum[0]);
            self.sum[0].d.next = bit_cast(false, 3)
                .replace_bit(0, self.hit.q.val().get_bit(0))
                .replace_bit(1, self.down.q.val().get_bit(0))
                .replace_bit(2, self.down.q.val().get_bit(0))
                + bit_cast(false, 3)
                    .replace_bit(0, self.hit.q.val().get_bit(1))
                    .replace_bit(1, self.down.q.val().get_bit(1))
                    .replace_bit(2, self.down.q.val().get_bit(1));
            self.addend.next = self.sum[0].q.val();
        }
        for _one_pair in 0..self._one_pair {
            self.addend.next = bit_cast(false, 2)
                .replace_bit(0, self.hit.q.val().get_bit(0))
                .replace_bit(1, self.down.q.val().get_bit(0));
        }
        self.total[0].i_addend.next = self.addend.val();
        for s in 0..self._segments {
            self.total[s].i_clk.next = self.i_clk.val();
            self.total[s].i_rst.next = self.i_rst.val();
            self.total[s].i_dump.next = self.i_dump.val().get_bit(s);
        }
        for s in 1..self._segments {
            self.total[s].i_addend.next = self.total[s - 1].o_carry[0].val();
            self.total[s].i_borrow[0].next = self.total[s - 1].o_borrow[0].val();
        }
        for _whole in self.count.count()..1 {
            self.o_count.next = self.total[0].o_count.val();
        }
        for _segmented in 0..self.count.count() {
            for w in self._segment_bits..(self._segment_bits + 1) {
                for s in 0..(self._segments - 1) {
                    for b in 0..self._segment_bits {
                        self.count[0].i[w * s + b].next = self.total[s].o_count.val().get_bit(b);
                    }
                }
                for top in (self._segments - 1)..self._segments {
                    for b in 0..self._top_bits {
                        self.count[0].i[w * top + b].next =
                            self.total[top].o_count.val().get_bit(b);
                    }
                }
            }
            self.o_count.next = self.count[0].o.val();
        }
    }
}

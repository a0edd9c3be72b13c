//! Counts hits, whatever their sign.

use super::accumulator::Place;
use super::scan_controller::dump_about;
use super::{Accumulator, QuadCounter};
use crate::rtl::front::prelude::*;
use crate::sensor::contract::{CountSegments, TotalCount};

/// Total counts of one phase step after another: hits up and down together.
#[derive(Debug, Clone, LogicBlock)]
pub struct HitCounter {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Pairs of samples with a hit.
    pub i_hits: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the total.
    pub i_dump: Input<Word>,
    /// Hits of the last step.
    pub o_total: Output<Word>,
    /// There were more than `o_total` can hold.
    pub o_clamped: Optional<Output<bool>>,
    about: About,
    hit: Register<Word>,
    hit_of_quad: Vec<Wiring>,
    quad: Vec<QuadCounter>,
    sum: Vec<Register<Word>>,
    addend: Local<Word>,
    total: Vec<Accumulator>,
    whole: Optional<Wiring>,
    exact: Local<Word>,
    _quads: usize,
    _one_pair: usize,
    _two_pairs: usize,
    _one_quad: usize,
    _two_quads: usize,
    _segments: usize,
    _segment_bits: usize,
    _top_bits: usize,
    _addend_bits: usize,
    _exact_bits: usize,
    _total_bits: usize,
}

impl HitCounter {
    /// For `lanes` samples per word; `count_segments` are the signed count's.
    pub fn new(lanes: u32, plan: TotalCount, count_segments: CountSegments) -> HitCounter {
        let TotalCount {
            exact_bits, bits, ..
        } = plan;
        let segments = count_segments.of_total(plan);
        let pairs = lanes.div_ceil(2);
        let quads = if pairs >= 4 { pairs / 4 } else { 0 };
        let levels = pairs.ilog2();
        // Up to `pairs` hits, and a bit that stays 0, as the total takes a signed
        // addend.
        let addend_bits = levels + 2;
        HitCounter {
            i_clk: Input::bit("one word per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_hits: Input::word(pairs, "pairs of samples with a hit"),
            i_dump: Input::word(segments.count, dump_about(segments.count)),
            o_total: Output::word(bits, "hits of the last step, unsigned"),
            o_clamped: Optional::new(
                plan.saturates(),
                Output::bit("there were more than o_total can hold"),
            ),
            about: describe(levels, plan, segments),
            hit: Register::word(pairs, 0, "pairs with a hit"),
            hit_of_quad: (0..quads)
                .map(|_| Wiring::new(4, vec![0, 1, 2, 3], ""))
                .collect(),
            quad: (0..quads).map(|_| QuadCounter::new()).collect(),
            sum: match (pairs, quads) {
                (2, _) | (_, 2) => {
                    let about = format!("hits in samples 0 to {}", lanes - 1);
                    vec![Register::word(addend_bits, 0, about)]
                }
                _ => Vec::new(),
            },
            addend: Local::word(addend_bits, "hits of one word"),
            total: (0..segments.count)
                .map(|segment| {
                    let place = Place {
                        has_lower: segment > 0,
                        has_higher: segment + 1 < segments.count,
                    };
                    let addend_bits = if segment == 0 { addend_bits } else { 2 };
                    Accumulator::new(segment_bits(segments, segment), addend_bits, place)
                })
                .collect(),
            whole: Optional::new(
                segments.count > 1,
                Wiring::new(
                    exact_bits as usize,
                    (0..exact_bits as usize).collect(),
                    "hits of the last step, segments joined",
                ),
            ),
            exact: Local::word(exact_bits, "hits of the last step, all of them"),
            _quads: quads as usize,
            _one_pair: usize::from(pairs == 1),
            _two_pairs: usize::from(pairs == 2),
            _one_quad: usize::from(quads == 1),
            _two_quads: usize::from(quads == 2),
            _segments: segments.count as usize,
            _segment_bits: segments.lower_bits as usize,
            _top_bits: segments.top_bits as usize,
            _addend_bits: addend_bits as usize,
            _exact_bits: exact_bits as usize,
            _total_bits: bits as usize,
        }
    }
}

/// Bits of a segment of the total.
fn segment_bits(segments: CountSegments, segment: u32) -> u32 {
    if segment + 1 < segments.count {
        segments.lower_bits
    } else {
        segments.top_bits
    }
}

fn describe(levels: u32, plan: TotalCount, segments: CountSegments) -> About {
    let about = About::new("hit_counter", "hits of a phase step, up and down together")
        .note(
            "All steps of a group see the same light, so one counter serves them all. It keeps \
             time with their correlators and takes the same i_dump; its first registers hold what \
             theirs do, and a synthesizer that looks across modules makes one of both.",
        )
        .fact(
            "Latency",
            format!(
                "{} clocks from i_hits to o_total",
                levels + 2 + segments.clocks()
            ),
        );
    if plan.saturates() {
        about.note("A total of more bits than o_total has shows as all ones.")
    } else {
        about
    }
}

impl Logic for HitCounter {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, hit);
        self.hit.d.next = self.i_hits.val();
        for q in 0..self._quads {
            self.quad[q].i_clk.next = self.i_clk.val();
            self.quad[q].i_rst.next = self.i_rst.val();
            for j in 0..4 {
                self.hit_of_quad[q].i[j].next = self.hit.q.val().get_bit(4 * q + j);
            }
            self.quad[q].i_hit.next = self.hit_of_quad[q].o.val();
            self.quad[q].i_down.next = bit_cast(false, 4);
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
            self.sum[0].d.next = bit_cast(self.hit.q.val().get_bit(0), self._addend_bits)
                + bit_cast(self.hit.q.val().get_bit(1), self._addend_bits);
            self.addend.next = self.sum[0].q.val();
        }
        for _one_pair in 0..self._one_pair {
            self.addend.next = bit_cast(self.hit.q.val(), self._addend_bits);
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
        for _single in self.whole.count()..1 {
            self.exact.next = self.total[0].o_count.val();
        }
        for _segmented in 0..self.whole.count() {
            for w in self._segment_bits..(self._segment_bits + 1) {
                for s in 0..(self._segments - 1) {
                    for b in 0..self._segment_bits {
                        self.whole[0].i[w * s + b].next = self.total[s].o_count.val().get_bit(b);
                    }
                }
                for top in (self._segments - 1)..self._segments {
                    for b in 0..self._top_bits {
                        self.whole[0].i[w * top + b].next =
                            self.total[top].o_count.val().get_bit(b);
                    }
                }
            }
            self.exact.next = self.whole[0].o.val();
        }
        for _whole in self.o_clamped.count()..1 {
            self.o_total.next = self.exact.val();
        }
        for _clamped in 0..self.o_clamped.count() {
            self.o_clamped[0].next = bit_cast(
                bit_cast(self.exact.val(), self._total_bits),
                self._exact_bits,
            ) != self.exact.val();
            self.o_total.next =
                bit_cast(self.exact.val(), self._total_bits) | signed_cast(self.o_clamped[0].val());
        }
    }
}

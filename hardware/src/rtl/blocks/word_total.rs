//! The hits of a word, added to a running total, and what that grew by in a phase step.
//!
//! Pairs of samples are counted in fours; a total too wide for one chain of carries is in segments.

use super::{Accumulator, QuadCounter, SegmentedTotal};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

/// Registers of the hits, the adders behind them, and the total.
#[block]
pub struct WordTotal {
    lanes: usize,
    /// Of the total; none without one.
    segments: Option<CountSegments>,
    /// Whether hits count down, too.
    is_signed: bool,
    #[set(lanes.div_ceil(2))]
    pairs: usize,
    #[set(pairs / 4)]
    quads: usize,
    #[set(pairs.ilog2() as usize)]
    levels: usize,
    /// Up to `pairs` hits, and a sign, which stays 0 where none counts down.
    #[set(levels + 2)]
    addend_bits: usize,
    /// pairs with a hit
    #[width(pairs)]
    pub(super) hit: Register<Word>,
    /// pairs whose hit counts down
    #[when(is_signed)]
    #[width(pairs)]
    pub(super) down: Optional<Register<Word>>,
    #[each(_quad in 0..quads)]
    #[is(QuadCounter::new())]
    quad: Vec<QuadCounter>,
    /// {if is_signed { "signed count of" } else { "hits in" }} samples 0 to {lanes - 1}
    #[when(pairs == 2 || quads == 2)]
    #[width(addend_bits)]
    sum: Optional<Register<Word>>,
    /// {if is_signed { "signed count of one word" } else { "hits of one word" }}
    #[width(addend_bits)]
    pub(super) addend: Local<Word>,
    #[each(whole in segments.filter(|segments| segments.count == 1).iter())]
    #[is(Accumulator::new(whole.top_bits as usize, addend_bits, false, false))]
    total: Vec<Accumulator>,
    #[each(segments in segments.filter(|segments| segments.count > 1).iter())]
    #[is(SegmentedTotal::new(*segments, addend_bits))]
    segmented: Vec<SegmentedTotal>,
    /// A step's last hits are in; one bit for each segment.
    #[when(segments.is_some())]
    #[width(segments.map_or(1, |segments| segments.count))]
    pub(super) dump: Optional<Local<Word>>,
    /// hits of the last step, all of them
    #[when(segments.is_some())]
    #[width(segments.map_or(1, |segments| segments.bits()))]
    pub(super) exact: Optional<Local<Word>>,
}

impl WordTotal {
    /// Clocks from hits to their total's growth, for words of so many samples; without a total to the
    /// hits of a word.
    pub(super) fn latency_clocks(lanes: usize, segments: Option<CountSegments>) -> usize {
        let of_total = segments.map_or(0, |segments| 1 + segments.clocks() as usize);
        lanes.div_ceil(2).ilog2() as usize + 1 + of_total
    }
}

#[kernel]
impl WordTotal {
    /// Counts the hits that are in the registers.
    pub(super) fn count(&mut self) {
        self.count_word();
        for t in 0..self.total.len() {
            self.total[t].i_addend.next = self.addend.val();
            self.total[t].i_dump.next = self.dump.val().get_bit(0);
            self.exact.next = self.total[t].o_count.val();
        }
        for t in 0..self.segmented.len() {
            self.segmented[t].i_addend.next = self.addend.val();
            self.segmented[t].i_dump.next = self.dump.val();
            self.exact.next = self.segmented[t].o_count.val();
        }
    }

    /// The hits of a word: those that count up less those that count down.
    fn count_word(&mut self) {
        for q in 0..self.quads {
            self.quad[q].i_hit.next = self.hit.val().slice(4 * q, 4);
            self.quad[q].i_down.next =
                if self.is_signed { self.down.val().slice(4 * q, 4) } else { bit_cast(false, 4) };
        }
        if self.quads == 1 {
            self.addend.next = self.quad[0].o_sum.val();
        } else if self.quads == 2 {
            self.sum.next = (signed_cast(self.quad[0].o_sum.val())
                + signed_cast(self.quad[1].o_sum.val()))
            .into();
            self.addend.next = self.sum.val();
        } else if self.is_signed {
            self.count_pairs();
        } else if self.pairs == 2 {
            self.sum.next = bit_cast(self.hit.val().get_bit(0), self.addend_bits)
                + bit_cast(self.hit.val().get_bit(1), self.addend_bits);
            self.addend.next = self.sum.val();
        } else {
            self.addend.next = bit_cast(self.hit.val(), self.addend_bits);
        }
    }

    /// One pair or two, each 1, 0 or -1.
    fn count_pairs(&mut self) {
        if self.pairs == 2 {
            self.sum.next = bit_cast(false, 3)
                .replace_bit(0, self.hit.val().get_bit(0))
                .replace_bit(1, self.down.val().get_bit(0))
                .replace_bit(2, self.down.val().get_bit(0))
                + bit_cast(false, 3)
                    .replace_bit(0, self.hit.val().get_bit(1))
                    .replace_bit(1, self.down.val().get_bit(1))
                    .replace_bit(2, self.down.val().get_bit(1));
            self.addend.next = self.sum.val();
        } else {
            self.addend.next = bit_cast(false, 2)
                .replace_bit(0, self.hit.val().get_bit(0))
                .replace_bit(1, self.down.val().get_bit(0));
        }
    }
}

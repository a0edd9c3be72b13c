//! The hits of a word, added to a running total, and what that grew by in a phase step.
//!
//! Pairs of samples are counted in fours; a total too wide for one chain of carries is in segments.

use super::{Accumulator, QuadCounter, SegmentedTotal};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

/// Registers of the hits, the adders behind them, and the total.
#[block]
pub struct WordTotal {
    /// Of samples, of each of which one may be a hit.
    pairs: usize,
    /// Of the total; none without one.
    segments: Option<CountSegments>,
    /// Whether hits count down, too.
    is_signed: bool,
    /// Fours of them, the last of which may have a pair less.
    #[set(if pairs > 2 { pairs.div_ceil(4) } else { 0 })]
    quads: usize,
    /// Up to `pairs` hits, and a sign, which stays 0 where none counts down.
    #[set(pairs.ilog2() as usize + 2)]
    addend_bits: usize,
    /// How the fours are added up, or two pairs.
    #[set(Sums::of(pairs, addend_bits))]
    sums: Sums,
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
    /// {if is_signed { "signed count" } else { "hits" }} of {if pairs == 2 { "two pairs" } else { "some pairs" }}
    #[each(one in sums.list.iter())]
    #[width(one.bits)]
    sum: Vec<Register<Word>>,
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
    /// Clocks from hits to their total's growth, for words of so many pairs; without a total to the
    /// hits of a word.
    pub(super) fn latency_clocks(pairs: usize, segments: Option<CountSegments>) -> usize {
        let of_total = segments.map_or(0, |segments| 1 + segments.clocks() as usize);
        pairs.next_power_of_two().ilog2() as usize + 1 + of_total
    }
}

/// A tree of adders, each level of which has registers.
#[derive(Debug, Clone, Default)]
struct Sums {
    list: Vec<Sum>,
}

/// Two fours of pairs, or two sums of the level before; or one that waits for the next level.
#[derive(Debug, Clone, Copy)]
struct Sum {
    of_fours: bool,
    first: usize,
    second: Option<usize>,
    bits: usize,
}

impl Sums {
    fn of(pairs: usize, addend_bits: usize) -> Sums {
        let mut list = Vec::new();
        if pairs == 2 {
            list.push(Sum { of_fours: false, first: 0, second: Some(1), bits: addend_bits });
        }
        let (mut below, mut bits) = (0..pairs.div_ceil(4), 4);
        while below.len() > 1 {
            let (of_fours, start) = (list.is_empty(), list.len());
            bits = (bits + 1).min(addend_bits);
            list.extend(below.clone().step_by(2).map(|first| {
                let second = Some(first + 1).filter(|second| below.contains(second));
                Sum { of_fours, first, second, bits }
            }));
            below = start..list.len();
        }
        Sums { list }
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
            self.count_four(q);
        }
        if self.quads == 1 {
            self.addend.next = bit_cast(self.quad[0].o_sum.val(), self.addend_bits);
        } else if self.quads > 1 {
            let last = self.sum.len() - 1;
            for s in 0..self.sum.len() {
                self.add_up(s);
            }
            self.addend.next = self.sum[last].val();
        } else if self.is_signed {
            self.count_pairs();
        } else if self.pairs == 2 {
            self.sum[0].next = bit_cast(self.hit.val().get_bit(0), self.addend_bits)
                + bit_cast(self.hit.val().get_bit(1), self.addend_bits);
            self.addend.next = self.sum[0].val();
        } else {
            self.addend.next = bit_cast(self.hit.val(), self.addend_bits);
        }
    }

    /// Four pairs, or what is left of them.
    fn count_four(&mut self, q: usize) {
        let pairs = (self.pairs - 4 * q).min(4);
        self.quad[q].i_hit.next = bit_cast(self.hit.val().slice(4 * q, pairs), 4);
        self.quad[q].i_down.next = if self.is_signed {
            bit_cast(self.down.val().slice(4 * q, pairs), 4)
        } else {
            bit_cast(false, 4)
        };
    }

    fn add_up(&mut self, s: usize) {
        let first = self.sums.list[s].first;
        let second = self.sums.list[s].second.unwrap_or_default();
        if self.sums.list[s].of_fours {
            if self.sums.list[s].second.is_some() {
                self.sum[s].next = (signed_cast(self.quad[first].o_sum.val())
                    + signed_cast(self.quad[second].o_sum.val()))
                .into();
            } else {
                self.sum[s].next = signed_cast(self.quad[first].o_sum.val()).into();
            }
        } else if self.sums.list[s].second.is_some() {
            self.sum[s].next =
                (signed_cast(self.sum[first].val()) + signed_cast(self.sum[second].val())).into();
        } else {
            self.sum[s].next = signed_cast(self.sum[first].val()).into();
        }
    }

    /// One pair or two, each 1, 0 or -1.
    fn count_pairs(&mut self) {
        if self.pairs == 2 {
            self.sum[0].next = bit_cast(false, 3)
                .replace_bit(0, self.hit.val().get_bit(0))
                .replace_bit(1, self.down.val().get_bit(0))
                .replace_bit(2, self.down.val().get_bit(0))
                + bit_cast(false, 3)
                    .replace_bit(0, self.hit.val().get_bit(1))
                    .replace_bit(1, self.down.val().get_bit(1))
                    .replace_bit(2, self.down.val().get_bit(1));
            self.addend.next = self.sum[0].val();
        } else {
            self.addend.next = bit_cast(false, 2)
                .replace_bit(0, self.hit.val().get_bit(0))
                .replace_bit(1, self.down.val().get_bit(0));
        }
    }
}

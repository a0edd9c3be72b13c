//! Counts hits up or down as the reference says.
//!
//! | port | |
//! |---|---|
//! | `i_hits`, `i_early` | hits of a word, by pairs of samples |
//! | `i_reference` | reference of each sample |
//! | `i_dump` | the step's last hits are in, a bit for each segment |
//! | `o_count` | count of the last step, signed |
//!
//! Latency log2(pairs) + 2 clocks and those of the total, from `i_hits` to `o_count`. Counting
//! pairs in place of samples halves the adders: at most one of two neighbours is a hit.
//!
//! Cost (ECP5, docs/resources.md): 4 LUTs, 8 flip-flops beside quads and total.

use super::scan_controller::dump_about;
use super::{Accumulator, QuadCounter, SegmentedTotal};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

/// Counts of one phase step after another, with the sign of the reference.
#[block(About::new("updown_correlator", "hits counted up or down as the reference says")
    .note(
        "A hit adds 1 where the reference is 1, and subtracts 1 where it is 0 (eq. 11): the sum \
         over a word is the number of hits less twice the number of those that count down.",
    )
    .fact("Latency", match segments {
        Some(segments) => format!(
            "{} clocks from i_hits to o_count",
            levels + 2 + segments.clocks() as usize
        ),
        None => format!("{} clocks from i_hits to o_addend", levels + 1),
    }))]
pub struct UpdownCorrelator {
    lanes: usize,
    /// Of the total; none where the signed counts of words are all that is asked.
    segments: Option<CountSegments>,
    #[set(lanes.div_ceil(2))]
    pairs: usize,
    /// Whether there is a pair, and not a single sample.
    #[set(lanes > 1)]
    has_pairs: bool,
    #[set(pairs / 4)]
    quads: usize,
    /// Whether two sums of a word are added.
    #[set(pairs == 2 || quads == 2)]
    adds: bool,
    #[set(pairs.ilog2() as usize)]
    levels: usize,
    #[set(levels + 2)]
    addend_bits: usize,
    /// Segments of the total; 0 without one.
    #[set(segments.map_or(0, |segments| segments.count))]
    totals: u32,
    /// pairs of samples with a hit
    #[width(pairs)]
    pub i_hits: Input<Word>,
    /// the hit is the earlier sample of its pair
    #[when(has_pairs)]
    #[width(pairs)]
    pub i_early: Optional<Input<Word>>,
    /// 1 counts a hit up, 0 down; bit 0 earliest
    #[width(lanes)]
    pub i_reference: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the count.
    #[when(totals > 0)]
    #[about(dump_about(totals))]
    #[width(totals)]
    pub i_dump: Optional<Input<Word>>,
    /// count of the last step, signed
    #[when(totals > 0)]
    #[width(segments.map_or(1, |segments| segments.bits()))]
    pub o_count: Optional<Output<Word>>,
    /// signed count of a word
    #[when(totals == 0)]
    #[width(addend_bits)]
    pub o_addend: Optional<Output<Word>>,
    /// reference of each pair's earlier sample
    #[when(has_pairs)]
    #[width(pairs)]
    early_reference: Optional<Local<Word>>,
    /// reference of each pair's later sample
    #[when(has_pairs)]
    #[width(pairs)]
    late_reference: Optional<Local<Word>>,
    /// pairs with a hit
    #[width(pairs)]
    hit: Register<Word>,
    /// pairs whose hit counts down
    #[width(pairs)]
    down: Register<Word>,
    #[each(_quad in 0..quads)]
    #[is(QuadCounter::new())]
    quad: Vec<QuadCounter>,
    #[when(adds)]
    #[about(format!("signed count of samples 0 to {}", lanes - 1))]
    #[width(addend_bits)]
    sum: Optional<Register<Word>>,
    /// signed count of one word
    #[width(addend_bits)]
    addend: Local<Word>,
    #[each(whole in segments.filter(|segments| segments.count == 1).iter())]
    #[is(Accumulator::new(whole.top_bits as usize, addend_bits, false, false))]
    total: Vec<Accumulator>,
    #[each(segments in segments.filter(|segments| segments.count > 1).iter())]
    #[is(SegmentedTotal::new(*segments, addend_bits))]
    segmented: Vec<SegmentedTotal>,
}

#[kernel]
impl Logic for UpdownCorrelator {
    fn update(&mut self) {
        if self.i_early.is_present() {
            self.early_reference.next =
                gather(self.pairs, |pair| self.i_reference.val().get_bit(2 * pair));
            self.late_reference.next =
                gather(self.pairs, |pair| self.i_reference.val().get_bit(2 * pair + 1));
            self.down.next = self.i_hits.val()
                & !((self.i_early.val() & self.early_reference.val())
                    | (!self.i_early.val() & self.late_reference.val()));
        } else {
            self.down.next = self.i_hits.val() & !self.i_reference.val();
        }
        self.hit.next = self.i_hits.val();
        self.count_word();
        if self.o_addend.is_present() {
            self.o_addend.next = self.addend.val();
        }
        for t in 0..self.total.len() {
            self.total[t].i_addend.next = self.addend.val();
            self.total[t].i_dump.next = self.i_dump.val().get_bit(0);
            self.o_count.next = self.total[t].o_count.val();
        }
        for t in 0..self.segmented.len() {
            self.segmented[t].i_addend.next = self.addend.val();
            self.segmented[t].i_dump.next = self.i_dump.val();
            self.o_count.next = self.segmented[t].o_count.val();
        }
    }

    /// The signed count of a word: hits that count up less hits that count down.
    fn count_word(&mut self) {
        for q in 0..self.quads {
            self.quad[q].i_hit.next = self.hit.val().slice(4 * q, 4);
            self.quad[q].i_down.next = self.down.val().slice(4 * q, 4);
        }
        if self.quads == 1 {
            self.addend.next = self.quad[0].o_sum.val();
        } else if self.quads == 2 {
            self.sum.next = (signed_cast(self.quad[0].o_sum.val())
                + signed_cast(self.quad[1].o_sum.val()))
            .into();
            self.addend.next = self.sum.val();
        } else if self.pairs == 2 {
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

//! Counts hits, whatever their sign.
//!
//! | port | |
//! |---|---|
//! | `i_hits` | hits of a word, by pairs of samples |
//! | `i_dump` | the step's last hits are in, a bit for each segment |
//! | `o_total`, `o_clamped` | hits of the last step; there were more |
//!
//! Latency as the correlators', whose dump it takes. One for all steps of a group, which see the
//! same light, in place of one for each.
//!
//! Cost (ECP5, docs/resources.md): 32 LUTs, 66 flip-flops.

use super::scan_controller::dump_about;
use super::{Accumulator, QuadCounter, SegmentedTotal};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::{CountSegments, TotalCount};

/// Total counts of one phase step after another: hits up and down together.
#[block(About::new("hit_counter", "hits of a phase step, up and down together")
    .note(
        "All steps of a group see the same light, so one counter serves them all. It keeps \
         time with their correlators and takes the same i_dump; its first registers hold what \
         theirs do, and a synthesizer that looks across modules makes one of both.",
    )
    .note_if(sent.saturates(), "A total of more bits than o_total has shows as all ones.")
    .fact("Latency", format!("{} clocks from i_hits to o_total", levels + 2 + segments.clocks() as usize)))]
pub struct HitCounter {
    lanes: usize,
    sent: TotalCount,
    /// of the signed count
    count_segments: CountSegments,
    #[set(count_segments.of_total(sent))]
    segments: CountSegments,
    #[set(lanes.div_ceil(2))]
    pairs: usize,
    #[set(pairs / 4)]
    quads: usize,
    #[set(pairs.ilog2() as usize)]
    levels: usize,
    /// Up to `pairs` hits, and a bit that stays 0, as the total takes a signed
    /// addend.
    #[set(levels + 2)]
    addend_bits: usize,
    #[set(sent.exact_bits as usize)]
    exact_bits: usize,
    #[set(sent.bits as usize)]
    total_bits: usize,
    /// pairs of samples with a hit
    #[width(pairs)]
    pub i_hits: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the total.
    #[about(dump_about(segments.count))]
    #[width(segments.count)]
    pub i_dump: Input<Word>,
    /// hits of the last step, unsigned
    #[width(sent.bits)]
    pub o_total: Output<Word>,
    /// there were more than o_total can hold
    #[when(sent.saturates())]
    pub o_clamped: Optional<Output<bool>>,
    /// pairs with a hit
    #[width(pairs)]
    hit: Register<Word>,
    #[each(_quad in 0..quads)]
    #[is(QuadCounter::new())]
    quad: Vec<QuadCounter>,
    #[when(pairs == 2 || quads == 2)]
    #[about(format!("hits in samples 0 to {}", lanes - 1))]
    #[width(addend_bits)]
    sum: Optional<Register<Word>>,
    /// hits of one word
    #[width(addend_bits)]
    addend: Local<Word>,
    #[when(segments.count == 1)]
    #[is(Accumulator::new(segments.top_bits as usize, addend_bits, false, false))]
    total: Optional<Accumulator>,
    #[each(_total in 0..usize::from(segments.count > 1))]
    #[is(SegmentedTotal::new(segments, addend_bits))]
    segmented: Vec<SegmentedTotal>,
    /// hits of the last step, all of them
    #[width(exact_bits)]
    exact: Local<Word>,
}

#[kernel]
impl Logic for HitCounter {
    fn update(&mut self) {
        self.hit.next = self.i_hits.val();
        self.count_word();
        if self.total.is_present() {
            self.total.i_addend.next = self.addend.val();
            self.total.i_dump.next = self.i_dump.val().get_bit(0);
            self.exact.next = self.total.o_count.val();
        }
        for t in 0..self.segmented.len() {
            self.segmented[t].i_addend.next = self.addend.val();
            self.segmented[t].i_dump.next = self.i_dump.val();
            self.exact.next = self.segmented[t].o_count.val();
        }
        if self.o_clamped.is_present() {
            let bits = self.total_bits;
            self.o_clamped.next =
                bit_cast(bit_cast(self.exact.val(), bits), self.exact_bits) != self.exact.val();
            self.o_total.next =
                bit_cast(self.exact.val(), bits) | signed_cast(self.o_clamped.val());
        } else {
            self.o_total.next = self.exact.val();
        }
    }

    /// The hits of a word.
    fn count_word(&mut self) {
        for q in 0..self.quads {
            self.quad[q].i_hit.next = self.hit.val().slice(4 * q, 4);
            self.quad[q].i_down.next = bit_cast(false, 4);
        }
        if self.quads == 1 {
            self.addend.next = self.quad[0].o_sum.val();
        } else if self.quads == 2 {
            self.sum.next = (signed_cast(self.quad[0].o_sum.val())
                + signed_cast(self.quad[1].o_sum.val()))
            .into();
            self.addend.next = self.sum.val();
        } else if self.pairs == 2 {
            self.sum.next = bit_cast(self.hit.val().get_bit(0), self.addend_bits)
                + bit_cast(self.hit.val().get_bit(1), self.addend_bits);
            self.addend.next = self.sum.val();
        } else {
            self.addend.next = bit_cast(self.hit.val(), self.addend_bits);
        }
    }
}

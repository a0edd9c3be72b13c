//! Counts hits, whatever their sign: one for all steps of a group, in place of one for each.
//!
//! Cost (ECP5, docs/resources.md): 32 LUTs, 66 flip-flops.

use super::WordTotal;
use super::step_ends::dump_about;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::{CountSegments, TotalCount};

#[block(hit_counter)]
/// hits of a phase step, up and down together
///
/// All steps of a group see the same light, so one counter serves them all. It keeps time with their
/// correlators and takes the same i_dump; its first registers hold what theirs do, and a synthesizer
/// that looks across modules makes one of both.
#[when(sent.saturates())]
/// A total of more bits than o_total has shows as all ones.
///
/// - Latency: {WordTotal::latency_clocks(pairs, Some(segments))} clocks from i_hits to o_total
pub struct HitCounter {
    /// Of samples, of each of which one may be a hit.
    pairs: usize,
    sent: TotalCount,
    /// of the signed count
    count_segments: CountSegments,
    #[set(count_segments.of_total(sent))]
    segments: CountSegments,
    #[set(sent.exact_bits as usize)]
    exact_bits: usize,
    #[set(sent.bits as usize)]
    total_bits: usize,
    /// pairs of samples with a hit
    #[width(pairs)]
    pub i_hits: Input<Word>,
    /// {dump_about(segments.count)}
    #[width(segments.count)]
    pub i_dump: Input<Word>,
    /// hits of the last step, unsigned
    #[width(sent.bits)]
    pub o_total: Output<Word>,
    /// there were more than o_total can hold
    #[when(sent.saturates())]
    pub o_clamped: Optional<Output<bool>>,
    /// registers of the hits, and what they add up to
    #[is(WordTotal::new(pairs, Some(segments), false))]
    words: WordTotal,
}

#[kernel]
impl Logic for HitCounter {
    fn update(&mut self) {
        self.words.hit.next = self.i_hits.val();
        self.words.dump.next = self.i_dump.val();
        self.words.count();
        if self.o_clamped.is_present() {
            let bits = self.total_bits;
            self.o_clamped.next = bit_cast(bit_cast(self.words.exact.val(), bits), self.exact_bits)
                != self.words.exact.val();
            self.o_total.next =
                bit_cast(self.words.exact.val(), bits) | signed_cast(self.o_clamped.val());
        } else {
            self.o_total.next = self.words.exact.val();
        }
    }
}

//! Counts hits up or down as the reference says.
//!
//! Counting pairs in place of samples halves the adders: at most one of two neighbours is a hit.
//!
//! Cost (ECP5, docs/resources.md): 4 LUTs, 8 flip-flops beside quads and total.

use super::WordTotal;
use super::step_ends::dump_about;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

#[block(updown_correlator)]
/// hits counted up or down as the reference says
///
/// A hit adds 1 where the reference is 1, and subtracts 1 where it is 0 (eq. 11): the sum over a word is
/// the number of hits less twice the number of those that count down.
#[when(totals > 0)]
/// - Latency: {WordTotal::latency_clocks(pairs, segments)} clocks from i_hits to o_count
#[when(totals == 0)]
/// - Latency: {WordTotal::latency_clocks(pairs, segments)} clocks from i_hits to o_addend
pub struct UpdownCorrelator {
    lanes: usize,
    /// Of the samples of a word, or of the words of all cells whose edges count.
    pairs: usize,
    /// Of the total; none where the signed counts of words are all that is asked.
    segments: Option<CountSegments>,
    /// How many there are.
    #[set(segments.map_or(0, |segments| segments.count))]
    totals: u32,
    /// Whether there is a pair, and not a single sample.
    #[set(lanes > 1)]
    has_pairs: bool,
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
    /// {dump_about(totals)}
    #[when(totals > 0)]
    #[width(totals)]
    pub i_dump: Optional<Input<Word>>,
    /// count of the last step, signed
    #[when(totals > 0)]
    #[width(segments.map_or(1, |segments| segments.bits()))]
    pub o_count: Optional<Output<Word>>,
    /// signed count of a word
    #[when(totals == 0)]
    #[width(pairs.ilog2() + 2)]
    pub o_addend: Optional<Output<Word>>,
    // The reference of each pair's earlier sample, and of its later one.
    #[when(has_pairs || pairs > 1)]
    #[width(pairs)]
    early_reference: Optional<Local<Word>>,
    #[when(has_pairs)]
    #[width(pairs)]
    late_reference: Optional<Local<Word>>,
    /// registers of the hits, and what they add up to
    #[is(WordTotal::new(pairs, segments, true))]
    words: WordTotal,
}

#[kernel]
impl Logic for UpdownCorrelator {
    fn update(&mut self) {
        if self.early_reference.is_present() {
            self.early_reference.next =
                gather(self.pairs, |pair| self.i_reference.val().get_bit(2 * pair % self.lanes));
        }
        if self.i_early.is_present() {
            self.late_reference.next = gather(self.pairs, |pair| {
                self.i_reference.val().get_bit(2 * pair % self.lanes + 1)
            });
            self.words.down.next = self.i_hits.val()
                & !((self.i_early.val() & self.early_reference.val())
                    | (!self.i_early.val() & self.late_reference.val()));
        } else if self.early_reference.is_present() {
            self.words.down.next = self.i_hits.val() & !self.early_reference.val();
        } else {
            self.words.down.next = self.i_hits.val() & !self.i_reference.val();
        }
        self.words.hit.next = self.i_hits.val();
        if self.i_dump.is_present() {
            self.words.dump.next = self.i_dump.val();
        }
        self.words.count();
        if self.o_count.is_present() {
            self.o_count.next = self.words.exact.val();
        } else {
            self.o_addend.next = self.words.addend.val();
        }
    }
}

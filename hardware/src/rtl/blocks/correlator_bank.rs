//! Correlators of some phase steps that share their light.
//!
//! Cost (ECP5, docs/resources.md): 217 LUTs, 241 flip-flops for three steps more at once.

use super::UpdownCorrelator;
use super::step_ends::dump_about;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

#[block(correlator_bank)]
/// correlators of some phase steps that share their light
///
/// Each step takes the reference a sample later than the step before it.
pub struct CorrelatorBank {
    lanes: usize,
    pairs: usize,
    segments: CountSegments,
    /// phase steps
    #[size(1..=usize::MAX)]
    steps: usize,
    /// pairs of samples with a hit
    #[width(pairs)]
    pub i_hits: Input<Word>,
    /// the hit is the earlier sample of its pair
    #[when(lanes > 1)]
    #[width(pairs)]
    pub i_early: Optional<Input<Word>>,
    /// reference of each sample; the last step's lowest
    #[width(lanes + steps - 1)]
    pub i_window: Input<Word>,
    /// {dump_about(segments.count)}
    #[width(segments.count)]
    pub i_dump: Input<Word>,
    /// counts of the steps, signed, step 0 lowest
    #[each(_step in 0..steps)]
    #[width(segments.bits())]
    pub o_count: Vec<Output<Word>>,
    #[each(_step in 0..steps)]
    #[is(UpdownCorrelator::new(lanes, pairs, Some(segments)))]
    correlator: Vec<UpdownCorrelator>,
}

#[kernel]
impl Logic for CorrelatorBank {
    fn update(&mut self) {
        let last = self.steps - 1;
        for q in 0..self.steps {
            connect! { self.correlator[q] from self: i_hits, i_early }
            self.correlator[q].i_reference.next = self.i_window.val().slice(last - q, self.lanes);
            self.correlator[q].i_dump.next = self.i_dump.val();
            self.o_count[q].next = self.correlator[q].o_count.val();
        }
    }
}

//! Correlators of some phase steps that share their light.
//!
//! | port | |
//! |---|---|
//! | `i_hits`, `i_early` | hits of a word, by pairs of samples |
//! | `i_window` | reference of each sample, for all of the bank's steps |
//! | `i_dump` | the step's last hits are in, a bit for each segment |
//! | `o_count` | counts of the bank's steps |
//!
//! Latency as the correlators'.
//!
//! Cost (ECP5, docs/resources.md): 217 LUTs, 241 flip-flops for three steps more at once.

use super::step_ends::dump_about;
use super::{UpdownCorrelator, first_of};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

/// Correlates one detector's hits with several delays of its reference.
#[block(About::new("correlator_bank", "correlators of some phase steps that share their light")
        .size(("STEPS", "phase steps"), steps, 1..=usize::MAX, move |steps| {
            CorrelatorBank::new(lanes, segments, steps)
        })
        .note("Each step takes the reference a sample later than the step before it."))]
pub struct CorrelatorBank {
    lanes: usize,
    segments: CountSegments,
    steps: usize,
    /// pairs of samples with a hit
    #[width(lanes.div_ceil(2))]
    pub i_hits: Input<Word>,
    /// the hit is the earlier sample of its pair
    #[when(lanes > 1)]
    #[width(lanes.div_ceil(2))]
    pub i_early: Optional<Input<Word>>,
    /// reference of each sample; the last step's lowest
    #[width(lanes + steps - 1)]
    pub i_window: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the count.
    #[about(dump_about(segments.count))]
    #[width(segments.count)]
    pub i_dump: Input<Word>,
    /// Counts of the bank's steps.
    #[each(step in 0..steps)]
    #[about(first_of(step, "counts of the steps, signed, step 0 lowest"))]
    #[width(segments.bits())]
    pub o_count: Vec<Output<Word>>,
    #[each(_step in 0..steps)]
    #[is(UpdownCorrelator::new(lanes, Some(segments)))]
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

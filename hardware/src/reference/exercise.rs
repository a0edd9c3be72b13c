//! What the outputs have shown so far: how much a comparison of them is worth.

use super::coverage::Covered;
use crate::scene::DetectorIndex;

/// What has come to the outputs since the model was made, resets included.
///
/// A hit that is counted shows nowhere until its phase step has ended and its
/// count stands on the stream: so only these are here.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Exercise {
    /// For each detector.
    pub detectors: Vec<DetectorExercise>,
    /// Phase steps whose integration ended.
    pub phase_steps: u64,
    /// Results that the receiver took.
    pub results_taken: u64,
    /// Results that the receiver left standing for a clock or more.
    pub results_held: u64,
    /// Groups of results that were lost, because one before them still stood.
    pub groups_lost: u64,
    /// Groups of results of which one was saturated.
    pub groups_saturated: u64,
    /// Last results of a scan.
    pub scan_ends: u64,
    /// Resets, that at the start included.
    pub resets: u64,
    /// Cover points that have shown.
    pub covered: Covered,
}

/// What has come to the outputs of one detector.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DetectorExercise {
    /// Results that stood on the stream.
    pub results: u64,
    /// Hits that they counted up, each once for every phase step that saw it.
    pub hits_up: u64,
    /// Hits that they counted down.
    pub hits_down: u64,
}

/// What a result counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counted {
    pub(super) detector: DetectorIndex,
    pub(super) up: u64,
    pub(super) down: u64,
}

impl Counted {
    /// Of a detector's `total` hits whose signs add up to `sum`.
    pub(super) fn new(detector: DetectorIndex, sum: i64, total: u64) -> Counted {
        let up = total.saturating_add_signed(sum) / 2;
        Counted { detector, up, down: total - up }
    }
}

impl Exercise {
    pub(super) fn of(detectors: usize) -> Exercise {
        Exercise { detectors: vec![DetectorExercise::default(); detectors], ..Exercise::default() }
    }

    /// A result stands on the stream.
    pub(super) fn shows(&mut self, counted: Counted, is_scan_end: bool) {
        let detector = &mut self.detectors[counted.detector];
        detector.results += 1;
        detector.hits_up += counted.up;
        detector.hits_down += counted.down;
        self.scan_ends += u64::from(is_scan_end);
    }
}

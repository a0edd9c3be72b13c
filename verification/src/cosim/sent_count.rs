//! A phase step's counts as they were sent.

use crate::photons::StepCount;
use crate::scene::DetectorIndex;

/// A phase step's counts as the Verilog sent them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SentCount {
    /// Number of the scan since reset.
    pub scan: u64,
    /// The detector.
    pub detector: DetectorIndex,
    /// Number of the step within the scan, 0..steps.
    pub step: u64,
    /// The signed count.
    pub signed: i64,
    /// The total count; none of hardware that sends none.
    pub total: Option<u64>,
    /// Of a histogram, whose bins are as many as there are phase steps, what the bin of
    /// this number holds.
    pub bin: Option<u64>,
}

impl SentCount {
    /// As the estimators take it. Without a total its place is empty: of such
    /// hardware only the signed counts are to be used.
    pub fn step_count(&self) -> StepCount {
        StepCount { signed: self.signed, total: self.total.unwrap_or(0) }
    }
}

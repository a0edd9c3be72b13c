//! Whether the hardware sends total counts: the estimator needs them or does not.

use super::{Architecture, EstimatorKind, Scene};

/// The model estimator was asked for, of hardware that sends no total counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the estimator \"model\" needs the total counts, which total_counts = false leaves out of \
     the hardware; remove that key, or estimate with \"fft\""
)]
pub struct TotalsMissing;

impl Scene {
    /// Whether the hardware sends total counts beside the signed ones: as
    /// `hardware.total_counts` says, else with the estimator that needs them. A
    /// histogram always does: its sum is the total.
    pub fn sends_total_counts(&self) -> bool {
        let needed = self.estimator == EstimatorKind::Model
            || self.hardware.architecture == Architecture::Histogram;
        self.hardware.total_counts.unwrap_or(needed)
    }

    /// The scene with another estimator, and with the hardware that it needs, as
    /// far as the scene leaves that open; unchanged for `None`.
    ///
    /// # Errors
    /// When the scene's hardware leaves out what the estimator needs.
    pub fn with_estimator(
        mut self,
        estimator: Option<EstimatorKind>,
    ) -> Result<Self, TotalsMissing> {
        self.estimator = estimator.unwrap_or(self.estimator);
        if self.estimator == EstimatorKind::Model && !self.sends_total_counts() {
            return Err(TotalsMissing);
        }
        Ok(self)
    }

    /// The scene with another estimator on the hardware that it has: what is sent
    /// stays as it is.
    pub fn estimated_by(&self, estimator: EstimatorKind) -> Scene {
        let mut scene = self.clone();
        scene.hardware.total_counts = Some(self.sends_total_counts());
        scene.estimator = estimator;
        scene
    }
}

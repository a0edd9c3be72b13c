//! The expected counts of a scan.

use super::CountingTier;
use super::fit::problem::NeighbouringResponses;
use crate::photons::DetectorModel;
use crate::response::{MeanCount, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// The expected counts of a scan, and what their second moments follow from.
pub(super) struct ExpectedCounts<'r, 'm> {
    pub response: &'r MeanResponse<'m>,
    pub second: &'r SecondMoments<'r, 'm>,
    /// Of every step.
    pub means: Vec<MeanCount>,
    /// Responses on both sides of each of the light's unknowns, where they are known already.
    pub beside: Option<Vec<NeighbouringResponses<'m>>>,
}

/// The result of `then` for the expected counts of a scene's detector.
pub(super) fn with_counts<T, E: From<MeanResponseError>>(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    then: impl FnOnce(&ExpectedCounts) -> Result<T, E>,
) -> Result<T, E> {
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, tier)?;
    let second = SecondMoments::new(&response)?;
    then(&ExpectedCounts::new(&response, &second))
}

impl<'r, 'm> ExpectedCounts<'r, 'm> {
    pub fn new(
        response: &'r MeanResponse<'m>,
        second: &'r SecondMoments<'r, 'm>,
    ) -> ExpectedCounts<'r, 'm> {
        ExpectedCounts { response, second, means: response.mean_counts(), beside: None }
    }

    pub fn model(&self) -> &'m DetectorModel {
        self.response.model()
    }

    /// Expected signed counts.
    pub fn signed(&self) -> Vec<f64> {
        self.means.iter().map(|mean| mean.signed).collect()
    }

    /// Variance of a step's signed count.
    pub fn signed_variance(&self, step: usize) -> f64 {
        self.second.of_steps(&[Step::at(step)])[0].signed_variance
    }
}

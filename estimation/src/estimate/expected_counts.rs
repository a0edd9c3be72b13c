//! What a scan is expected to count.

use super::fit::problem::Beside;
use crate::photons::DetectorModel;
use crate::response::{MeanCount, MeanResponse, SecondMoments};
use crate::scan::Step;

/// The expected counts of a scan, and what their second moments follow from.
pub(super) struct ExpectedCounts<'r, 'm> {
    pub response: &'r MeanResponse<'m>,
    pub second: &'r SecondMoments<'r, 'm>,
    /// Of every step.
    pub means: Vec<MeanCount>,
    /// Responses on both sides of each of the light's unknowns, where they are known already.
    pub beside: Option<Vec<Beside<'m>>>,
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

    /// Of some steps.
    pub fn of_steps(&self, steps: &[Step]) -> Vec<MeanCount> {
        steps.iter().map(|step| self.means[step.index()]).collect()
    }

    /// Expected signed counts.
    pub fn signed(&self) -> Vec<f64> {
        self.means.iter().map(|mean| mean.signed).collect()
    }
}

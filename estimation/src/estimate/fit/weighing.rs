//! How much the counts of a problem's steps weigh.

use std::convert::Infallible;
use std::sync::Arc;

use super::long_scan::{self, PerDetection};
use super::parameters::Parameters;
use super::problem::Problem;
use super::shared_light;
use super::template::Axis;
use super::weights::Weights;
use crate::response::{CountMoments, MeanCount, MeanResponse, MeanResponseError, SecondMoments};

/// From this many steps on, second moments of all steps of the scan at once cost
/// less than step by step.
const STEPS_FOR_SCAN_MOMENTS: usize = 60;

impl Problem<'_> {
    /// Inverse covariances of the steps' counts, from their second moments; `parameters`
    /// and `means` are those of their light.
    pub fn weights_of(
        &self,
        second: &SecondMoments,
        parameters: &Parameters,
        means: &[MeanCount],
        axis: &Axis,
    ) -> Weights {
        let peaks = self.own_peaks(parameters, axis);
        let alone = |few: &Problem| -> Result<Arc<[PerDetection]>, Infallible> {
            Ok(few.moments_of(second).iter().map(PerDetection::from_moments).collect())
        };
        let shared =
            |few: &Problem| -> Result<_, Infallible> { Ok(few.shared_steps(second).into()) };
        let weights = match (self.is_long(), self.shares_light()) {
            (false, false) => Ok(Weights::of(&self.moments_of(second))),
            (false, true) => Ok(Weights::of_groups(&self.shared_steps(second))),
            (true, false) => long_scan::weights_of_scan(self, axis, &peaks, means, 0.0, alone),
            (true, true) => shared_light::weights_of_scan(self, axis, &peaks, means, shared),
        };
        match weights {
            Ok(weights) => weights,
            Err(never) => match never {},
        }
    }

    /// Moments of the steps' counts.
    pub fn moments(&self, response: &MeanResponse) -> Result<Vec<CountMoments>, MeanResponseError> {
        Ok(self.moments_of(&SecondMoments::new(response)?))
    }

    fn moments_of(&self, second: &SecondMoments) -> Vec<CountMoments> {
        if self.takes_all_steps() && self.steps.len() > STEPS_FOR_SCAN_MOMENTS {
            second.of_scan()
        } else {
            second.of_steps(&self.steps)
        }
    }
}

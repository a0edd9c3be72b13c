//! The tier that draws nothing.

use super::Tier;
use super::scans::ScansError;
use super::simulate::PathStatistics;
use crate::estimate::{PredictionError, predict};
use crate::optics::{DetectorModel, MeanResponse};
use crate::scene::Scene;

/// Makes of the statistics of no scans at all, which have the expectations beside
/// them, the tier's answer: the expectations themselves, without standard errors.
///
/// The share of right coarse estimates is one less the sum of the chances of all
/// wrong steps: a lower bound.
///
/// # Errors
/// When the mean response cannot be had.
pub(super) fn answer(
    scene: &Scene,
    detector: usize,
    statistics: &mut [PathStatistics],
) -> Result<(), ScansError> {
    let counting = Tier::Expected.counting();
    let model = DetectorModel::new(scene, detector);
    let detected_rate_cps = MeanResponse::of_tier(&model, counting)?.detection_rate_hz();
    for path in statistics {
        path.bias_m = path.expected_bias_m;
        path.std_m = path.expected_std_m;
        path.std_over_bound = path.std_m.zip(path.bound_m).map(|(std, bound)| std / bound);
        path.mean_m = path.bias_m.map(|bias_m| path.true_m + bias_m);
        path.detected_rate_cps = detected_rate_cps;
        match predict(scene, detector, path.path, counting) {
            Ok(expected) => path.correct_coarse_fraction = 1.0 - expected.coarse_failure_bound,
            Err(PredictionError::MeanResponse(reason)) => return Err(reason.into()),
            Err(reason) => {
                path.correct_coarse_fraction = 0.0;
                path.remark = Some(reason.to_string());
            }
        }
    }
    Ok(())
}

//! The tier that draws nothing.

use super::Tier;
use super::scans::ScansError;
use super::simulate::PathStatistics;
use crate::estimate::{Prediction, PredictionError};
use crate::optics::{DetectorModel, MeanResponse};
use crate::scene::Scene;

/// Makes of the statistics of no scans at all, which have the expectations beside
/// them, the tier's answer: the expectations themselves, without standard errors.
/// `predictions` are those of the statistics' paths.
///
/// The share of right coarse estimates is one less the sum of the chances of all
/// wrong steps: a lower bound.
///
/// # Errors
/// When the expectations cannot be had.
pub(super) fn answer(
    scene: &Scene,
    detector: usize,
    predictions: &[Result<Prediction, PredictionError>],
    statistics: &mut [PathStatistics],
) -> Result<(), ScansError> {
    for (path, prediction) in statistics.iter_mut().zip(predictions) {
        path.bias_m = path.expected_bias_m;
        path.std_m = path.expected_std_m;
        path.std_over_bound = path.std_m.zip(path.bound_m).map(|(std, bound)| std / bound);
        path.mean_m = path.bias_m.map(|bias_m| path.true_m + bias_m);
        match prediction {
            Ok(expected) => {
                path.correct_coarse_fraction = 1.0 - expected.coarse_failure_bound;
                path.detected_rate_cps = expected.detection_rate_hz;
            }
            Err(reason @ (PredictionError::Flat | PredictionError::CoarseOnly(_))) => {
                path.correct_coarse_fraction = 0.0;
                path.detected_rate_cps = detection_rate_cps(scene, detector)?;
                path.remark = Some(reason.to_string());
            }
            Err(reason) => return Err((*reason).into()),
        }
    }
    Ok(())
}

fn detection_rate_cps(scene: &Scene, detector: usize) -> Result<f64, ScansError> {
    let model = DetectorModel::new(scene, detector);
    let response = MeanResponse::of_tier(&model, Tier::Expected.counting())?;
    Ok(response.detection_rate_hz())
}

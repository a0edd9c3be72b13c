//! The tier that draws nothing.

use super::Tier;
use super::path_statistics::PathStatistics;
use super::scans::ScansError;
use crate::estimate::unwrap::{check_normal, fold_distance};
use crate::estimate::{PredictionError, Theory, distance_m};
use crate::photons::DetectorModel;
use crate::response::MeanResponse;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Makes of the statistics of no scans at all, which have the expectations beside
/// them, the tier's answer: the expectations themselves, without standard errors.
/// `theory` is that of the statistics' paths.
///
/// # Errors
/// When the expectations cannot be had.
pub(super) fn answer(
    sensor: &Sensor,
    detector: DetectorIndex,
    theory: &Theory,
    statistics: &mut [PathStatistics],
) -> Result<(), ScansError> {
    let expected = theory.predictions.iter().zip(&theory.missed);
    for (path, (prediction, &missed)) in statistics.iter_mut().zip(expected) {
        path.missed_scans = 0;
        path.missed_fraction = missed;
        path.expected_missed_fraction = missed;
        path.correct_coarse_fraction = missed.map(|share| 1.0 - share);
        path.bias_m = path.expected_bias_m;
        path.std_m = path.expected_std_m;
        path.std_over_bound = path.std_m.zip(path.bound_m).map(|(std, bound)| std / bound);
        let range_m = distance_m(sensor.timing().code_period_ps());
        path.mean_distance_m =
            path.bias_m.map(|bias_m| fold_distance(path.true_distance_m + bias_m, range_m));
        if let (Ok(expected), None) = (prediction, path.bias_m) {
            let spread = check_normal(expected.std_m, range_m).err();
            path.remark = path.remark.take().or(spread.map(|s| s.to_string()));
        }
        match prediction {
            Ok(expected) => {
                path.detected_rate_cps = expected.detection_rate_hz;
            }
            Err(
                reason @ (PredictionError::Flat
                | PredictionError::CoarseOnly(_)
                | PredictionError::NotCovered(_)),
            ) => {
                path.detected_rate_cps = detection_rate_cps(sensor, detector)?;
                path.remark = Some(reason.to_string());
            }
            Err(reason) => return Err((*reason).into()),
        }
    }
    Ok(())
}

fn detection_rate_cps(sensor: &Sensor, detector: DetectorIndex) -> Result<f64, ScansError> {
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, Tier::Expected.counting(sensor))?;
    Ok(response.detection_rate_hz())
}

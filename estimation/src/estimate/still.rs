//! What the phase estimator says of paths that stand still, on average, and how much it
//! scatters.

use std::collections::BTreeMap;

use super::expected_counts::ExpectedCounts;
use super::prediction::{
    Answer, Prediction, PredictionError, coarse_failure_bound_fraction, peak_of_path,
};
use super::{CountingTier, calibration_offset_ps, coverage, distance_m, missed};
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, SecondMoments};
use crate::scan::{Group, Step};
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// [`predict`](super::predict) of paths that stand still.
pub(super) fn predict(
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
) -> Result<Prediction, PredictionError> {
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, counting)?;
    let second = SecondMoments::new(&response)?;
    let counts = ExpectedCounts::new(&response, &second);
    predict_from(&counts, sensor, detector, path, counting)
}

/// [`predict`] from the scene's expected counts.
pub(super) fn predict_from(
    counts: &ExpectedCounts,
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
) -> Result<Prediction, PredictionError> {
    let expected = counts.signed();
    let offset_ps = calibration_offset_ps(sensor, detector, counting);
    let answer = Answer::to_path(&expected, sensor, counts.model(), path, offset_ps)?;
    let variance_ps2 = variance_of_sum(counts, &answer.slopes_ps);
    let peak = answer.peak;
    let peak_variance = counts.second.of_steps(&[Step::at(peak)])[0].signed_variance;
    coverage::check_slipping(counts, counting, peak_variance)?;
    let rate_hz = counts.response.detection_rate_hz();
    let linear = Prediction {
        missed_fraction: missed_from(counts, sensor, detector, path, counting),
        ..answer.prediction(sensor, path, [variance_ps2, peak_variance], rate_hz)
    };
    if linear.is_linear() || missed::errors_wrap(sensor, path) {
        return Ok(linear);
    }
    Ok(match missed::drawn_errors_ps(counts, sensor, detector, path, counting, peak) {
        None => linear,
        Some((mean_ps, std_ps)) => Prediction {
            bias_m: distance_m(mean_ps),
            std_m: distance_m(std_ps),
            is_drawn: true,
            ..linear
        },
    })
}

/// [`Prediction::missed_fraction`], also where there is only a coarse estimate.
pub(super) fn missed_from(
    counts: &ExpectedCounts,
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
) -> Option<f64> {
    let expected = counts.signed();
    let offset_ps = calibration_offset_ps(sensor, detector, counting);
    let peak = peak_of_path(&expected, sensor, path, offset_ps);
    let variance = counts.second.of_steps(&[Step::at(peak)])[0].signed_variance;
    let bound = coarse_failure_bound_fraction(&expected, peak, variance, sensor);
    missed::missed_fraction(counts, sensor, detector, path, counting, (peak, bound))
}

/// Variance of the sum of weight x r over steps: those of one group go together,
/// groups are independent.
fn variance_of_sum(counts: &ExpectedCounts, weighted: &[(Step, f64)]) -> f64 {
    let model = counts.model();
    if model.timing.parallel == 1 {
        let steps: Vec<Step> = weighted.iter().map(|(step, _)| *step).collect();
        let moments = counts.second.of_steps(&steps);
        let terms = weighted.iter().zip(moments);
        return terms.map(|((_, weight), moments)| weight * weight * moments.signed_variance).sum();
    }
    let mut groups: BTreeMap<Group, Vec<(Step, f64)>> = BTreeMap::new();
    for &(step, weight) in weighted {
        let group = groups.entry(model.timing.grouping().group_of(step)).or_default();
        group.push((step, weight));
    }
    let variances = groups.values();
    variances.map(|steps| counts.second.variance_of_sum(steps)).sum()
}

//! What the phase estimator says of paths that stand still, on average, and how much it
//! scatters.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::expected_counts::ExpectedCounts;
use super::phase::{estimate_at, fundamental, window_indices};
use super::prediction::{
    Prediction, PredictionError, check_path_is_modulated, coarse_failure_bound_fraction,
    coarse_spread_m, peak_of_path,
};
use super::{CountingTier, calibration_offset_ps, coverage, delay_error_ps, distance_m, missed};
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
    check_path_is_modulated(counts.model(), path)?;
    let expected = counts.signed();
    let smallest = expected.iter().copied().fold(f64::INFINITY, f64::min);
    let offset_ps = calibration_offset_ps(sensor, detector, counting);
    let peak = peak_of_path(&expected, sensor, path, offset_ps);
    // Equal up to rounding: the sums run over thousands of chips.
    if expected[peak] - smallest <= 1e-9 * expected[peak].abs() {
        return Err(PredictionError::Flat);
    }

    let timing = sensor.timing();
    let fundamental = fundamental(&expected, peak, timing)?;
    let mut window = Vec::new();
    for (offset, index) in window_indices(peak, timing)? {
        let angle =
            PI * offset as f64 / f64::from(sensor.clock().samples_per_chip) + fundamental.arg();
        window.push((Step::at(index), angle.sin()));
    }
    let phase_std = variance_of_sum(counts, &window).sqrt() / fundamental.norm();

    let estimate = estimate_at(&expected, peak, timing, offset_ps);
    let peak_variance = counts.second.of_steps(&[Step::at(peak)])[0].signed_variance;
    coverage::check_slipping(counts, counting, peak_variance)?;
    let code_period_ps = sensor.timing().code_period_ps();
    let true_delay_ps = sensor.scene().paths[path].delay_ps;
    let failures = coarse_failure_bound_fraction(&expected, peak, peak_variance, sensor);
    let linear = Prediction {
        bias_m: distance_m(delay_error_ps(estimate.delay_ps, true_delay_ps, code_period_ps)),
        std_m: distance_m(sensor.clock().ps(phase_std / PI)),
        estimate,
        detection_rate_hz: counts.response.detection_rate_hz(),
        phase_std_rad: phase_std,
        coarse_failure_bound_fraction: failures,
        missed_fraction: missed_from(counts, sensor, detector, path, counting),
        coarse_spread_m: coarse_spread_m(&expected, peak, peak_variance, timing),
        is_drawn: false,
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

//! Mean and scatter of the phase estimator for paths at rest.

use std::collections::BTreeMap;

use super::expected_counts::{ExpectedCounts, with_counts};
use super::prediction::{
    PhaseAnswer, Prediction, PredictionError, coarse_failure_bound_fraction, peak_of_path,
};
use super::truth::Asked;
use super::{coverage, missed};
use crate::scan::{Group, Step};

/// [`predict`](super::predict) of paths that stand still.
pub(super) fn predict(asked: &Asked) -> Result<Prediction, PredictionError> {
    let Asked { sensor, detector, tier, .. } = *asked;
    with_counts(sensor, detector, tier, |counts| predict_from(counts, asked))
}

/// [`predict`] from the scene's expected counts.
pub(super) fn predict_from(
    counts: &ExpectedCounts,
    asked: &Asked,
) -> Result<Prediction, PredictionError> {
    let expected = counts.signed();
    let answer = PhaseAnswer::to_path(&expected, asked, counts.model())?;
    let variance_ps2 = variance_of_sum(counts, &answer.slopes_ps);
    let peak_variance = counts.signed_variance(answer.peak);
    coverage::check_slipping(counts.model(), asked.tier, peak_variance)?;
    let rate_hz = counts.response.detection_rate_hz();
    let linear = Prediction {
        missed_fraction: missed_from(counts, asked),
        ..answer.prediction(asked, [variance_ps2, peak_variance], rate_hz)
    };
    if linear.is_linear() || missed::errors_wrap(asked.sensor, asked.path) {
        return Ok(linear);
    }
    Ok(linear.with_drawn_errors(missed::drawn_errors(counts, asked, answer.peak)))
}

/// [`Prediction::missed_fraction`], also where there is only a coarse estimate.
pub(super) fn missed_from(counts: &ExpectedCounts, asked: &Asked) -> Option<f64> {
    let expected = counts.signed();
    let peak = peak_of_path(&expected, asked);
    let variance = counts.signed_variance(peak);
    let bound = coarse_failure_bound_fraction(&expected, peak, variance, asked.sensor);
    missed::missed_fraction(counts, asked, (peak, bound))
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

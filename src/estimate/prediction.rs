//! What the phase estimator will say on average, and how much it will scatter.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::histogram;
use super::phase::{CoarseOnly, Estimate, estimate_at, first_maximum, fundamental, window_indices};
use super::theory::ExpectedCounts;
use super::{
    CountingTier, TheoryEffort, calibration_offset_ps, delay_error_ps, distance_m, missed, moving,
};
use crate::histogram::correction::CorrectionError;
use crate::math::normal_cdf;
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::{Group, Step, Timing};
use crate::scene::{Architecture, DetectorIndex, Path, PathIndex};
use crate::sensor::Sensor;

/// The estimate that the expected counts give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Estimated less true distance, in metres: range walk, circular error,
    /// interference and other paths together.
    pub bias_m: f64,
    /// Standard deviation of one scan's estimate, in metres, as long as the
    /// coarse stage finds this peak.
    pub std_m: f64,
    /// The estimate itself.
    pub estimate: Estimate,
    /// Mean detection rate.
    pub detection_rate_hz: f64,
    /// Scatter of the phase, in radians. The standard deviation is linear in it,
    /// which holds for small ones.
    pub phase_std_rad: f64,
    /// No more than this share of scans has its largest count more than a chip
    /// from the path's peak: the sum of the chances of all steps there.
    pub coarse_failure_bound_fraction: f64,
    /// Share of scans that miss the path: whose estimate, by the scene's estimator,
    /// is more than [`tolerance_ps`](super::tolerance_ps) off, or nearer to another
    /// path. None where it cannot be told (the model estimator with several paths).
    pub missed_fraction: Option<f64>,
    /// Standard deviation of the fine estimates, in metres, that the expected counts
    /// give round those steps within a chip which may count most, weighted with the
    /// chance to count more than the peak. The standard deviation leaves it out.
    pub coarse_spread_m: f64,
}

/// Why there is no prediction.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PredictionError {
    /// The mean response cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The expected counts have no peak at the path.
    #[error("the expected counts have no peak: the path carries no modulated light")]
    Flat,
    /// The estimate would be as coarse as a phase step.
    #[error("only a coarse estimate is possible: {0}")]
    CoarseOnly(#[from] CoarseOnly),
    /// The expected histogram is too bright to take the dead time out.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    /// A path does not stand still within a phase step.
    #[error(
        "within a phase step the delay of path {path} moves by {moved_ps:.1} ps (walk, and twice \
         the fluctuation's standard deviation); the prediction needs at most {limit_ps:.1} ps"
    )]
    MovesTooFast {
        /// Index of the path.
        path: PathIndex,
        /// How far it moves.
        moved_ps: f64,
        /// How far it may.
        limit_ps: f64,
    },
}

/// Predicts the phase estimator's bias against path `path`, and its standard
/// deviation, for counts of tier `counting`.
///
/// The standard deviation comes from the phase's linearisation: with Z the
/// fundamental, the phase's error is the sum over offsets i of the count's error
/// times sin(pi i / S + phi) / |Z|. Steps of one group (`parallel` in the sensor)
/// see the same detections, so their counts go together; groups are independent.
/// Paths may move, slowly beside the phase steps; the bias is against their
/// [`true_delay`](super::true_delay).
///
/// # Panics
/// If the scene has no such detector or path.
pub fn predict(
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
) -> Result<Prediction, PredictionError> {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return histogram::predict(sensor, detector, path);
    }
    if moves(sensor, detector) {
        moving::check_speed(sensor, detector)?;
    }
    TheoryEffort::of(sensor, detector)?.check_predictions(1)?;
    if moves(sensor, detector) {
        moving::predict(sensor, detector, path, counting)
    } else {
        predict_still(sensor, detector, path, counting)
    }
}

/// A path without modulated light has no peak, whatever other light peaks.
pub(super) fn check_path_is_modulated(
    model: &DetectorModel,
    path: PathIndex,
) -> Result<(), PredictionError> {
    if model.modulated_paths().any(|modulated| modulated == path) {
        Ok(())
    } else {
        Err(PredictionError::Flat)
    }
}

/// Whether any path to the detector moves.
pub(super) fn moves(sensor: &Sensor, detector: DetectorIndex) -> bool {
    let moves = |p: &Path| p.detector == detector && p.movement.is_some();
    sensor.scene().paths.iter().any(moves)
}

/// The same for paths that stand still.
pub(super) fn predict_still(
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

/// The same from the scene's expected counts.
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
    let code_period_ps = sensor.timing().code_period_ps();
    let true_delay_ps = sensor.scene().paths[path].delay_ps;
    let failures = coarse_failure_bound_fraction(&expected, peak, peak_variance, sensor);
    Ok(Prediction {
        bias_m: distance_m(delay_error_ps(
            estimate.delay_ps,
            true_delay_ps,
            code_period_ps,
        )),
        std_m: distance_m(sensor.clock().ps(phase_std / PI)),
        estimate,
        detection_rate_hz: counts.response.detection_rate_hz(),
        phase_std_rad: phase_std,
        coarse_failure_bound_fraction: failures,
        missed_fraction: missed_from(counts, sensor, detector, path, counting),
        coarse_spread_m: coarse_spread_m(&expected, peak, peak_variance, timing),
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
        return terms
            .map(|((_, weight), moments)| weight * weight * moments.signed_variance)
            .sum();
    }
    let mut groups: BTreeMap<Group, Vec<(Step, f64)>> = BTreeMap::new();
    for &(step, weight) in weighted {
        let group = groups
            .entry(model.timing.grouping().group_of(step))
            .or_default();
        group.push((step, weight));
    }
    let variances = groups.values();
    variances
        .map(|steps| counts.second.variance_of_sum(steps))
        .sum()
}

/// Sum over all steps more than a chip from the peak of the chance that they
/// count more than it, for normal counts that all scatter as the peak's does.
pub(super) fn coarse_failure_bound_fraction(
    expected: &[f64],
    peak: usize,
    variance: f64,
    sensor: &Sensor,
) -> f64 {
    let failures = (0..expected.len())
        .filter(|&step| !within_a_chip(sensor.timing(), step, peak))
        .map(|step| normal_cdf((expected[step] - expected[peak]) / (2.0 * variance).sqrt()));
    failures.sum::<f64>().min(1.0)
}

/// [`Prediction::coarse_spread_m`], for normal counts that all scatter as the
/// peak's does.
pub(super) fn coarse_spread_m(
    expected: &[f64],
    peak: usize,
    variance: f64,
    timing: &Timing,
) -> f64 {
    let code_period_ps = timing.code_period_ps();
    let at_peak = estimate_at(expected, peak, timing, 0.0);
    // Sums of weights, of weighted distances from the peak's, and of their squares.
    let mut sums = [0.0; 3];
    for (step, count) in expected.iter().enumerate() {
        if !within_a_chip(timing, step, peak) {
            continue;
        }
        let weight = normal_cdf((count - expected[peak]) / (2.0 * variance).sqrt());
        let there = estimate_at(expected, step, timing, 0.0);
        if there.is_fine() && weight > 1e-6 {
            let error_ps = delay_error_ps(there.delay_ps, at_peak.delay_ps, code_period_ps);
            let from_peak_m = distance_m(error_ps);
            sums[0] += weight;
            sums[1] += weight * from_peak_m;
            sums[2] += weight * from_peak_m * from_peak_m;
        }
    }
    let [weights, distances, squares] = sums;
    if weights <= 0.0 {
        return 0.0;
    }
    let mean = distances / weights;
    (squares / weights - mean * mean).max(0.0).sqrt()
}

/// Whether two steps of a scan are at most a chip apart.
fn within_a_chip(timing: &Timing, a: usize, b: usize) -> bool {
    let apart = timing.scan.steps_apart(Step::at(a), Step::at(b));
    apart <= u64::from(timing.clock.samples_per_chip)
}

/// Step with the largest expected count within a chip of where the path's
/// light should peak: what the coarse stage answers when it answers with this
/// path. Without any such step in the scan, the largest of all.
pub(super) fn peak_of_path(
    expected: &[f64],
    sensor: &Sensor,
    path: PathIndex,
    offset_ps: f64,
) -> usize {
    let scan = &sensor.timing().scan;
    let step_ps = sensor.clock().sample_period_ps();
    let peak_step = ((sensor.scene().paths[path].delay_ps + offset_ps) / step_ps).round() as i128;
    let period = i128::from(scan.steps_per_period);
    let chip = i128::from(sensor.clock().samples_per_chip);
    (peak_step - chip..=peak_step + chip)
        .map(|step| (step - i128::from(scan.first_step)).rem_euclid(period) as usize)
        .filter(|&step| step < expected.len())
        .max_by(|&a, &b| expected[a].total_cmp(&expected[b]))
        .unwrap_or_else(|| first_maximum(expected))
}

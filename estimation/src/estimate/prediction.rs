//! Predictions for the phase estimator, their errors, and what all of them share.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::approximation::Approximation;
use super::missed::{DrawnErrors, counted_errors_ps};
use super::phase::{CoarseOnly, Estimate, estimate_at, first_maximum, fundamental, window_indices};
use super::truth::Asked;
use super::{delay_error_ps, distance_m};
use crate::histogram::correction::CorrectionError;
use crate::light::round_trip_ps;
use crate::math::{NormalLaw, PartOfNormal, normal_cdf};
use crate::photons::DetectorModel;
use crate::response::MeanResponseError;
use crate::scan::{Step, Timing};
use crate::scene::{DetectorIndex, Path, PathIndex};
use crate::sensor::Sensor;

/// The estimate that the expected counts give.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
    /// Share of scans whose largest count is at a step within a chip that is too near the scan's
    /// rim for the phase: their estimates are as coarse as a phase step.
    pub coarse_only_fraction: f64,
    /// Whether bias and standard deviation are those of drawn scans: then they hold both.
    pub is_drawn: bool,
}

/// The phase's scatter beyond which the standard deviation is more than 3 % larger
/// than its linearisation. Measured over 30,000 scans of Table I's sensor: 1 % at
/// 0.07 rad, 2.6 % at 0.1, 5 % at 0.14, 7 % at 0.17.
const LINEAR_PHASE_RAD: f64 = 0.1;
/// Spread of the fine estimates round neighbouring coarse steps, in standard
/// deviations, that shows in the scatter. Measured over 20,000 scans of steps that are
/// a part of a code period: 1.5 % more at 0.18, 16 % at 0.25, 20 % at 0.35. A smooth
/// peak comes to it at 0.08 rad.
const COARSE_SPREAD: f64 = 0.18;

impl Prediction {
    /// Whether the phase scatters so little that its linearisation holds, round one leading
    /// step.
    pub fn is_linear(&self) -> bool {
        self.phase_std_rad <= LINEAR_PHASE_RAD && self.coarse_spread_in_std() <= COARSE_SPREAD
    }

    /// With bias and standard deviation of the delay, in ps, from drawn scans, if there are any.
    pub(super) fn with_drawn_errors(self, drawn: Option<DrawnErrors>) -> Prediction {
        let Some((mean_ps, std_ps)) = drawn.and_then(|drawn| drawn.errors_ps) else { return self };
        let [bias_m, std_m] = [mean_ps, std_ps].map(distance_m);
        Prediction { bias_m, std_m, is_drawn: true, ..self }
    }

    /// The path's errors, as normal ones, of which those count for it that are not nearer to
    /// another path, or too large: bias and standard deviation of these, and their share.
    pub(super) fn counted(self, asked: &Asked) -> (Prediction, f64) {
        let [mean, std] = [self.bias_m, self.std_m].map(round_trip_ps);
        let PartOfNormal { share, part } = counted_errors_ps(asked, NormalLaw { mean, std });
        let [bias_m, std_m] = [part.mean, part.std].map(distance_m);
        (Prediction { bias_m, std_m, ..self }, share)
    }

    /// [`Self::coarse_spread_m`] in standard deviations of the linearisation.
    pub fn coarse_spread_in_std(&self) -> f64 {
        self.coarse_spread_m / self.std_m.max(f64::MIN_POSITIVE)
    }
}

/// Why a prediction failed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PredictionError {
    /// The mean response cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// An approximation does not hold.
    #[error(transparent)]
    NotCovered(#[from] Approximation),
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

/// The phase estimator's answer to the values that are expected of a scan's phase steps, round
/// the peak of some path.
pub(super) struct PhaseAnswer<'v> {
    pub values: &'v [f64],
    pub peak: usize,
    pub estimate: Estimate,
    /// Steps of the peak's window, and by how many ps the delay changes with each one's value.
    pub slopes_ps: Vec<(Step, f64)>,
}

impl<'v> PhaseAnswer<'v> {
    /// Round the step of the largest of `values` that counts for a path of the detector `model`.
    pub fn to_path(
        values: &'v [f64],
        asked: &Asked,
        model: &DetectorModel,
    ) -> Result<PhaseAnswer<'v>, PredictionError> {
        // A path without modulated light has no peak, whatever other light peaks.
        if !model.modulated_paths().any(|modulated| modulated == asked.path) {
            return Err(PredictionError::Flat);
        }
        let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
        let peak = peak_of_path(values, asked);
        // Equal up to rounding: the sums run over thousands of chips.
        if values[peak] - smallest <= 1e-9 * values[peak].abs() {
            return Err(PredictionError::Flat);
        }
        Ok(PhaseAnswer::round(values, asked.sensor.timing(), peak, asked.offset_ps())?)
    }

    /// Round a step.
    pub fn round(
        values: &'v [f64],
        timing: &Timing,
        peak: usize,
        offset_ps: f64,
    ) -> Result<PhaseAnswer<'v>, CoarseOnly> {
        let fundamental = fundamental(values, peak, timing)?;
        let slope_ps = |(offset, index): (i64, usize)| {
            let samples = f64::from(timing.clock.samples_per_chip);
            let angle = PI * offset as f64 / samples + fundamental.arg();
            (Step::at(index), timing.clock.ps(angle.sin() / fundamental.norm() / PI))
        };
        Ok(PhaseAnswer {
            values,
            peak,
            estimate: estimate_at(values, peak, timing, offset_ps),
            slopes_ps: window_indices(peak, timing)?.map(slope_ps).collect(),
        })
    }

    /// What it says of a path, with the variance of its delay and of the peak's value, and the rate
    /// of detections; the share of scans that miss the path is left open.
    pub fn prediction(
        &self,
        asked: &Asked,
        [variance_ps2, peak_variance]: [f64; 2],
        detection_rate_hz: f64,
    ) -> Prediction {
        let sensor = asked.sensor;
        let (timing, values, peak) = (sensor.timing(), self.values, self.peak);
        let true_ps = sensor.scene().paths[asked.path].delay_ps;
        let leaders = Leaders::new(values, peak, peak_variance, timing);
        let error_ps = delay_error_ps(self.estimate.delay_ps, true_ps, timing.code_period_ps());
        Prediction {
            bias_m: distance_m(error_ps),
            std_m: distance_m(variance_ps2.sqrt()),
            estimate: self.estimate,
            detection_rate_hz,
            phase_std_rad: PI * variance_ps2.sqrt() / timing.clock.chip_period_ps,
            coarse_failure_bound_fraction: coarse_failure_bound_fraction(
                values,
                peak,
                peak_variance,
                sensor,
            ),
            missed_fraction: None,
            coarse_spread_m: leaders.spread_m,
            coarse_only_fraction: leaders.coarse_only_fraction,
            is_drawn: false,
        }
    }
}

/// Whether any path to the detector moves.
pub(super) fn moves(sensor: &Sensor, detector: DetectorIndex) -> bool {
    let moves = |p: &Path| p.detector == detector && p.movement.is_some();
    sensor.scene().paths.iter().any(moves)
}

/// Sum over all steps more than a chip from the peak of the chance that they
/// count more than it, for normal counts that all scatter as the peak's does.
pub(super) fn coarse_failure_bound_fraction(
    expected: &[f64],
    peak: usize,
    variance: f64,
    sensor: &Sensor,
) -> f64 {
    failures(expected, peak, variance, sensor).sum::<f64>().min(1.0)
}

/// Whether one step more than a chip from the peak all but always counts more than it: by
/// four standard deviations of the difference.
pub(super) fn is_never_largest(
    expected: &[f64],
    peak: usize,
    variance: f64,
    sensor: &Sensor,
) -> bool {
    failures(expected, peak, variance, sensor).any(|chance| chance > normal_cdf(4.0))
}

/// Chance of each step more than a chip from the peak to count more than it.
fn failures(
    expected: &[f64],
    peak: usize,
    variance: f64,
    sensor: &Sensor,
) -> impl Iterator<Item = f64> {
    (0..expected.len())
        .filter(move |&step| !within_a_chip(sensor.timing(), step, peak))
        .map(move |step| normal_cdf((expected[step] - expected[peak]) / (2.0 * variance).sqrt()))
}

/// The steps within a chip of the peak that may have the largest count, each weighted with the
/// chance to count more than the peak, for normal counts that all scatter as the peak's does.
struct Leaders {
    /// [`Prediction::coarse_spread_m`].
    spread_m: f64,
    /// [`Prediction::coarse_only_fraction`].
    coarse_only_fraction: f64,
}

impl Leaders {
    fn new(expected: &[f64], peak: usize, variance: f64, timing: &Timing) -> Leaders {
        let code_period_ps = timing.code_period_ps();
        let at_peak = estimate_at(expected, peak, timing, 0.0);
        // Sums of weights, of weighted distances from the peak's, and of their squares.
        let mut sums = [0.0; 3];
        let mut coarse_only = 0.0;
        for (step, count) in expected.iter().enumerate() {
            let weight = normal_cdf((count - expected[peak]) / (2.0 * variance).sqrt());
            if !within_a_chip(timing, step, peak) || weight <= 1e-6 {
                continue;
            }
            let there = estimate_at(expected, step, timing, 0.0);
            if !there.is_fine() {
                coarse_only += weight;
                continue;
            }
            let error_ps = delay_error_ps(there.delay_ps, at_peak.delay_ps, code_period_ps);
            let from_peak_m = distance_m(error_ps);
            sums[0] += weight;
            sums[1] += weight * from_peak_m;
            sums[2] += weight * from_peak_m * from_peak_m;
        }
        let [weights, distances, squares] = sums;
        let mean = if weights > 0.0 { distances / weights } else { 0.0 };
        Leaders {
            spread_m: if weights > 0.0 {
                (squares / weights - mean * mean).max(0.0).sqrt()
            } else {
                0.0
            },
            coarse_only_fraction: coarse_only / (weights + coarse_only).max(f64::MIN_POSITIVE),
        }
    }
}

/// Whether two steps of a scan are at most a chip apart.
fn within_a_chip(timing: &Timing, a: usize, b: usize) -> bool {
    let apart = timing.scan.steps_apart(Step::at(a), Step::at(b));
    apart <= u64::from(timing.clock.samples_per_chip)
}

/// Step with the largest expected count within a chip of where the path's
/// light should peak: what the coarse stage answers when it answers with this
/// path. Without any such step in the scan, the largest of all.
pub(super) fn peak_of_path(expected: &[f64], asked: &Asked) -> usize {
    let Asked { sensor, path, .. } = *asked;
    let scan = &sensor.timing().scan;
    let step_ps = sensor.clock().sample_period_ps();
    let peak_step =
        ((sensor.scene().paths[path].delay_ps + asked.offset_ps()) / step_ps).round() as i128;
    let period = i128::from(scan.steps_per_period);
    let chip = i128::from(sensor.clock().samples_per_chip);
    (peak_step - chip..=peak_step + chip)
        .map(|step| (step - i128::from(scan.first_step)).rem_euclid(period) as usize)
        .filter(|&step| step < expected.len())
        .max_by(|&a, &b| expected[a].total_cmp(&expected[b]))
        .unwrap_or_else(|| first_maximum(expected))
}

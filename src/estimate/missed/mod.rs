//! Scans that miss the peak of a path: what that means, and how often it happens.
//!
//! A scan *finds* a path if its estimate lies within [`tolerance_ps`] of the path's
//! true delay, the shorter way round the code period, and no other path of the same
//! source is nearer to it. Else it *misses the peak*. Simulation, prediction and
//! documents use this one definition, for either estimator.

mod find;
mod largest;
mod law;
mod sampled;
mod scan;
mod wedge;

use super::theory::ExpectedCounts;
use super::{CountingTier, calibration_offset_ps, true_delay};
use crate::scan::Step;
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex};
use crate::sensor::Sensor;

/// Shares of misses below this are not worked out any further than the sum of the
/// chances of all wrong steps.
const NEGLIGIBLE: f64 = 1e-7;

/// How far an estimate may be off for its scan to have found the peak, in ps: a chip,
/// the half-base of the correlation's peak; of a code so short that a chip is more
/// than a quarter of its period (a square wave) a quarter of the period, so that an
/// estimate on the far side of it is never right.
pub fn tolerance_ps(chip_period_ps: f64, code_period_ps: f64) -> f64 {
    chip_period_ps.min(0.25 * code_period_ps)
}

/// Errors of the delay, in ps, with which a scan has found a path.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Accepted {
    low_ps: f64,
    high_ps: f64,
}

impl Accepted {
    /// The tolerance, up to half-way to the next path of the same source.
    fn of(sensor: &Sensor, path: PathIndex, counting: CountingTier) -> Accepted {
        let own = &sensor.scene().paths[path];
        let code_period_ps = sensor.code_period_of_path_ps(path);
        let tolerance_ps = tolerance_ps(sensor.clock().chip_period_ps, code_period_ps);
        let mut accepted = Accepted {
            low_ps: -tolerance_ps,
            high_ps: tolerance_ps,
        };
        let truth_ps = true_delay(sensor, path, counting).delay_ps;
        for (index, other) in PathIndex::of(&sensor.scene().paths).zip(&sensor.scene().paths) {
            if index == path || (other.source, other.detector) != (own.source, own.detector) {
                continue;
            }
            let other_ps = true_delay(sensor, index, counting).delay_ps;
            let later_ps = (other_ps - truth_ps).rem_euclid(code_period_ps);
            if later_ps == 0.0 && index < path {
                // The first of equals takes every estimate.
                accepted.high_ps = accepted.low_ps;
            } else if later_ps > 0.0 {
                accepted.high_ps = accepted.high_ps.min(0.5 * later_ps);
                accepted.low_ps = accepted.low_ps.max(0.5 * (later_ps - code_period_ps));
            }
        }
        accepted
    }
}

/// What the chance of a miss depends on, beside the counts.
struct Target<'a> {
    sensor: &'a Sensor,
    detector: DetectorIndex,
    /// Delay that the estimate is held against, with everything constant that is
    /// measured with it.
    measured_ps: f64,
    code_period_ps: f64,
    accepted: Accepted,
}

impl Target<'_> {
    /// How much later than the path a phase step is, in ps, the shorter way round.
    fn step_error_ps(&self, measurement: usize) -> f64 {
        let at_ps = self
            .sensor
            .timing()
            .reference_delay_ps(Step::at(measurement));
        super::delay_error_ps(at_ps, self.measured_ps, self.code_period_ps)
    }
}

/// Expected share of scans that miss the peak of a path; none where it cannot be
/// told (the model estimator with several paths). `bound` is the sum of the chances
/// that a wrong step counts more than `peak`, the expected one.
///
/// One phase step at a time counts light of its own: the chances that each step has
/// the largest count, and that the phase round it leads to the path, are integrals
/// over that count ([`largest`]). Steps that share their light, and the shape that the
/// model estimator looks for, are correlated: scans are drawn from the counts' exact
/// means and covariances, always the same ones ([`sampled`]).
pub(super) fn missed_fraction(
    counts: &ExpectedCounts,
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
    (peak, bound): (usize, f64),
) -> Option<f64> {
    let code_period_ps = sensor.code_period_of_path_ps(path);
    let truth_ps = true_delay(sensor, path, counting).delay_ps;
    let target = Target {
        sensor,
        detector,
        measured_ps: truth_ps + calibration_offset_ps(sensor, detector, counting),
        code_period_ps,
        accepted: Accepted::of(sensor, path, counting),
    };
    let is_model = sensor.scene().estimator == EstimatorKind::Model;
    if is_model && counts.model().modulated_paths().count() > 1 {
        return None;
    }
    // Wherever the largest count is, the phase of a period of two chips is the same;
    // nothing of it is in the bound.
    let has_phase = sensor.clock().samples_per_chip > 1;
    let is_window =
        sensor.timing().scan.is_full() && sensor.timing().scan.steps == window_steps(sensor);
    let one_window = has_phase && is_window;
    if bound < NEGLIGIBLE && !one_window && target.finds_from(&counts.signed(), peak) {
        return Some(bound);
    }
    let missed = if is_model || counts.model().timing.parallel > 1 {
        sampled::missed(counts, &target)
    } else if one_window {
        1.0 - find::of_whole_period(counts, &target)
    } else {
        largest::missed(counts, &target)
    };
    Some(missed.clamp(0.0, 1.0))
}

/// Phase steps of the fine stage's window.
fn window_steps(sensor: &Sensor) -> u64 {
    2 * u64::from(sensor.clock().samples_per_chip)
}

//! Which estimates have found a path, and the probability that the phase leads to it from a coarse step.

use std::f64::consts::PI;

use super::wedge::Planar;
use crate::estimate::count_law::CountLaw;
use crate::estimate::delay_error_ps;
use crate::estimate::expected_counts::ExpectedCounts;
use crate::estimate::phase::{estimate_at, window_indices};
use crate::estimate::truth::Asked;
use crate::estimate::unwrap::tolerance_ps;
use crate::math::{NormalLaw, PartOfNormal};
use crate::scan::Step;
use crate::scene::{Detector, PathIndex};
use crate::sensor::Sensor;

/// Whether the estimates of a path that are right are fewer than those that count for it: of
/// codes of fewer than four chips, whose errors wrap.
pub(crate) fn errors_wrap(sensor: &Sensor, path: PathIndex) -> bool {
    let chip_ps = sensor.clock().chip_period_ps;
    tolerance_ps(chip_ps, sensor.code_period_of_path_ps(path)) < chip_ps
}

/// Errors of the delay, in ps, with which a scan has found a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Accepted {
    pub(super) low_ps: f64,
    pub(super) high_ps: f64,
}

impl Accepted {
    /// The tolerance, up to half-way to the next path of the same source.
    fn of(asked: &Asked) -> Accepted {
        let Asked { sensor, path, .. } = *asked;
        let own = &sensor.scene().paths[path];
        let code_period_ps = asked.code_period_ps();
        let tolerance_ps = tolerance_ps(sensor.clock().chip_period_ps, code_period_ps);
        let mut accepted = Accepted { low_ps: -tolerance_ps, high_ps: tolerance_ps };
        let truth_ps = asked.truth().delay_ps;
        for (index, other) in PathIndex::of(&sensor.scene().paths).zip(&sensor.scene().paths) {
            if index == path || (other.source, other.detector) != (own.source, own.detector) {
                continue;
            }
            let other_ps = Asked { path: index, ..*asked }.truth().delay_ps;
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

/// Normal errors of a path, in ps, that count for it: none beyond the tolerance, or nearer to
/// another path. Of errors that wrap all count but those nearer to another path.
pub(in crate::estimate) fn counted_errors_ps(asked: &Asked, errors_ps: NormalLaw) -> PartOfNormal {
    let target = MissConditions::new(asked);
    match target.is_alone() && errors_wrap(asked.sensor, asked.path) {
        true => PartOfNormal { share: 1.0, part: errors_ps },
        false => errors_ps.within(target.accepted.low_ps, target.accepted.high_ps),
    }
}

/// What the probability of a miss depends on, besides the counts.
pub(super) struct MissConditions<'a> {
    pub(super) asked: Asked<'a>,
    /// Delay that the estimate is compared with, including everything constant that is
    /// measured with it.
    pub(super) measured_ps: f64,
    pub(super) code_period_ps: f64,
    pub(super) accepted: Accepted,
}

impl<'a> MissConditions<'a> {
    /// What it depends on for a path.
    pub(super) fn new(asked: &Asked<'a>) -> MissConditions<'a> {
        MissConditions {
            asked: *asked,
            measured_ps: asked.truth().delay_ps + asked.offset_ps(),
            code_period_ps: asked.code_period_ps(),
            accepted: Accepted::of(asked),
        }
    }

    pub(super) fn spad(&self) -> &Detector {
        &self.asked.sensor.scene().detectors[self.asked.detector]
    }

    /// Whether no other path of the same source is so near that it takes estimates from this one.
    pub(super) fn is_alone(&self) -> bool {
        let chip_period_ps = self.asked.sensor.clock().chip_period_ps;
        let tolerance_ps = tolerance_ps(chip_period_ps, self.code_period_ps);
        self.accepted == Accepted { low_ps: -tolerance_ps, high_ps: tolerance_ps }
    }

    /// How much later than the path a phase step is, in ps, the shorter way round.
    pub(super) fn step_error_ps(&self, measurement: usize) -> f64 {
        let at_ps = self.asked.sensor.timing().reference_delay_ps(Step::at(measurement));
        delay_error_ps(at_ps, self.measured_ps, self.code_period_ps)
    }
}

/// Share of the accepted errors within which the estimate of the expected counts is
/// far from their rim.
const INSIDE: f64 = 0.9;

impl MissConditions<'_> {
    /// Whether the estimate that `values` give round step `peak` is well within what
    /// is accepted.
    pub(super) fn finds_from(&self, values: &[f64], peak: usize) -> bool {
        let timing = self.asked.sensor.timing();
        let estimate = estimate_at(values, peak, timing, 0.0);
        self.accepts(estimate.delay_ps, INSIDE)
    }

    /// Whether a delay, uncalibrated, is within a share of the accepted errors.
    pub(super) fn accepts(&self, measured_ps: f64, share: f64) -> bool {
        let error_ps = delay_error_ps(measured_ps, self.measured_ps, self.code_period_ps);
        let (low_ps, high_ps) = (self.accepted.low_ps, self.accepted.high_ps);
        low_ps < high_ps && error_ps >= share * low_ps && error_ps <= share * high_ps
    }

    /// Chance that the estimate is accepted if measurement `peak` counts most, `x`.
    ///
    /// The other counts of the window are then below `x`. The estimate is e chips off
    /// where the phase is pi (d - e), with d the step's own distance.
    pub(super) fn found_from(&self, laws: &[CountLaw], peak: usize, x: f64) -> f64 {
        let timing = self.asked.sensor.timing();
        let Ok(window) = window_indices(peak, timing) else {
            let at_ps = self.measured_ps + self.step_error_ps(peak);
            return f64::from(self.accepts(at_ps, 1.0));
        };
        let others = window.filter(|(offset, _)| *offset != 0);
        let of_other = |(offset, index): (i64, usize)| {
            let (mean, variance) = laws[index].given_below(x + 0.5);
            (offset, mean, variance)
        };
        let fundamental = self.fundamental(others.map(of_other).chain([(0, x, 0.0)]));
        self.accepted_angle(&fundamental, self.step_error_ps(peak))
    }

    /// The fundamental of counts with an offset from the coarse step, mean, variance.
    fn fundamental(&self, counts: impl Iterator<Item = (i64, f64, f64)>) -> Planar {
        let samples_per_chip = f64::from(self.asked.sensor.clock().samples_per_chip);
        let mut sum = Planar::default();
        for (offset, mean, variance) in counts {
            let (sin, cos) = (-PI * offset as f64 / samples_per_chip).sin_cos();
            sum.mean[0] += mean * cos;
            sum.mean[1] += mean * sin;
            sum.covariance[0] += variance * cos * cos;
            sum.covariance[1] += variance * sin * sin;
            sum.covariance[2] += variance * cos * sin;
        }
        sum
    }

    /// Chance that a coarse step and a phase together are accepted.
    fn accepted_angle(&self, fundamental: &Planar, step_error_ps: f64) -> f64 {
        let chip_ps = self.asked.sensor.clock().chip_period_ps;
        let turns = [-1.0, 0.0, 1.0].map(|turn| {
            let at_ps = step_error_ps + turn * self.code_period_ps;
            let from = (PI * (at_ps - self.accepted.high_ps) / chip_ps).max(-PI);
            let to = (PI * (at_ps - self.accepted.low_ps) / chip_ps).min(PI);
            match from < to {
                true => fundamental.angle_within(from, to),
                false => 0.0,
            }
        });
        turns.iter().sum::<f64>().min(1.0)
    }
}

/// Chance that a scan finds the path if its period is one window: whichever step
/// counts most, the phase leads to the same place.
pub(super) fn of_whole_period(counts: &ExpectedCounts, target: &MissConditions) -> f64 {
    let moments = counts.second.of_scan();
    let half = i64::from(target.asked.sensor.clock().samples_per_chip);
    let offset = |index: usize| (index as i64 + half) % (2 * half) - half;
    let counted = counts.means.iter().zip(&moments).enumerate();
    let counted = counted.map(|(i, (mean, m))| (offset(i), mean.signed, m.signed_variance));
    target.accepted_angle(&target.fundamental(counted), target.step_error_ps(0))
}

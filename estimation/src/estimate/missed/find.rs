//! How likely the phase leads to the path, from where the coarse stage has put it.

use std::f64::consts::PI;

use super::law::CountLaw;
use super::target::Target;
use super::wedge::Planar;
use crate::estimate::expected_counts::ExpectedCounts;
use crate::estimate::phase::{estimate_at, window_indices};

/// Share of the accepted errors within which the estimate of the expected counts is
/// far from their rim.
const INSIDE: f64 = 0.9;

impl Target<'_> {
    /// Whether the estimate that `values` give round step `peak` is well within what
    /// is accepted.
    pub(super) fn finds_from(&self, values: &[f64], peak: usize) -> bool {
        let timing = self.sensor.timing();
        let estimate = estimate_at(values, peak, timing, 0.0);
        self.accepts(estimate.delay_ps, INSIDE)
    }

    /// Whether a delay, uncalibrated, is within a share of the accepted errors.
    pub(super) fn accepts(&self, measured_ps: f64, share: f64) -> bool {
        let error_ps =
            crate::estimate::delay_error_ps(measured_ps, self.measured_ps, self.code_period_ps);
        let (low_ps, high_ps) = (self.accepted.low_ps, self.accepted.high_ps);
        low_ps < high_ps && error_ps >= share * low_ps && error_ps <= share * high_ps
    }

    /// Chance that the estimate is accepted if measurement `peak` counts most, `x`.
    ///
    /// The other counts of the window are then below `x`. The estimate is e chips off
    /// where the phase is pi (d - e), with d the step's own distance.
    pub(super) fn found_from(&self, laws: &[CountLaw], peak: usize, x: f64) -> f64 {
        let timing = self.sensor.timing();
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
        let samples_per_chip = f64::from(self.sensor.clock().samples_per_chip);
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
        let chip_ps = self.sensor.clock().chip_period_ps;
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
pub(super) fn of_whole_period(counts: &ExpectedCounts, target: &Target) -> f64 {
    let moments = counts.second.of_scan();
    let half = i64::from(target.sensor.clock().samples_per_chip);
    let offset = |index: usize| (index as i64 + half) % (2 * half) - half;
    let counted = counts.means.iter().zip(&moments).enumerate();
    let counted = counted.map(|(i, (mean, m))| (offset(i), mean.signed, m.signed_variance));
    target.accepted_angle(&target.fundamental(counted), target.step_error_ps(0))
}

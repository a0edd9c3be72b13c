//! Which estimates have found a path.

use crate::estimate::{CountingTier, calibration_offset_ps, delay_error_ps, true_delay};
use crate::math::{NormalLaw, PartOfNormal};
use crate::scan::Step;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// How far an estimate may be off for its scan to have found the peak, in ps: a chip,
/// the half-base of the correlation's peak; of a code so short that a chip is more
/// than a quarter of its period (a square wave) a quarter of the period, so that an
/// estimate on the far side of it is never right.
pub fn tolerance_ps(chip_period_ps: f64, code_period_ps: f64) -> f64 {
    chip_period_ps.min(0.25 * code_period_ps)
}

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
    fn of(sensor: &Sensor, path: PathIndex, counting: CountingTier) -> Accepted {
        let own = &sensor.scene().paths[path];
        let code_period_ps = sensor.code_period_of_path_ps(path);
        let tolerance_ps = tolerance_ps(sensor.clock().chip_period_ps, code_period_ps);
        let mut accepted = Accepted { low_ps: -tolerance_ps, high_ps: tolerance_ps };
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

/// Normal errors of a path, in ps, that count for it: none beyond the tolerance, or nearer to
/// another path. Of errors that wrap all count but those nearer to another path.
pub(crate) fn counted_errors_ps(
    sensor: &Sensor,
    path: PathIndex,
    counting: CountingTier,
    errors_ps: NormalLaw,
) -> PartOfNormal {
    let accepted = Accepted::of(sensor, path, counting);
    let tolerance_ps =
        tolerance_ps(sensor.clock().chip_period_ps, sensor.code_period_of_path_ps(path));
    let is_alone = accepted == Accepted { low_ps: -tolerance_ps, high_ps: tolerance_ps };
    match is_alone && errors_wrap(sensor, path) {
        true => PartOfNormal { share: 1.0, part: errors_ps },
        false => errors_ps.within(accepted.low_ps, accepted.high_ps),
    }
}

/// What the chance of a miss depends on, beside the counts.
pub(super) struct Target<'a> {
    pub(super) sensor: &'a Sensor,
    pub(super) detector: DetectorIndex,
    /// Delay that the estimate is held against, with everything constant that is
    /// measured with it.
    pub(super) measured_ps: f64,
    pub(super) code_period_ps: f64,
    pub(super) accepted: Accepted,
}

impl<'a> Target<'a> {
    /// What it depends on for path `path`.
    pub(super) fn new(
        sensor: &'a Sensor,
        detector: DetectorIndex,
        path: PathIndex,
        counting: CountingTier,
    ) -> Target<'a> {
        let truth_ps = true_delay(sensor, path, counting).delay_ps;
        Target {
            sensor,
            detector,
            measured_ps: truth_ps + calibration_offset_ps(sensor, detector, counting),
            code_period_ps: sensor.code_period_of_path_ps(path),
            accepted: Accepted::of(sensor, path, counting),
        }
    }

    /// How much later than the path a phase step is, in ps, the shorter way round.
    pub(super) fn step_error_ps(&self, measurement: usize) -> f64 {
        let at_ps = self.sensor.timing().reference_delay_ps(Step::at(measurement));
        delay_error_ps(at_ps, self.measured_ps, self.code_period_ps)
    }
}

//! What is expected of each sensor, time by time.

use super::{ArchitecturePoint, ComparisonError, Plan, Way};
use crate::estimate::bound::errors_of_fit;
use crate::estimate::coverage::{check_fit, short_steps};
use crate::estimate::estimator::Estimator;
use crate::estimate::evidence::ExpectedErrors;
use crate::estimate::{CountingTier, Prediction, delay_error_ps, distance_m, predict};
use crate::photons::DetectorModel;
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex, Scene};
use crate::sensor::Sensor;

/// The shortest measuring time in code periods, and from one time to the next.
const SHORTEST_PERIODS: u64 = 7;
const NEXT: u64 = 4;
/// Most times.
const MOST_TIMES: usize = 8;
/// A sensor that misses the peak more often is not on the front.
const MOST_MISSES: f64 = 0.01;

/// Where the peak is, and how bright it is.
pub struct PeakLight {
    pub step: u64,
    pub detected_rate_cps: f64,
}

/// The peak of a path in the counts of a sequential sensor.
pub fn peak(scene: &Scene, path: PathIndex) -> Result<PeakLight, ComparisonError> {
    let expected = predict(&Sensor::new(scene), DetectorIndex(0), path, CountingTier::Sampled)?;
    Ok(PeakLight {
        step: expected.estimate.coarse_step,
        detected_rate_cps: expected.detection_rate_hz,
    })
}

/// Measuring times in chips, whole code periods, up to that of a sequential sensor.
pub fn times_chips(sequential: &Sensor) -> Vec<u64> {
    let timing = sequential.timing();
    let longest = u64::try_from(timing.scan_chips()).unwrap_or(u64::MAX);
    let times = (0..MOST_TIMES as u32).map(|time| {
        let periods = SHORTEST_PERIODS * NEXT.pow(time);
        periods.saturating_mul(timing.code_chips())
    });
    let mut times: Vec<u64> = times.collect();
    // At least one time, and the first that is no shorter than the sensor's own.
    let own = times.iter().take_while(|&&chips| chips < longest).count() + 1;
    times.truncate(own);
    times
}

/// The points of a sensor by both estimators, and why there are none of one.
pub fn points(
    plan: &Plan,
    scene: &Scene,
    path: PathIndex,
    times: &[u64],
) -> (Vec<ArchitecturePoint>, Vec<String>) {
    let [mut phases, mut fits] = [EstimatorKind::Fft, EstimatorKind::Model].map(Points::of);
    let groups = Sensor::new(scene).timing().groups();
    let mut too_short = 0;
    for &chips in times {
        let mut at = scene.clone();
        at.estimator = EstimatorKind::Fft;
        at.scan.integration_chips = chips / groups;
        if is_too_short(&at) {
            too_short += 1;
            continue;
        }
        let sensor = Sensor::new(&at);
        // The fit starts where the phase finds the peak: of both how often that is. A step beside
        // the peak may have the largest count, which needs steps outside of the window: the phase
        // is that of a scan that has them.
        let whole = sensor.with(|scene| scene.scan.steps = scene.scan.steps_per_period);
        let phase = predict(&whole, DetectorIndex(0), path, CountingTier::Sampled);
        let phase = phase.map_err(|reason| reason.to_string());
        let of_phase = phase.as_ref().map_err(String::clone);
        phases.add(plan, &sensor, of_phase.map(|p| (p, (p.bias_m, p.std_m))));
        // With total counts, unless the scene says otherwise.
        at.estimator = EstimatorKind::Model;
        let of_fit = phase
            .as_ref()
            .map_err(String::clone)
            .and_then(|phase| Ok((phase, fitted(&Sensor::new(&at), path)?)));
        fits.add(plan, &sensor, of_fit);
    }
    if too_short > 0 {
        phases.remarks.push(format!(
            "{too_short} of {} measuring times are left out: their phase steps are not long \
             beside the detector's memory",
            times.len()
        ));
    }
    phases.points.append(&mut fits.points);
    phases.remarks.append(&mut fits.remarks);
    (phases.points, phases.remarks)
}

/// The points of one estimator, time by time.
struct Points {
    estimator: EstimatorKind,
    points: Vec<ArchitecturePoint>,
    remarks: Vec<String>,
}

impl Points {
    fn of(estimator: EstimatorKind) -> Points {
        Points { estimator, points: Vec::new(), remarks: Vec::new() }
    }

    /// Takes what the phase of a sensor is expected to be, and the estimator's bias and standard
    /// deviation; or why nothing is expected.
    fn add(
        &mut self,
        plan: &Plan,
        sensor: &Sensor,
        expected: Result<(&Prediction, (f64, f64)), String>,
    ) {
        let estimator = self.estimator;
        match expected {
            Ok((phase, (bias_m, std_m))) => {
                let missed_bound = phase.coarse_failure_bound_fraction;
                let measuring_time_s = sensor.timing().scan_duration_ps() * 1e-12;
                self.points.push(ArchitecturePoint {
                    estimator,
                    measuring_time_s,
                    frame_rate_hz: 1.0 / measuring_time_s,
                    bias_m,
                    std_m,
                    rms_error_m: bias_m.hypot(std_m),
                    coarse_failure_bound_fraction: (!plan.near).then_some(missed_bound),
                    pareto: false,
                });
            }
            Err(reason) => {
                let remark = format!("no expectation of {estimator}: {reason}");
                if !self.remarks.contains(&remark) {
                    self.remarks.push(remark);
                }
            }
        }
    }
}

/// Whether steps are not long beside the detector's memory, or no chip at all.
fn is_too_short(scene: &Scene) -> bool {
    scene.scan.integration_chips == 0
        || short_steps(&DetectorModel::new(&Sensor::new(scene), DetectorIndex(0))).check().is_err()
}

/// Bias and standard deviation of the fit's strongest path, or why neither can be expected.
fn fitted(sensor: &Sensor, path: PathIndex) -> Result<(f64, f64), String> {
    let (detector, tier) = (DetectorIndex(0), CountingTier::Sampled);
    let fitted = Estimator::new(sensor, detector, tier).expected_fit();
    let fitted = fitted.map_err(|reason| reason.to_string())?;
    let true_delay_ps = sensor.scene().paths[path].delay_ps;
    let period_ps = sensor.timing().code_period_ps();
    let error_ps = delay_error_ps(fitted.delay_ps, true_delay_ps, period_ps);
    let errors = ExpectedErrors { bias_m: distance_m(error_ps), std_m: fitted.std_m };
    let errors = errors_of_fit(sensor, detector, tier, path, errors);
    let errors = errors.map_err(|reason| reason.to_string())?;
    let covered = check_fit(sensor, detector, path, tier, (&fitted, errors));
    covered.map_err(|reason| reason.to_string())?;
    Ok((errors.bias_m, errors.std_m))
}

/// Marks the points that no other beats in both time and error.
pub fn mark_pareto(ways: &mut [Way]) {
    let counts = |way: &Way, point: &ArchitecturePoint| {
        way.whole_range && point.coarse_failure_bound_fraction.is_some_and(|f| f <= MOST_MISSES)
    };
    let rivals: Vec<(f64, f64)> = ways
        .iter()
        .flat_map(|way| way.points.iter().filter(|point| counts(way, point)))
        .map(|point| (point.measuring_time_s, point.rms_error_m))
        .collect();
    for way in ways {
        let whole_range = way.whole_range;
        for point in &mut way.points {
            let (time, error) = (point.measuring_time_s, point.rms_error_m);
            let found = point.coarse_failure_bound_fraction.is_some_and(|f| f <= MOST_MISSES);
            // Times of one row differ by the chips that are rounded away.
            let beats = |&(t, e): &(f64, f64)| t <= 1.001 * time && e < error;
            point.pareto = whole_range && found && !rivals.iter().any(beats);
        }
    }
}

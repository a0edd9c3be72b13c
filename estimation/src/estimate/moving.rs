//! Mean and scatter of the phase estimator for moving paths.

use std::f64::consts::PI;

use super::fit::moving::MOST_STEPS_MOVED;
use super::phase::window_indices;
use super::prediction::{PhaseAnswer, Prediction, PredictionError};
use super::truth::Asked;
use super::{delay_error_ps, distance_m, still};
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, SecondMoments};
use crate::scan::Step;
use crate::scene::{DetectorIndex, Fluctuation, PathIndex};
use crate::sensor::Sensor;

/// Paths are nudged by this share of a phase step to see what it does.
const NUDGE_STEPS: f64 = 0.02;

/// Predicts for a scene in which paths to the detector move.
///
/// Each phase step of the peak's window is expected to count what it would count
/// if every path stood still where it is in the middle of the step, with that
/// count's variance; with several steps at once the variance is that of paths that
/// stand still. A fluctuation adds the variance of the estimate's linear response
/// to the mean displacements of the steps.
pub(super) fn predict(asked: &Asked) -> Result<Prediction, PredictionError> {
    let Asked { sensor, detector, tier, .. } = *asked;
    let truth = asked.truth();
    let standing = sensor.still_at(truth.at_ps.unwrap_or(0.0));
    let standing = still::predict(&Asked { sensor: &standing, ..*asked })?;

    let timing = sensor.timing();
    let peak = peak_in_scan(sensor, standing.estimate.coarse_step);
    let mut expected = vec![0.0; timing.scan.steps as usize];
    let mut variances = Vec::new();
    for (_, index) in window_indices(peak, timing)? {
        let model = DetectorModel::new(&sensor_in_step(sensor, Step::at(index)), detector);
        let response = MeanResponse::of_tier(&model, tier)?;
        let moments = SecondMoments::new(&response)?.of_step(Step::at(index));
        expected[index] = moments.signed_mean;
        variances.push(moments.signed_variance);
    }
    let answer = PhaseAnswer::round(&expected, timing, peak, asked.offset_ps())?;
    let counted_ps2: f64 = if timing.parallel == 1 {
        let of_steps = answer.slopes_ps.iter().zip(&variances);
        of_steps.map(|((_, slope), variance)| slope * slope * variance).sum()
    } else {
        // Steps that share their light know of each other.
        (standing.std_m / distance_m(1.0)).powi(2)
    };
    let variance_ps2 = with_fluctuations(asked, &answer.slopes_ps, counted_ps2)?;
    let error_ps =
        delay_error_ps(answer.estimate.delay_ps, truth.delay_ps, timing.code_period_ps());
    Ok(Prediction {
        bias_m: distance_m(error_ps),
        std_m: distance_m(f64::sqrt(variance_ps2)),
        estimate: answer.estimate,
        phase_std_rad: PI * variance_ps2.sqrt() / timing.clock.chip_period_ps,
        is_drawn: false,
        ..standing
    })
}

/// The variance of an estimate, in ps^2, with what the fluctuations of the detector's paths
/// add to that of its counts: its linear response to the mean displacements of the steps,
/// each of which has a weight in the delay, in ps.
fn with_fluctuations(
    asked: &Asked,
    weighted: &[(Step, f64)],
    counted_ps2: f64,
) -> Result<f64, PredictionError> {
    let Asked { sensor, detector, .. } = *asked;
    let mut variance_ps2 = counted_ps2;
    for (index, other) in sensor.scene().paths.iter().enumerate() {
        let fluctuation = other.movement.and_then(|movement| movement.fluctuation);
        let Some(fluctuation) = fluctuation.filter(|_| other.detector == detector) else {
            continue;
        };
        let mut responses = Vec::with_capacity(weighted.len());
        for &(step, weight) in weighted {
            let slope = slope_of_step(&Asked { path: PathIndex(index), ..*asked }, step)?;
            responses.push((step, weight * slope));
        }
        for &(a, response_a) in &responses {
            for &(b, response_b) in &responses {
                let correlation = mean_correlation(sensor, &fluctuation, a, b);
                let variance = other.delay_std_ps().powi(2);
                variance_ps2 += response_a * response_b * variance * correlation;
            }
        }
    }
    Ok(variance_ps2)
}

/// Refuses movements that are not slow beside the phase steps.
pub(super) fn check_speed(sensor: &Sensor, detector: DetectorIndex) -> Result<(), PredictionError> {
    let limit_ps = MOST_STEPS_MOVED * sensor.clock().sample_period_ps();
    for (path, of_path) in sensor.scene().paths.iter().enumerate() {
        let walk_ps = (of_path.delay_rate() * sensor.timing().integration_ps()).abs();
        let moved_ps = walk_ps + 2.0 * of_path.delay_std_ps();
        if of_path.detector == detector && moved_ps > limit_ps {
            return Err(PredictionError::MovesTooFast {
                path: PathIndex(path),
                moved_ps,
                limit_ps,
            });
        }
    }
    Ok(())
}

/// Number in the scan of a phase step that belongs to it.
fn peak_in_scan(sensor: &Sensor, phase_step: u64) -> usize {
    let scan = &sensor.timing().scan;
    ((phase_step + scan.steps_per_period - scan.first_step) % scan.steps_per_period) as usize
}

/// The sensor with every path standing still where it is in the middle of a step.
fn sensor_in_step(sensor: &Sensor, step: Step) -> Sensor {
    sensor.still_at(sensor.timing().middle_of_step_ps(step))
}

/// d(count) / d(delay of the path) of a step, per ps.
fn slope_of_step(asked: &Asked, step: Step) -> Result<f64, PredictionError> {
    let Asked { sensor, detector, path, tier } = *asked;
    let nudge_ps = NUDGE_STEPS * sensor.clock().sample_period_ps();
    let nudged = |by_ps: f64| -> Result<f64, PredictionError> {
        let still = sensor_in_step(sensor, step);
        let still = still.with(|scene| scene.paths[path].delay_ps += by_ps);
        let model = DetectorModel::new(&still, detector);
        let response = MeanResponse::of_tier(&model, tier)?;
        Ok(response.expected_count(step))
    };
    Ok((nudged(nudge_ps)? - nudged(-nudge_ps)?) / (2.0 * nudge_ps))
}

/// Correlation of an Ornstein-Uhlenbeck process averaged over step `a` with the
/// same averaged over step `b`.
fn mean_correlation(sensor: &Sensor, fluctuation: &Fluctuation, a: Step, b: Step) -> f64 {
    let duration_ps = sensor.timing().integration_ps();
    let apart_ps =
        (sensor.timing().middle_of_step_ps(a) - sensor.timing().middle_of_step_ps(b)).abs();
    // Durations in correlation times.
    let length = duration_ps / fluctuation.correlation_time_ps;
    let lost = -(-length).exp_m1();
    if apart_ps < 0.5 * duration_ps {
        // Short steps: the difference below would cancel.
        if length < 1e-4 {
            return 1.0 - length / 3.0;
        }
        return 2.0 * (length - lost) / (length * length);
    }
    let gap = (apart_ps - duration_ps) / fluctuation.correlation_time_ps;
    (-gap).exp() * (lost / length).powi(2)
}

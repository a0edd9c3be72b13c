//! Runs of the tiers, and how they compare with the reference.

use std::time::{Duration, Instant};

use super::{FidelityError, FidelityReference, SensorPoint, TargetAgreement, TierPoint};
use crate::estimate::{CountingTier, calibration_offset_ps, predict};
use crate::math::NORMAL_95;
use crate::plan::{Part, Saving};
use crate::scene::{Architecture, DetectorIndex, EstimatorKind, PathIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::path_statistics::PathStatistics;
use crate::simulate::repeat::Simulated;
use crate::simulate::scans::PreparedTier;

/// Numbers of scans that are tried, as far as the time goes, before as many as are
/// needed.
const REPETITIONS: [u64; 11] =
    [10, 30, 100, 300, 1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000];
/// Half-width of a 95 % interval that a target error needs, of the reference and of a
/// tier: of their difference it is then 0.47 of the target, and a tier without error
/// of its own stays within the target 97 times of 100.
pub const RESOLUTION: f64 = 1.0 / 3.0;
/// A last run is worth its time if it has so many times the scans of the one before.
const WORTH: f64 = 1.5;

/// One run of one tier.
#[derive(Debug, Clone)]
pub struct TierRun {
    tier: Tier,
    pub repetitions: u64,
    pub run_time_s: f64,
    pub statistics: PathStatistics,
}

/// Runs a tier with more and more scans, until they resolve the target error or the
/// next run would not fit into `budget`; at least the first.
pub fn grow(
    sensor: &Sensor,
    prepared: &PreparedTier,
    path: PathIndex,
    seed: u64,
    (budget, target_error): (Duration, f64),
) -> Result<Vec<TierRun>, FidelityError> {
    let tier = prepared.tier();
    let mut runs: Vec<TierRun> = Vec::new();
    // The runs of all tiers are held against expectations together.
    let simulated = Simulated::new(sensor, tier.scans(0).seeded(seed))?;
    let simulated = simulated.one_of(Tier::ALL.len() * REPETITIONS.len());
    let started = Instant::now();
    let mut repetitions = REPETITIONS[0];
    loop {
        let gathered = simulated.gather(prepared, 0..repetitions, &mut |_| ())?;
        let simulation = simulated.conclude(gathered)?;
        let mut statistics = simulation.estimates.into_iter();
        let run = TierRun {
            tier,
            repetitions,
            run_time_s: simulation.run_time_s,
            statistics: statistics.find(|e| e.path == path).ok_or(FidelityError::NoPath)?,
        };
        let needed = needed_scans(&run, target_error * RESOLUTION);
        runs.push(run);
        let next = REPETITIONS.iter().find(|&&n| n > repetitions);
        let (Some(&next), true) = (next, tier.draws()) else {
            break;
        };
        // The last few scans hardly cost more than another run.
        let next = match needed {
            Some(needed) if needed <= repetitions => break,
            Some(needed) if needed < 2 * next => needed,
            _ => next,
        };
        let left_s = budget.as_secs_f64() - started.elapsed().as_secs_f64();
        let times: Vec<_> = runs.iter().map(|r| (r.repetitions, r.run_time_s)).collect();
        let (set_up_s, per_scan_s) = cost(&times).unwrap_or_default();
        let affordable = ((left_s - set_up_s) / per_scan_s).max(0.0) as u64;
        if (affordable as f64) < WORTH * repetitions as f64 && affordable < next {
            break;
        }
        repetitions = next.min(affordable);
    }
    Ok(runs)
}

/// Scans that bring the half-widths of the 95 % intervals of standard deviation and
/// bias (in standard deviations) and of the share of missed peaks down to
/// `half_width`; none without a scatter to go by.
pub fn needed_scans(run: &TierRun, half_width: f64) -> Option<u64> {
    let s = &run.statistics;
    let (std_m, bias_std_error_m, std_std_error_m) =
        (s.std_m?, s.bias_std_error_m?, s.std_std_error_m?);
    if s.estimates < 10 || std_m <= 0.0 {
        return None;
    }
    let n = run.repetitions as f64;
    let standard_error = bias_std_error_m.max(std_std_error_m) / std_m;
    let of_moments = n * (NORMAL_95 * standard_error / half_width).powi(2);
    let missed = s.missed_fraction?;
    // Wilson's interval of none of n is z^2 / n wide.
    let of_missed = missed * (1.0 - missed) * (NORMAL_95 / half_width).powi(2)
        + NORMAL_95 * NORMAL_95 / half_width;
    Some(of_moments.max(of_missed).ceil() as u64)
}

/// Time before the first scan, and of each scan. Where more scans took no longer than fewer, by the chance of a busy machine,
/// all of the time is the scans'.
pub fn cost(runs: &[(u64, f64)]) -> Option<(f64, f64)> {
    let &(most, most_s) = runs.iter().max_by_key(|(n, _)| *n)?;
    // What a tier sets up before its first scan is in every run's time.
    let fewer = runs.iter().filter(|(n, _)| *n < most);
    let (fewest, least_s) = fewer.min_by_key(|(n, _)| *n).copied().unwrap_or((0, 0.0));
    if most_s <= least_s {
        return Some((0.0, most_s / most.max(1) as f64));
    }
    let per_scan_s = (most_s - least_s) / (most - fewest).max(1) as f64;
    Some(((least_s - per_scan_s * fewest as f64).max(0.0), per_scan_s))
}

/// The reference that a run gives.
pub fn reference(run: Option<&TierRun>) -> Result<FidelityReference, FidelityError> {
    let run = run.ok_or(FidelityError::NoPath)?;
    let s = &run.statistics;
    let missed = s.missed_fraction.zip(s.missed_fraction_ci95);
    match (s.std_m, s.std_std_error_m, s.bias_m, s.bias_std_error_m, missed) {
        (
            Some(std_m),
            Some(std_std_error_m),
            Some(bias_m),
            Some(bias_std_error_m),
            Some(missed),
        ) if std_m > 0.0 => Ok(FidelityReference {
            fidelity: super::REFERENCE_NAME,
            repetitions: run.repetitions,
            run_time_s: run.run_time_s,
            std_m,
            std_std_error_m,
            bias_m,
            bias_std_error_m,
            missed_fraction: missed.0,
            missed_fraction_ci95: missed.1,
            expectation_holds: s.expectation_holds,
            expectation_remark: s.expectation_remark.clone(),
        }),
        _ => Err(match &s.remark {
            Some(remark) if s.estimates > 1 => FidelityError::NoScatter(remark.clone()),
            _ => FidelityError::NoEstimates(run.repetitions),
        }),
    }
}

/// Holds a run's standard deviation, bias and share of missed peaks against the
/// reference's, with the standard errors of both; none where the run has too few
/// estimates.
pub fn point(run: &TierRun, reference: &FidelityReference, target_error: f64) -> Option<TierPoint> {
    let s = &run.statistics;
    let (std_m, bias_m) = (s.std_m?, s.bias_m?);
    // What draws nothing has no errors of its own.
    let [std_std_error_m, bias_std_error_m] =
        if run.tier.draws() { [s.std_std_error_m?, s.bias_std_error_m?] } else { [0.0, 0.0] };
    let interval = |error: f64, standard_error: f64| {
        [error - NORMAL_95 * standard_error, error + NORMAL_95 * standard_error]
    };
    let ratio = std_m / reference.std_m;
    let bias_error = (bias_m - reference.bias_m) / reference.std_m;
    // Of its logarithm: no standard deviation is less than nothing.
    let of_ratio = (std_std_error_m / std_m).hypot(reference.std_std_error_m / reference.std_m);
    let of_bias = bias_std_error_m.hypot(reference.bias_std_error_m) / reference.std_m;
    let missed_ci = s.missed_fraction.map(|missed| {
        let own = s.missed_fraction_ci95.unwrap_or([missed; 2]);
        difference((missed, own), (reference.missed_fraction, reference.missed_fraction_ci95))
    });
    let mut point = TierPoint {
        fidelity: run.tier.to_string(),
        repetitions: run.tier.draws().then_some(run.repetitions),
        run_time_s: run.run_time_s,
        std_m,
        bias_m,
        missed_fraction: s.missed_fraction,
        missed_fraction_ci95: s.missed_fraction_ci95,
        std_relative_error: ratio - 1.0,
        std_relative_error_ci95: [-NORMAL_95, NORMAL_95]
            .map(|z| ratio * (z * of_ratio).exp() - 1.0),
        bias_error_in_std: bias_error,
        bias_error_in_std_ci95: interval(bias_error, of_bias),
        missed_fraction_error: s.missed_fraction.map(|m| m - reference.missed_fraction),
        missed_fraction_error_ci95: missed_ci,
        verdict: TargetAgreement::Unresolved,
        pareto: false,
    };
    point.verdict = match run.tier {
        // It is the reference.
        Tier::Sampled => TargetAgreement::Holds,
        _ => point.judge(target_error),
    };
    Some(point)
}

impl TierPoint {
    /// Whether all three errors are seen to be within the target.
    fn judge(&self, target_error: f64) -> TargetAgreement {
        let Some(missed_ci) = self.missed_fraction_error_ci95 else {
            return TargetAgreement::Unresolved;
        };
        let intervals = [self.std_relative_error_ci95, self.bias_error_in_std_ci95, missed_ci];
        if intervals.iter().all(|&ci| worst(ci) <= target_error) {
            TargetAgreement::Holds
        } else if intervals.iter().any(|&ci| least(ci) > target_error) {
            TargetAgreement::Differs
        } else {
            TargetAgreement::Unresolved
        }
    }
}

/// 95 % interval of the difference of two shares from the interval of each (Newcombe
/// 1998, method 10).
fn difference(a: (f64, [f64; 2]), b: (f64, [f64; 2])) -> [f64; 2] {
    let found = a.0 - b.0;
    [found - (a.0 - a.1[0]).hypot(b.1[1] - b.0), found + (a.1[1] - a.0).hypot(b.0 - b.1[0])]
}

/// Largest error that a confidence interval holds.
pub fn worst(interval: [f64; 2]) -> f64 {
    interval[0].abs().max(interval[1].abs())
}

/// Smallest error that a confidence interval holds.
fn least([low, high]: [f64; 2]) -> f64 {
    if low <= 0.0 && high >= 0.0 {
        return 0.0;
    }
    low.abs().min(high.abs())
}

/// Powers and integration times, relative to the scene's.
const POWERS: [f64; 4] = [0.1, 0.3, 1.0, 3.0];
const INTEGRATIONS: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];

/// Expected error of the distance over integration time at several light levels.
/// Where the counts have no expected peak there is no point.
pub fn trade(scene: &Scene, path: PathIndex) -> Vec<SensorPoint> {
    let mut points = Vec::new();
    for relative_power in POWERS {
        for factor in INTEGRATIONS {
            let mut other = scene.clone();
            // The trade is that of the phase estimator, its misses too.
            other.estimator = EstimatorKind::Fft;
            for source in &mut other.sources {
                source.mean_power_w *= relative_power;
            }
            let whole_chips = match scene.hardware.architecture {
                Architecture::UpDown => 1,
                // Whole code periods.
                Architecture::Histogram => Sensor::new(scene).timing().code_chips(),
            } as f64;
            let times = (scene.scan.integration_chips as f64 * factor / whole_chips).round();
            let chips = times.max(1.0) * whole_chips;
            other.scan.integration_chips = chips as u64;
            let Ok(expected) =
                predict(&Sensor::new(&other), DetectorIndex(0), path, CountingTier::Sampled)
            else {
                continue;
            };
            points.push(SensorPoint {
                relative_power,
                detected_rate_cps: expected.detection_rate_hz,
                integration_s: scene.clock().ps(chips) * 1e-12,
                std_m: expected.std_m,
                bias_m: expected.bias_m,
                coarse_failure_bound_fraction: expected.coarse_failure_bound_fraction,
                missed_fraction: expected.missed_fraction,
            });
        }
    }
    points
}

/// Expected misses of the whole scan that a window may leave out, in target errors.
const LEFT_OUT: f64 = 0.01;

/// The sensor with only the phase steps that the fine stage needs, two chips on
/// either side of the path's peak (whole groups of them), and what that saved.
///
/// Steps elsewhere decide how many scans miss the peak. They are left out only where
/// that is expected to be next to nothing beside the target error, by the sum of the
/// chances of all of them.
pub fn round_peak(sensor: &Sensor, path: PathIndex, target_error: f64) -> (Sensor, Option<Part>) {
    let scene = sensor.scene();
    if scene.hardware.architecture == Architecture::Histogram {
        // Its bins make up the whole range.
        return (sensor.clone(), None);
    }
    let step_ps = sensor.clock().sample_period_ps();
    let offset_ps = calibration_offset_ps(sensor, DetectorIndex(0), CountingTier::Sampled);
    let period = scene.scan.steps_per_period;
    let peak = ((scene.paths[path].delay_ps + offset_ps) / step_ps).round() as u64 % period;
    let half = 2 * u64::from(scene.samples_per_chip);
    let steps = (2 * half + 1).next_multiple_of(u64::from(scene.hardware.parallel));
    if !scene.scan.is_full() || steps >= period {
        return (sensor.clone(), None);
    }
    let missed = match predict(sensor, DetectorIndex(0), path, CountingTier::Sampled) {
        Ok(expected) if expected.coarse_failure_bound_fraction <= LEFT_OUT * target_error => {
            expected.coarse_failure_bound_fraction
        }
        _ => return (sensor.clone(), None),
    };
    let windowed = sensor.with(|scene| {
        scene.scan.first_step = (peak + period - half) % period;
        scene.scan.steps = steps;
    });
    let part = Part {
        part: "phase_steps_away_from_the_peak".to_owned(),
        kept: false,
        reason: format!(
            "the fine stage needs {steps} of {period} phase steps, and the others are expected to \
             mislead at most {:.1e} of the scans",
            missed
        ),
        saving: Some(Saving {
            time_fraction: 1.0 - steps as f64 / period as f64,
            basis: "share of the phase steps: photons and clocks".to_owned(),
        }),
        saved_cells: None,
    };
    (windowed, Some(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_of_shares_has_the_published_interval() {
        // Newcombe 1998, example a: 56/70 less 48/80 is 0.2, 0.0524 to 0.3339.
        let share = |k: f64, n: f64| {
            let (p, z2) = (k / n, NORMAL_95 * NORMAL_95);
            let half = NORMAL_95 * (p * (1.0 - p) / n + 0.25 * z2 / (n * n)).sqrt();
            let [low, high] = [-half, half].map(|h| (p + 0.5 * z2 / n + h) / (1.0 + z2 / n));
            (p, [low, high])
        };
        let [low, high] = difference(share(56.0, 70.0), share(48.0, 80.0));
        assert!((low - 0.0524).abs() < 2e-4 && (high - 0.3339).abs() < 2e-4, "{low} {high}");
    }

    #[test]
    fn set_up_and_scans_are_told_apart() {
        // 20 ms and 1 us a scan.
        let (set_up_s, per_scan_s) = cost(&[(1_000, 0.021), (100_000, 0.120)]).unwrap();
        assert!((set_up_s - 0.020).abs() < 1e-12 && (per_scan_s - 1e-6).abs() < 1e-15);
        // On a machine that was busy with fewer of them.
        assert_eq!(cost(&[(10, 0.3), (100, 0.2)]), Some((0.0, 0.002)));
    }
}

//! Error against run time, tier by tier: the JSON of `goldtof fidelity`.
//!
//! The reference is the sampled tier with as many scans as the time allows: it is
//! bit for bit the hardware. Each tier's standard deviation and bias are held
//! against it, with the standard errors of both.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::Tier;
use super::scans::ScansError;
use super::simulate::{PathStatistics, simulate};
use crate::estimate::{CountingTier, calibration_offset_ps, predict};
use crate::plan::{self, Part};
use crate::scene::{Scan, Scene};

/// Two-sided 95 % quantile of the normal distribution.
const Z_95: f64 = 1.96;
/// Numbers of scans that are tried, as far as the time goes.
const REPETITIONS: [u64; 8] = [10, 30, 100, 300, 1_000, 3_000, 10_000, 30_000];

/// What `goldtof fidelity` gives.
#[derive(Debug, Clone, Serialize)]
pub struct FidelityReport {
    /// The scene's name.
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The tier that the others are held against, and its number of scans.
    pub reference: Reference,
    /// Every tier at every number of scans that was run.
    pub tiers: Vec<TierPoint>,
    /// The cheapest way to the error that was asked for.
    pub recommended: Option<Recommendation>,
    /// The sensor's own trade: error of the distance against integration time
    /// and light.
    pub sensor: Vec<SensorPoint>,
    /// Parts of the simulation that the scene does without.
    pub left_out: Vec<Part>,
}

/// The reference.
#[derive(Debug, Clone, Serialize)]
pub struct Reference {
    /// Its name.
    pub name: &'static str,
    /// Scans.
    pub repetitions: u64,
    /// Standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Standard error of that.
    pub std_std_error_m: f64,
    /// Mean error.
    pub bias_m: f64,
    /// Standard error of that.
    pub std_error_m: f64,
}

/// One tier at one number of scans.
#[derive(Debug, Clone, Serialize)]
pub struct TierPoint {
    /// Name of the tier.
    pub name: String,
    /// Scans; none for the tier that draws no random numbers.
    pub repetitions: Option<u64>,
    /// Wall time.
    pub run_time_s: f64,
    /// Standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Mean error.
    pub bias_m: f64,
    /// (standard deviation - reference's) / reference's.
    pub error_vs_reference: f64,
    /// Its 95 % confidence interval, from the standard errors of both.
    pub error_ci: [f64; 2],
    /// (bias - reference's) / reference's standard deviation.
    pub bias_error_vs_reference: f64,
    /// Its 95 % confidence interval.
    pub bias_error_ci: [f64; 2],
    /// No other point is both faster and surer.
    pub pareto: bool,
}

impl TierPoint {
    /// Largest relative error of the standard deviation that its confidence
    /// interval holds.
    fn worst_error(&self) -> f64 {
        self.error_ci[0].abs().max(self.error_ci[1].abs())
    }
}

/// The cheapest tier for an error.
#[derive(Debug, Clone, Serialize)]
pub struct Recommendation {
    /// The error that was asked for, of the standard deviation, relative.
    pub target_error: f64,
    /// Name of the tier.
    pub name: String,
    /// Scans to run; none for the tier that draws no random numbers.
    pub repetitions: Option<u64>,
    /// Wall time that they take.
    pub run_time_s: f64,
}

/// The sensor at one light level and integration time.
#[derive(Debug, Clone, Serialize)]
pub struct SensorPoint {
    /// Power of every source, relative to the scene's.
    pub relative_power: f64,
    /// Rate of counted detections.
    pub detected_rate_cps: f64,
    /// Integration time per phase step.
    pub integration_s: f64,
    /// Expected standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Expected bias, which no integration removes.
    pub bias_m: f64,
}

/// Why tiers could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum FidelityError {
    /// A tier failed.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// No path of the detector's own source.
    #[error(
        "no path leads from the first detector's own source to it, so there is no error to compare"
    )]
    NoPath,
    /// The reference gave too few estimates.
    #[error(
        "the reference tier found the path in fewer than two of {0} scans: more light, or a longer integration, is needed"
    )]
    NoEstimates(u64),
}

/// Compares tiers on the first detector's first own path, within about
/// `budget` of wall time.
///
/// # Errors
/// When a tier cannot do the scene, or there is nothing to compare.
pub fn compare(
    scene: &Scene,
    seed: u64,
    budget: Duration,
    target_error: f64,
) -> Result<FidelityReport, FidelityError> {
    let own = scene.detectors[0].reference;
    let path = (0..scene.paths.len())
        .find(|&p| scene.paths[p].detector == 0 && scene.paths[p].source == own)
        .ok_or(FidelityError::NoPath)?;
    let (scene_run, windowed) = window_round_peak(scene, path);
    let share = budget / 4;

    let (reference_points, sampled) = grow(&scene_run, Tier::Sampled, path, seed, share * 2)?;
    let reference = reference_of(&sampled, reference_points.last().map_or(0, |p| p.0))?;
    let mut tiers = Vec::new();
    for (repetitions, run_time_s, statistics) in &reference_points[..reference_points.len() - 1] {
        tiers.extend(point(
            "sampled",
            *repetitions,
            *run_time_s,
            statistics,
            &reference,
        ));
    }
    // Other random numbers than the reference's, or the errors would be shared.
    for tier in [Tier::Events, Tier::Rtl] {
        let (points, _) = grow(&scene_run, tier, path, seed ^ 0x5bd1_e995, share)?;
        for (repetitions, run_time_s, statistics) in &points {
            let name = tier.to_string();
            tiers.extend(point(
                &name,
                *repetitions,
                *run_time_s,
                statistics,
                &reference,
            ));
        }
    }
    tiers.extend(expected_point(&scene_run, path, &reference));
    mark_pareto(&mut tiers);
    let mut left_out: Vec<Part> = plan::plan(scene)
        .simulation
        .into_iter()
        .filter(|part| !part.kept)
        .collect();
    left_out.extend(windowed);
    Ok(FidelityReport {
        scene: scene.name.clone(),
        seed,
        recommended: recommend(&tiers, &reference, target_error),
        reference,
        tiers,
        sensor: sensor_trade(&scene_run, path),
        left_out,
    })
}

/// The scene with only the phase steps that the fine stage needs, two chips on
/// either side of the path's peak, and what that saves.
fn window_round_peak(scene: &Scene, path: usize) -> (Scene, Option<Part>) {
    let mut windowed = scene.clone();
    let step_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
    let offset_ps = calibration_offset_ps(scene, 0, CountingTier::Sampled);
    let period = scene.scan.steps_per_period;
    let peak = ((scene.paths[path].delay_ps + offset_ps) / step_ps).round() as u64 % period;
    let half = 2 * u64::from(scene.samples_per_chip);
    let steps = 2 * half + 1;
    if !scene.scan.is_full() || steps >= period {
        return (windowed, None);
    }
    windowed.scan = Scan {
        first_step: (peak + period - half) % period,
        steps,
        ..scene.scan
    };
    let part = Part {
        part: "phase_steps_away_from_the_peak".to_owned(),
        kept: false,
        reason: format!(
            "the fine stage needs {steps} of {period} phase steps; leaving the others out saves \
             {:.1} % of the simulation",
            100.0 * (1.0 - steps as f64 / period as f64)
        ),
    };
    (windowed, Some(part))
}

/// Number of scans, wall time, statistics.
type Run = (u64, f64, PathStatistics);

/// Runs a tier with more and more scans until the next run would not fit into
/// `budget`; at least the first.
fn grow(
    scene: &Scene,
    tier: Tier,
    path: usize,
    seed: u64,
    budget: Duration,
) -> Result<(Vec<Run>, PathStatistics), FidelityError> {
    let mut runs: Vec<Run> = Vec::new();
    let started = Instant::now();
    for repetitions in REPETITIONS {
        if let Some((done, run_time_s, _)) = runs.last() {
            let next_s = run_time_s * repetitions as f64 / *done as f64;
            if started.elapsed().as_secs_f64() + next_s > budget.as_secs_f64() {
                break;
            }
        }
        let simulation = simulate(scene, tier, seed, repetitions)?;
        let statistics = simulation
            .estimates
            .into_iter()
            .find(|e| e.path == path)
            .ok_or(FidelityError::NoPath)?;
        runs.push((repetitions, simulation.run_time_s, statistics));
    }
    let last = runs.last().map(|run| run.2.clone());
    Ok((runs, last.ok_or(FidelityError::NoPath)?))
}

fn reference_of(statistics: &PathStatistics, repetitions: u64) -> Result<Reference, FidelityError> {
    match (
        statistics.std_m,
        statistics.std_std_error_m,
        statistics.bias_m,
        statistics.std_error_m,
    ) {
        (Some(std_m), Some(std_std_error_m), Some(bias_m), Some(std_error_m)) if std_m > 0.0 => {
            Ok(Reference {
                name: "sampled",
                repetitions,
                std_m,
                std_std_error_m,
                bias_m,
                std_error_m,
            })
        }
        _ => Err(FidelityError::NoEstimates(repetitions)),
    }
}

fn point(
    name: &str,
    repetitions: u64,
    run_time_s: f64,
    statistics: &PathStatistics,
    reference: &Reference,
) -> Option<TierPoint> {
    let errors = [statistics.std_std_error_m?, statistics.std_error_m?];
    let values = [statistics.std_m?, statistics.bias_m?];
    Some(against(
        name,
        Some(repetitions),
        run_time_s,
        values,
        errors,
        reference,
    ))
}

/// Holds a standard deviation and a bias, with their standard errors, against
/// the reference.
fn against(
    name: &str,
    repetitions: Option<u64>,
    run_time_s: f64,
    [std_m, bias_m]: [f64; 2],
    [std_std_error_m, std_error_m]: [f64; 2],
    reference: &Reference,
) -> TierPoint {
    let interval = |error: f64, standard_error: f64| {
        [error - Z_95 * standard_error, error + Z_95 * standard_error]
    };
    let std_error = (std_m - reference.std_m) / reference.std_m;
    let bias_error = (bias_m - reference.bias_m) / reference.std_m;
    let of_std = std_std_error_m.hypot(reference.std_std_error_m) / reference.std_m;
    let of_bias = std_error_m.hypot(reference.std_error_m) / reference.std_m;
    TierPoint {
        name: name.to_owned(),
        repetitions,
        run_time_s,
        std_m,
        bias_m,
        error_vs_reference: std_error,
        error_ci: interval(std_error, of_std),
        bias_error_vs_reference: bias_error,
        bias_error_ci: interval(bias_error, of_bias),
        pareto: false,
    }
}

/// The exact mean response: no random numbers, so no standard error of its own.
fn expected_point(scene: &Scene, path: usize, reference: &Reference) -> Option<TierPoint> {
    let started = Instant::now();
    let expected = predict(scene, 0, path, CountingTier::Sampled).ok()?;
    let run_time_s = started.elapsed().as_secs_f64();
    let values = [expected.std_m, expected.bias_m];
    Some(against(
        "expected",
        None,
        run_time_s,
        values,
        [0.0, 0.0],
        reference,
    ))
}

fn mark_pareto(tiers: &mut [TierPoint]) {
    let points: Vec<(f64, f64)> = tiers
        .iter()
        .map(|tier| (tier.run_time_s, tier.worst_error()))
        .collect();
    for (tier, &(time, error)) in tiers.iter_mut().zip(&points) {
        tier.pareto = !points
            .iter()
            .any(|&(t, e)| t <= time && e <= error && (t, e) != (time, error));
    }
}

/// The cheapest tier whose own random error is below the target and whose
/// difference from the reference is no larger than chance and target together.
fn recommend(
    tiers: &[TierPoint],
    reference: &Reference,
    target_error: f64,
) -> Option<Recommendation> {
    let chance = Z_95 * reference.std_std_error_m / reference.std_m;
    let agrees = |tier: &TierPoint| {
        let half = (tier.error_ci[1] - tier.error_ci[0]) / 2.0;
        tier.error_vs_reference.abs() <= half.max(chance) + target_error
    };
    let cost = |tier: &TierPoint| match tier.repetitions {
        None => (None, tier.run_time_s),
        Some(repetitions) => {
            // The relative standard error of a standard deviation of n normal
            // numbers is 1 / sqrt(2 (n - 1)).
            let needed = (0.5 * (Z_95 / target_error).powi(2)).ceil() as u64 + 1;
            let per_scan_s = tier.run_time_s / repetitions as f64;
            (Some(needed), per_scan_s * needed as f64)
        }
    };
    // Of each tier the run with the most scans, whose time per scan is surest.
    tiers
        .iter()
        .filter(|tier| {
            !tiers
                .iter()
                .any(|other| other.name == tier.name && other.repetitions > tier.repetitions)
        })
        .filter(|tier| agrees(tier))
        .map(|tier| (tier, cost(tier)))
        .min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b))
        .map(|(tier, (repetitions, run_time_s))| Recommendation {
            target_error,
            name: tier.name.clone(),
            repetitions,
            run_time_s,
        })
}

/// Expected error of the distance over integration time at several light levels.
fn sensor_trade(scene: &Scene, path: usize) -> Vec<SensorPoint> {
    let mut points = Vec::new();
    for relative_power in [0.1, 0.3, 1.0, 3.0] {
        for factor in [0.1, 0.3, 1.0, 3.0, 10.0] {
            let mut other = scene.clone();
            for source in &mut other.sources {
                source.mean_power_w *= relative_power;
            }
            let chips = (scene.scan.integration_chips as f64 * factor)
                .round()
                .max(1.0);
            other.scan.integration_chips = chips as u64;
            let Ok(expected) = predict(&other, 0, path, CountingTier::Sampled) else {
                continue;
            };
            points.push(SensorPoint {
                relative_power,
                detected_rate_cps: expected.detection_rate_hz,
                integration_s: chips * scene.chip_period_ps * 1e-12,
                std_m: expected.std_m,
                bias_m: expected.bias_m,
            });
        }
    }
    points
}

impl FidelityReport {
    /// The report in words.
    pub fn to_text(&self) -> String {
        let r = &self.reference;
        let mut text = format!(
            "{}, seed {}; reference: {} with {} scans, standard deviation {:.3} +- {:.3} mm, bias \
             {:.3} +- {:.3} mm\n\n",
            self.scene,
            self.seed,
            r.name,
            r.repetitions,
            r.std_m * 1e3,
            r.std_std_error_m * 1e3,
            r.bias_m * 1e3,
            r.std_error_m * 1e3,
        );
        let _ = writeln!(
            text,
            "{:10} {:>7} {:>10} {:>9} {:>9}  {:>24}  {:>24}",
            "tier", "scans", "time s", "std mm", "bias mm", "error of std, 95 %", "of bias, in std"
        );
        let interval = |error: f64, ci: [f64; 2]| {
            format!(
                "{:+.2} % [{:+.2}, {:+.2}]",
                error * 100.0,
                ci[0] * 100.0,
                ci[1] * 100.0
            )
        };
        for tier in &self.tiers {
            let scans = tier.repetitions.map_or("-".to_owned(), |n| n.to_string());
            let _ = writeln!(
                text,
                "{:10} {:>7} {:>10.4} {:>9.3} {:>9.3}  {:>24}  {:>24}{}",
                tier.name,
                scans,
                tier.run_time_s,
                tier.std_m * 1e3,
                tier.bias_m * 1e3,
                interval(tier.error_vs_reference, tier.error_ci),
                interval(tier.bias_error_vs_reference, tier.bias_error_ci),
                if tier.pareto { "  Pareto" } else { "" },
            );
        }
        if let Some(best) = &self.recommended {
            let scans = best
                .repetitions
                .map_or(String::new(), |n| format!(" with {n} scans"));
            let _ = writeln!(
                text,
                "\nfor an error of {} % of the standard deviation: {}{scans}, {:.3} s",
                best.target_error * 100.0,
                best.name,
                best.run_time_s
            );
        }
        let _ = writeln!(
            text,
            "\n{:>10} {:>12} {:>16} {:>9} {:>9}",
            "power", "Mcps", "integration us", "std mm", "bias mm"
        );
        for point in &self.sensor {
            let _ = writeln!(
                text,
                "{:>9}x {:>12.3} {:>16.1} {:>9.3} {:>9.3}",
                point.relative_power,
                point.detected_rate_cps / 1e6,
                point.integration_s * 1e6,
                point.std_m * 1e3,
                point.bias_m * 1e3
            );
        }
        text.push('\n');
        for part in &self.left_out {
            let _ = writeln!(text, "left out: {} ({})", part.part, part.reason);
        }
        text
    }
}

//! Runs of the tiers, and how they compare with the reference.

use std::time::{Duration, Instant};

use super::{FidelityError, Reference, TierPoint};
use crate::fidelity::Tier;
use crate::fidelity::scans::Prepared;
use crate::fidelity::simulate::{PathStatistics, simulate_prepared};
use crate::scene::Scene;

/// Two-sided 95 % quantile of the normal distribution.
pub const Z_95: f64 = 1.96;
/// Numbers of scans that are tried, as far as the time goes.
const REPETITIONS: [u64; 8] = [10, 30, 100, 300, 1_000, 3_000, 10_000, 30_000];

/// One run of one tier.
#[derive(Debug, Clone)]
pub struct Run {
    tier: Tier,
    repetitions: u64,
    run_time_s: f64,
    statistics: PathStatistics,
}

/// Runs a tier with more and more scans until the next run would not fit into
/// `budget`; at least the first.
pub fn grow(
    scene: &Scene,
    prepared: &Prepared,
    path: usize,
    seed: u64,
    budget: Duration,
) -> Result<Vec<Run>, FidelityError> {
    let tier = prepared.tier();
    let mut runs: Vec<Run> = Vec::new();
    let started = Instant::now();
    for repetitions in REPETITIONS {
        if let Some(last) = runs.last() {
            let next_s = last.run_time_s * repetitions as f64 / last.repetitions as f64;
            let spent_s = started.elapsed().as_secs_f64();
            if !tier.draws() || spent_s + next_s > budget.as_secs_f64() {
                break;
            }
        }
        let simulation = simulate_prepared(scene, prepared, seed, repetitions)?;
        let mut statistics = simulation.estimates.into_iter();
        runs.push(Run {
            tier,
            repetitions,
            run_time_s: simulation.run_time_s,
            statistics: statistics
                .find(|e| e.path == path)
                .ok_or(FidelityError::NoPath)?,
        });
    }
    Ok(runs)
}

/// The reference that a run gives.
pub fn reference(run: Option<Run>) -> Result<Reference, FidelityError> {
    let run = run.ok_or(FidelityError::NoPath)?;
    let s = &run.statistics;
    match (s.std_m, s.std_std_error_m, s.bias_m, s.std_error_m) {
        (Some(std_m), Some(std_std_error_m), Some(bias_m), Some(std_error_m)) if std_m > 0.0 => {
            Ok(Reference {
                name: "sampled",
                repetitions: run.repetitions,
                run_time_s: run.run_time_s,
                std_m,
                std_std_error_m,
                bias_m,
                std_error_m,
            })
        }
        _ => Err(FidelityError::NoEstimates(run.repetitions)),
    }
}

/// Holds a run's standard deviation and bias against the reference's, with the
/// standard errors of both; none where the run has too few estimates.
pub fn point(run: &Run, reference: &Reference) -> Option<TierPoint> {
    let s = &run.statistics;
    let (std_m, bias_m) = (s.std_m?, s.bias_m?);
    // What draws nothing has no errors of its own.
    let [std_std_error_m, std_error_m] = if run.tier.draws() {
        [s.std_std_error_m?, s.std_error_m?]
    } else {
        [0.0, 0.0]
    };
    let interval = |error: f64, standard_error: f64| {
        [error - Z_95 * standard_error, error + Z_95 * standard_error]
    };
    let std_error = (std_m - reference.std_m) / reference.std_m;
    let bias_error = (bias_m - reference.bias_m) / reference.std_m;
    let of_std = std_std_error_m.hypot(reference.std_std_error_m) / reference.std_m;
    let of_bias = std_error_m.hypot(reference.std_error_m) / reference.std_m;
    Some(TierPoint {
        name: run.tier.to_string(),
        repetitions: run.tier.draws().then_some(run.repetitions),
        run_time_s: run.run_time_s,
        std_m,
        bias_m,
        error_vs_reference: std_error,
        error_ci: interval(std_error, of_std),
        bias_error_vs_reference: bias_error,
        bias_error_ci: interval(bias_error, of_bias),
        pareto: false,
    })
}

/// Largest error that a confidence interval holds.
pub fn worst(interval: [f64; 2]) -> f64 {
    interval[0].abs().max(interval[1].abs())
}

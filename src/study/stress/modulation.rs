//! Light without modulation, all modulation, and modulation behind a bright background.

use super::prelude::*;
use crate::estimate::PredictionError;
use crate::estimate::report::Reporter;
use crate::response::CountMoments;

pub(super) const CASES: &[Case] = cases! {
    Light quick "extinction-ratio-1-is-expected-flat":
        "tiers that predict a distance for unmodulated light",
        "an extinction ratio of 1 carries no code: every phase step expects the same count",
        |_| unmodulated_prediction();
    Light quick "extinction-ratio-1-gives-no-estimate":
        "estimates from the noise of unmodulated light, in 10 scans, by phase and by model, in \
         the report of a run and in simulations",
        "nothing modulated reaches the detector, so the largest count is chance: \"no estimate\"",
        unmodulated_estimate;
    Light quick "infinite-extinction-ratio":
        "largest deviation of the mean signed count at phase steps 0, 4, 8 and 20 (S = 8)",
        "ideal detector: r = rate x T x (correlation of the on-chips with the reference), linear \
         between chips",
        infinite_extinction_ratio;
    Light quick "background-a-million-times-the-signal":
        "largest relative error of the expected counts, less that of the background, against the \
         closed form",
        "without dead time counts add up: the signal's part is that without background; 10^-16 \
         of a background 10^6 times as large, over some thousand additions",
        |_| overwhelming_background();
    Light slow "background-a-million-times-the-signal-in-photons":
        "deviation of the signed count at the peak, 10 cps of signal in 10 Mcps of background \
         for 144 days in all, counts drawn from their moments",
        "Poisson light: mean and variance of the signed count in closed form, and the signal is \
         11 of the standard errors",
        overwhelming_background_counts;
};

/// All of Table I, with light that does not carry its code.
fn unmodulated() -> Result<Scene, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 3_100)?;
    scene.sources[0].extinction_ratio = 1.0;
    Ok(scene)
}

fn unmodulated_prediction() -> Result<CaseMeasurement, CaseError> {
    let (dark, lit) = (unmodulated()?, table_i(GOLD_5, 20e6, 3_100)?);
    let tiers = || [CountingTier::Events, CountingTier::Sampled].into_iter();
    let without =
        tiers().filter(|&tier| predicted(&dark, tier) != Err(PredictionError::Flat)).count();
    let with =
        tiers().filter(|&tier| predicted(&lit, tier).is_ok_and(|found| found.std_m > 0.0)).count();
    CaseMeasurement::none(without, with, "predictions")
}

fn unmodulated_estimate(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = unmodulated()?;
    let reported = |scene: &Scene, repetitions: u64| {
        let mut scene = scene.clone();
        let mut estimates = 0;
        for repetition in 0..repetitions {
            let scans = repetition..repetition + 1;
            let found = counts_of_scans(&scene, scans, scene.scan.steps, seed);
            for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
                scene.estimator = estimator;
                let report = Reporter::new(&Sensor::new(&scene), DetectorIndex(0)).scan(&found);
                estimates += usize::from(report.distance_m.is_some());
            }
        }
        estimates
    };
    let of_modulated = reported(&table_i(GOLD_5, 20e6, 3_100)?, 1);
    let mut estimates = reported(&scene, 10);
    for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
        scene.estimator = estimator;
        for tier in [Tier::Expected, Tier::Counts, Tier::Events, Tier::Sampled] {
            for path in simulated(&scene, tier, seed, 10)?.estimates {
                let numbers = [path.mean_distance_m, path.bias_m, path.std_m, path.expected_bias_m];
                estimates += numbers.iter().flatten().count() + path.estimates as usize;
                ensure!(path.remark.is_some(), "{tier}: no reason is given");
            }
        }
    }
    CaseMeasurement::none(estimates, of_modulated, "estimates")
}

/// Sum over the code of on(i - lag) chi(i), for a lag in phase steps, with linear
/// interpolation between whole chips.
fn on_chips_against_reference(chips: &[u8], lag_steps: u64, samples_per_chip: u64) -> f64 {
    let length = chips.len();
    let of_whole = |lag: usize| -> f64 {
        (0..length)
            .map(|i| {
                let on = f64::from(chips[i]);
                let reference = 2.0 * f64::from(chips[(i + length - lag % length) % length]) - 1.0;
                on * reference
            })
            .sum()
    };
    let (whole, part) = (lag_steps / samples_per_chip, lag_steps % samples_per_chip);
    let share = part as f64 / samples_per_chip as f64;
    (1.0 - share) * of_whole(whole as usize) + share * of_whole(whole as usize + 1)
}

fn infinite_extinction_ratio(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for lag in [0, 4, 8, 20] {
        let scene = lit_step(GOLD_5, 8, 31 * 100, lag)?;
        let code = scene.sources[0].code.clone();
        let photons = 10e6 * step_s(&scene);
        let correlated = on_chips_against_reference(&code.chips, lag, 8);
        let expected = photons * correlated / code.weight() as f64;
        let found = counts_of_scans(&scene, 0..1_000, 1, seed);
        if lag == 0 {
            // Every detection counts up: no scatter but that of the total.
            let down = found.iter().filter(|c| c.signed != c.total as i64).count();
            ensure!(down == 0, "{down} scans counted off-light at the peak");
        }
        deviations.push(SampleStatistics::of(found.iter().map(|c| c.signed as f64)).z(expected));
    }
    CaseMeasurement::deviation(deviations)
}

/// Gold code of 31 chips, 1 kcps of signal in 1 Gcps of background.
fn dazzled() -> Result<Scene, CaseError> {
    let mut scene = ideal(GOLD_5, 8, 1e3, 31 * 1_000)?;
    scene.detectors[0].background_rate_cps = 1e9;
    Ok(scene)
}

fn overwhelming_background() -> Result<CaseMeasurement, CaseError> {
    let scene = dazzled()?;
    let code = scene.sources[0].code.clone();
    let means = mean_counts(&scene)?;
    let (length, weight) = (code.len() as f64, code.weight() as f64);
    let background = 1e9 * step_s(&scene) * (2.0 * weight - length) / length;
    let signal = 1e3 * step_s(&scene);
    let errors = means.iter().zip(0..).map(|(mean, k)| {
        let expected = signal * on_chips_against_reference(&code.chips, k, 8) / weight;
        (mean.signed - background - expected) / signal
    });
    CaseMeasurement::largest(errors, "of the signal", 1e-7)
}

fn overwhelming_background_counts(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = ideal(GOLD_5, 8, 10.0, 31 * 100_000_000)?;
    scene.detectors[0].background_rate_cps = 1e7;
    window(&mut scene, 0, 1);
    let code = scene.sources[0].code.clone();
    let (length, weight) = (code.len() as f64, code.weight() as f64);
    let seconds = step_s(&scene);
    let mean = 10.0 * seconds + 1e7 * seconds * (2.0 * weight - length) / length;
    // Both signs are Poisson, so the variance of r is the mean of N.
    let variance = (10.0 + 1e7) * seconds;
    let model = model(&scene);
    let moments = CountMoments {
        signed_mean: mean,
        total_mean: variance,
        signed_variance: variance,
        total_variance: variance,
        covariance: mean,
    };
    let sampler = CountSampler::new(&model, &[moments])?;
    let scans = 500_000;
    let found = (0..scans).flat_map(|scan| drawn(&sampler, 1, seed, scan));
    let expected = mean_count(&scene, Step(0))?;
    ensure!(
        ((expected.signed - mean) / variance.sqrt()).abs() < 1e-3,
        "the mean response expects {} and not {mean}",
        expected.signed
    );
    CaseMeasurement::deviation([
        SampleStatistics::of(found.map(|count| count.signed as f64)).z(mean)
    ])
}

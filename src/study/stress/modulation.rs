//! Light without modulation, all modulation, and modulation behind a bright background.

use super::case::{Case, CaseError, Group, Measured, ensure};
use super::scenes::{GOLD_5, ideal, table_i, window};
use super::statistics::{Sample, step_s, worst};
use crate::estimate::report::estimate_scan;
use crate::estimate::{CountingTier, PredictionError, predict};
use crate::photons::fast::StepCounter;
use crate::photons::{DetectorModel, StepCount};
use crate::response::{CountMoments, CountSampler, MeanResponse};
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::repeat::simulate;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "extinction-ratio-1-is-expected-flat",
        group: Group::Light,
        quick: true,
        what: "tiers that predict a distance for unmodulated light",
        why: "an extinction ratio of 1 carries no code: every phase step expects the same count",
        run: |_| unmodulated_prediction(),
    },
    Case {
        name: "extinction-ratio-1-gives-no-estimate",
        group: Group::Light,
        quick: true,
        what: "estimates from the noise of unmodulated light, in 10 scans, by phase and by model, in \
               the report of a run and in simulations",
        why: "nothing modulated reaches the detector, so the largest count is chance: \"no estimate\"",
        run: unmodulated_estimate,
    },
    Case {
        name: "infinite-extinction-ratio",
        group: Group::Light,
        quick: true,
        what: "largest deviation of the mean signed count at phase steps 0, 4, 8 and 20 (S = 8)",
        why: "ideal detector: r = rate x T x (correlation of the on-chips with the reference), \
              linear between chips",
        run: infinite_extinction_ratio,
    },
    Case {
        name: "background-a-million-times-the-signal",
        group: Group::Light,
        quick: true,
        what: "largest relative error of the expected counts, less that of the background, against \
               the closed form",
        why: "without dead time counts add up: the signal's part is that without background; \
              10^-16 of a background 10^6 times as large, over some thousand additions",
        run: |_| overwhelming_background(),
    },
    Case {
        name: "background-a-million-times-the-signal-in-photons",
        group: Group::Light,
        quick: false,
        what: "deviation of the signed count at the peak, 10 cps of signal in 10 Mcps of background \
               for 144 days in all, counts drawn from their moments",
        why: "Poisson light: mean and variance of the signed count in closed form, and \
              the signal is 11 of the standard errors",
        run: overwhelming_background_counts,
    },
];

/// All of Table I, with light that does not carry its code.
fn unmodulated() -> Result<Scene, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 3_100)?;
    scene.sources[0].extinction_ratio = 1.0;
    Ok(scene)
}

fn unmodulated_prediction() -> Result<Measured, CaseError> {
    let scene = unmodulated()?;
    let predicted = [CountingTier::Events, CountingTier::Sampled]
        .into_iter()
        .filter(|&tier| {
            predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), tier)
                != Err(PredictionError::Flat)
        })
        .count();
    Measured::none(predicted, "predictions")
}

fn unmodulated_estimate(seed: u64) -> Result<Measured, CaseError> {
    let mut scene = unmodulated()?;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let counter = StepCounter::new(&model);
    let mut estimates = 0;
    for repetition in 0..10 {
        let mut found = vec![StepCount::default(); scene.scan.steps as usize];
        counter.count(seed, repetition..repetition + 1, 0..scene.scan.steps, &mut found);
        for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
            scene.estimator = estimator;
            let report = estimate_scan(&Sensor::new(&scene), DetectorIndex(0), &found);
            estimates += usize::from(report.distance_m.is_some());
        }
    }
    for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
        scene.estimator = estimator;
        for tier in [Tier::Expected, Tier::Counts, Tier::Events, Tier::Sampled] {
            for path in simulate(&Sensor::new(&scene), tier, seed, 10)?.estimates {
                let numbers = [path.mean_distance_m, path.bias_m, path.std_m, path.expected_bias_m];
                estimates += numbers.iter().flatten().count() + path.estimates as usize;
                ensure!(path.remark.is_some(), "{tier}: no reason is given");
            }
        }
    }
    Measured::none(estimates, "estimates")
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

fn infinite_extinction_ratio(seed: u64) -> Result<Measured, CaseError> {
    let mut deviations = Vec::new();
    for lag in [0, 4, 8, 20] {
        let mut scene = ideal(GOLD_5, 8, 10e6, 31 * 100)?;
        window(&mut scene, lag, 1);
        let code = scene.sources[0].code.clone();
        let photons = 10e6 * step_s(&scene);
        let correlated = on_chips_against_reference(&code.chips, lag, 8);
        let expected = photons * correlated / code.weight() as f64;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let mut found = vec![Default::default(); 1_000];
        StepCounter::new(&model).count(seed, 0..1_000, 0..1, &mut found);
        if lag == 0 {
            // Every detection counts up: no scatter but that of the total.
            let down = found.iter().filter(|c| c.signed != c.total as i64).count();
            ensure!(down == 0, "{down} scans counted off-light at the peak");
        }
        deviations.push(Sample::of(found.iter().map(|c| c.signed as f64)).z(expected));
    }
    Measured::deviation(worst(deviations))
}

/// Gold code of 31 chips, 1 kcps of signal in 1 Gcps of background.
fn dazzled() -> Result<Scene, CaseError> {
    let mut scene = ideal(GOLD_5, 8, 1e3, 31 * 1_000)?;
    scene.detectors[0].background_rate_cps = 1e9;
    Ok(scene)
}

fn overwhelming_background() -> Result<Measured, CaseError> {
    let scene = dazzled()?;
    let code = scene.sources[0].code.clone();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let means = MeanResponse::of_tier(&model, CountingTier::Events)?.mean_counts();
    let (length, weight) = (code.len() as f64, code.weight() as f64);
    let background = 1e9 * step_s(&scene) * (2.0 * weight - length) / length;
    let signal = 1e3 * step_s(&scene);
    let errors = (0..scene.scan.steps).map(|k| {
        let expected = signal * on_chips_against_reference(&code.chips, k, 8) / weight;
        (means[k as usize].signed - background - expected) / signal
    });
    Measured::at_most(worst(errors), "of the signal", 1e-7)
}

fn overwhelming_background_counts(seed: u64) -> Result<Measured, CaseError> {
    let mut scene = ideal(GOLD_5, 8, 10.0, 31 * 100_000_000)?;
    scene.detectors[0].background_rate_cps = 1e7;
    window(&mut scene, 0, 1);
    let code = scene.sources[0].code.clone();
    let (length, weight) = (code.len() as f64, code.weight() as f64);
    let seconds = step_s(&scene);
    let mean = 10.0 * seconds + 1e7 * seconds * (2.0 * weight - length) / length;
    // Both signs are Poisson, so the variance of r is the mean of N.
    let variance = (10.0 + 1e7) * seconds;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let moments = CountMoments {
        signed_mean: mean,
        total_mean: variance,
        signed_variance: variance,
        total_variance: variance,
        covariance: mean,
    };
    let sampler = CountSampler::new(&model, &[moments])?;
    let scans = 500_000;
    let found = (0..scans).map(|scan| sampler.scan(seed, scan)[0].signed as f64);
    let expected = MeanResponse::of_tier(&model, CountingTier::Events)?.mean_counts()[0];
    ensure!(
        ((expected.signed - mean) / variance.sqrt()).abs() < 1e-3,
        "the mean response expects {} and not {mean}",
        expected.signed
    );
    Measured::deviation(Sample::of(found).z(mean))
}

//! The mean response against closed forms and against the simulated photons.

use std::num::NonZero;
use std::thread::available_parallelism;

use goldtof::photons::fast::StepCounter;
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::response::{CountingTier, Light, MeanResponse, MeanResponseError, SecondMoments};
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, gold_11, ideal_scene, sampled_counts,
    stepped, table_i_scene,
};

/// A one-chip code that is always on: background, counted upwards.
fn constant_light(rate_cps: f64, dead_time_ps: f64) -> Scene {
    let mut scene = ideal_scene(code(&[1]), rate_cps, 1_000);
    scene.detectors[0].dead_time_ps = dead_time_ps;
    scene
}

#[test]
fn constant_light_gives_the_renewal_rate_and_variance() {
    for dead_time_ps in [14e3, 9_300.0, 500.0] {
        for rate in [1e6, 20e6, 100e6] {
            let scene = constant_light(rate, dead_time_ps);
            let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
            let slowdown = 1.0 + rate * dead_time_ps * 1e-12;
            let mean = rate * 8e-6 / slowdown;
            let variance = renewal_variance(rate * 8e-6, slowdown);
            let moments = SecondMoments::new(&response).expect("it can be solved").of_step(Step(3));
            let found = (moments.signed_mean, moments.signed_variance);
            assert!((found.0 / mean - 1.0).abs() < 1e-6, "{found:?} {mean}");
            assert!((found.1 / variance - 1.0).abs() < 1.2e-3, "{found:?} {variance}");
        }
    }
}

/// Variance of the number of events of an equilibrium renewal process whose intervals have a
/// constant part (Cox, Renewal Theory, 1962): `primary` events would come without it, `slowdown`
/// times as many.
fn renewal_variance(primary: f64, slowdown: f64) -> f64 {
    primary / slowdown.powi(3) + 1.0 / 6.0 + 0.5 / slowdown.powi(4) - 2.0 / 3.0 / slowdown.powi(3)
}

/// Steps of 0.8 us, where their ends matter: 1.3 to 60 % of the variance.
#[test]
fn short_steps_have_the_renewal_variance_with_their_ends() {
    for (dead_time_ps, rate) in [(14e3, 20e6), (14e3, 100e6), (14e3, 500e6), (9_300.0, 300e6)] {
        let mut scene = constant_light(rate, dead_time_ps);
        scene.scan.integration_chips = 100;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
        let slowdown = 1.0 + rate * dead_time_ps * 1e-12;
        let variance = renewal_variance(rate * 0.8e-6, slowdown);
        let second = SecondMoments::new(&response).expect("it can be solved");
        let found = second.of_step(Step(3));
        let together = second.of_steps_together(&[Step(3)]).covariance;
        // Every detection counts up: all second moments are those of the total.
        for found in [
            found.total_variance,
            found.signed_variance,
            found.covariance,
            second.variance_of_sum(&[(Step(3), 1.0)]),
            together[0][0],
            together[0][1],
            together[1][1],
        ] {
            assert!((found / variance - 1.0).abs() < 2e-3, "{found} {variance}");
        }
    }
}

/// Light of 500 pW, counts of steps that end at all 31 chips of the code, photon by photon.
#[test]
fn bright_modulated_light_in_short_steps_scatters_as_expected() {
    let mut scene = table_i_scene(gold_5(), 660e6, 325);
    scene.scan.steps = 31;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("it can be solved");
    let second = SecondMoments::new(&response).expect("it can be solved");
    let scans = 1_500;
    let mut counts = vec![StepCount::ZERO; scans * 31];
    StepCounter::new(&model).count(9, 0..scans as u64, 0..31, &mut counts);
    let [mut totals, mut signed] = [Vec::new(), Vec::new()];
    for step in 0..31 {
        let expected = second.of_step(Step(step as u64));
        let of_step = || counts.iter().skip(step).step_by(31);
        let total = Moments::of(of_step().map(|count| count.total as f64));
        let sign = Moments::of(of_step().map(|count| count.signed as f64));
        totals.push(total.variance / expected.total_variance);
        signed.push(sign.variance / expected.signed_variance);
    }
    for (ratios, what) in [(totals, "total"), (signed, "signed")] {
        let ratio = Moments::of(ratios);
        println!("{what}: {:.4}, z {:.2}", ratio.mean, ratio.z(1.0));
        assert_within_standard_errors(ratio.z(1.0), 4.0, &format!("variance of {what}"));
        assert!((ratio.mean - 1.0).abs() < 0.03, "{what}: {}", ratio.mean);
    }
}

#[test]
fn without_dead_time_expected_counts_are_the_interpolated_code_correlation() {
    let chips = [1_u8, 1, 1, 0, 1, 0, 0];
    let mut scene = ideal_scene(code(&chips), 10e6, 7 * 100);
    let delay_samples = 18.0;
    scene.paths[0].delay_ps = delay_samples * 1000.0;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
    let correlation = |lag: i64| -> f64 {
        (0..7_i64)
            .map(|i| {
                let reference = chips[(i - lag).rem_euclid(7) as usize];
                f64::from(chips[i as usize]) * (2.0 * f64::from(reference) - 1.0)
            })
            .sum()
    };
    for k in 0..56 {
        let lag = (k as f64 - delay_samples) / 8.0;
        let (whole, part) = (lag.floor(), lag - lag.floor());
        let mean = (1.0 - part) * correlation(whole as i64) + part * correlation(whole as i64 + 1);
        // Rate 10 MHz in the mean, four of seven chips on.
        let expected = mean * 10e6 * 7.0 / 4.0 * 8e-9 * 100.0;
        let found = response.expected_count(Step(k));
        assert!((found - expected).abs() < 1e-9, "{k}: {found} {expected}");
    }
}

/// 101 chips a step: three periods of 31 and a part, ever another one.
fn short_steps(rate_cps: f64, dead_time_ps: f64) -> Scene {
    let mut scene = table_i_scene(gold_5(), rate_cps, 101);
    scene.detectors[0].jitter_ps.clear();
    scene.detectors[0].dead_time_ps = dead_time_ps;
    scene.detectors[0].pulse_width_ps = 0.4 * dead_time_ps;
    scene
}

#[test]
fn strong_afterpulsing_and_an_uneven_dead_time_count_as_the_mean_response_says() {
    // Nothing is aligned to samples.
    let mut scene = short_steps(40e6, 11_370.0);
    scene.detectors[0].afterpulsing_probability = 0.25;
    compare_with_photons(&scene);
}

#[test]
fn a_saturated_detector_counts_as_the_mean_response_says() {
    compare_with_photons(&short_steps(300e6, 14e3));
}

#[test]
fn fast_afterpulses_after_a_short_dead_time_count_as_the_mean_response_says() {
    let mut scene = short_steps(100e6, 2_900.0);
    scene.detectors[0].afterpulsing_probability = 0.25;
    scene.detectors[0].afterpulsing_time_constant_ps = 150.0;
    compare_with_photons(&scene);
}

fn compare_with_photons(scene: &Scene) {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let response = MeanResponse::new(&model).expect("it can be solved");

    let scans = 400;
    let samples = 31 * 8;
    let mut hits = vec![0.0; samples];
    let counts: Vec<Vec<f64>> =
        (0..scans).map(|seed| sampled_counts(scene, &model, seed, 0, &mut hits)).collect();

    // Hits of one sample are rare and nearly Poisson.
    let periods = scans as f64 * 101.0 * 8.0;
    let expected = response.hits_per_sample();
    let mut chi_square = 0.0;
    for (sample, (&found, expected)) in hits.iter().zip(&expected).enumerate() {
        let mean = expected * periods;
        let z = (found - mean) / mean.sqrt();
        assert_within_standard_errors(z, 5.0, &format!("hits at sample {sample}"));
        chi_square += z * z;
    }
    let z = (chi_square / samples as f64 - 1.0) / (2.0 / samples as f64).sqrt();
    assert_within_standard_errors(z, 5.0, "chi-square of hits");

    let moments = SecondMoments::new(&response).expect("it can be solved");
    let mut mean_z = Vec::new();
    let mut variance_ratio = Vec::new();
    for step in 0..scene.scan.steps {
        let found = Moments::of(counts.iter().map(|scan| scan[step as usize]));
        let expected = response.expected_count(Step(step));
        assert_within_standard_errors(found.z(expected), 5.0, &format!("count of step {step}"));
        mean_z.push(found.z(expected));
        variance_ratio.push(found.variance / moments.of_step(Step(step)).signed_variance);
    }
    let mean_z = Moments::of(mean_z);
    assert_within_standard_errors(mean_z.z(0.0), 5.0, "all counts together");
    let ratio = Moments::of(variance_ratio);
    assert_within_standard_errors(ratio.z(1.0), 5.0, "ratio of variances");
}

/// Table I in full, jitter, edge delays and transition included: 31 phases of the
/// reference's edges against those of the light.
#[test]
fn the_continuous_time_counter_counts_as_the_mean_response_says() {
    let mut scene = table_i_scene(gold_5(), 40e6, 1_503);
    // Wide enough to matter, and uneven.
    scene.detectors[0].jitter_ps = vec![300.0, 120.0];
    scene.detectors[0].counter.rising_delay_ps = 340.0;
    scene.detectors[0].counter.falling_delay_ps = 1_290.0;
    scene.detectors[0].counter.transition_ps = 400.0;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("it can be solved");
    let second = SecondMoments::new(&response).expect("it can be solved");
    let means = response.mean_counts();

    let scans = 240;
    let counts: Vec<Vec<StepCount>> = (0..scans)
        .map(|scan| {
            let steps = 0..scene.scan.steps;
            steps.map(|step| count_step(&model, 3, scan, Step(step))).collect()
        })
        .collect();
    let mut z = [Vec::new(), Vec::new()];
    let mut ratios = [Vec::new(), Vec::new(), Vec::new()];
    for step in 0..scene.scan.steps {
        let expected = second.of_step(Step(step));
        assert!((means[step as usize].signed - expected.signed_mean).abs() < 1e-6);
        assert!((means[step as usize].total - expected.total_mean).abs() < 1e-6);
        let of_step = || counts.iter().map(|scan| scan[step as usize]);
        let signed = Moments::of(of_step().map(|c| c.signed as f64));
        let total = Moments::of(of_step().map(|c| c.total as f64));
        let either_way = Moments::of(of_step().map(|c| c.signed as f64 + c.total as f64));
        for (z, (found, mean, variance)) in z.iter_mut().zip([
            (&signed, expected.signed_mean, expected.signed_variance),
            (&total, expected.total_mean, expected.total_variance),
        ]) {
            z.push((found.mean - mean) / (variance / scans as f64).sqrt());
        }
        let sum_variance =
            expected.signed_variance + expected.total_variance + 2.0 * expected.covariance;
        ratios[0].push(signed.variance / expected.signed_variance);
        ratios[1].push(total.variance / expected.total_variance);
        ratios[2].push(either_way.variance / sum_variance);
    }
    for (z, what) in z.into_iter().zip(["signed", "total"]) {
        let number = z.len() as f64;
        let chi_square: f64 = z.iter().map(|z| z * z).sum();
        let spread = (chi_square - number) / (2.0 * number).sqrt();
        assert_within_standard_errors(spread, 5.0, &format!("chi-square of {what} means"));
        let mean = z.iter().sum::<f64>() / number.sqrt();
        assert_within_standard_errors(mean, 5.0, &format!("all {what} means together"));
    }
    for (ratios, what) in ratios.into_iter().zip(["signed", "total", "their sum"]) {
        let ratio = Moments::of(ratios);
        assert_within_standard_errors(ratio.z(1.0), 5.0, &format!("variance of {what}"));
        assert!((ratio.mean - 1.0).abs() < 0.03, "{what}: {}", ratio.mean);
    }
}

#[test]
fn means_agree_with_a_time_stepped_detector_to_a_hundred_thousandth_of_the_peak() {
    for rate in [2e6, 25e6, 90e6, 200e6] {
        // Ten periods exactly.
        let mut scene = table_i_scene(gold_5(), rate, 310);
        scene.detectors[0].jitter_ps.clear();
        scene.detectors[0].delay_ps = 0.0;
        scene.paths[0].delay_ps = 16_500.0;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let light = Light::of(&model);
        let code = &light.paths[0].code;
        let lit: Vec<f64> = code
            .chips
            .iter()
            .map(|&chip| light.constant_per_chip + light.paths[0].rate_per_chip * f64::from(chip))
            .collect();
        let stepped = stepped::hits_without_steps(&lit, 31 * 9);
        // The stepped detector's light has no delay.
        let response = MeanResponse::new(&model)
            .expect("it can be solved")
            .delayed(-16_500.0)
            .expect("it can be solved");
        let found = response.hits_per_sample();
        let largest = stepped.iter().copied().fold(0.0, f64::max);
        // Sample s sees the detections of the eighth of a chip before it.
        for (sample, &hits) in stepped.iter().enumerate() {
            let error = found[(sample + 1) % found.len()] - hits;
            assert!(error.abs() < 4e-6 * largest, "{rate} {sample}: {error}");
        }
        let chips = &scene.sources[0].code.chips;
        let naive = |k: usize| -> f64 {
            (0..31 * 8)
                .map(|s| {
                    // The interval before sample s counts with the sign at s.
                    let chip = chips[((s + 31 * 8 - k) % (31 * 8)) / 8];
                    10.0 * (2.0 * f64::from(chip) - 1.0) * stepped[(s + 31 * 8 - 1) % (31 * 8)]
                })
                .sum()
        };
        let peak = naive(1);
        for (k, mean) in response.mean_counts().iter().enumerate() {
            let error = mean.signed - naive(k);
            assert!(error.abs() < 1e-5 * peak, "{rate} {k}: {error} of {peak}");
        }
    }
}

/// What fast sums over all steps make of the second moments.
#[test]
fn moments_of_a_scan_are_those_of_its_steps_within_two_per_cent() {
    for rate in [2e6, 20e6, 80e6] {
        let scene = table_i_scene(gold_11(), rate, 13_100);
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
        let second = SecondMoments::new(&response).expect("it can be solved");
        let scan = second.of_scan();
        for step in [0, 3, 100, 17, 22, 23, 24, 31, 35, 180, 1_000, 5_555, 12_345, 16_375] {
            let (found, exact) = (scan[step as usize], second.of_step(Step(step)));
            let scale = (exact.signed_variance * exact.total_variance).sqrt();
            assert!((found.signed_mean - exact.signed_mean).abs() < 1e-6);
            assert!((found.signed_variance / exact.signed_variance - 1.0).abs() < 0.02);
            assert!((found.total_variance / exact.total_variance - 1.0).abs() < 1e-9);
            let error = (found.covariance - exact.covariance) / scale;
            assert!(error.abs() < 0.02, "{rate} {step}: {error}");
        }
    }
}

#[test]
fn what_cannot_be_solved_says_what_would_be_right() {
    let refused = |scene: &Scene| {
        let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
        MeanResponse::new(&model).err()
    };
    let too_short = refused(&constant_light(1e6, 10.0));
    assert_eq!(
        too_short,
        Some(MeanResponseError::DeadTimeTooShort { dead_time_ps: 10.0, least_ps: 62.5 })
    );
    let mut scene = constant_light(1e6, 14e3);
    scene.detectors[0].afterpulsing_probability = 0.1;
    assert_eq!(
        refused(&scene),
        Some(MeanResponseError::TimeConstantTooShort { time_constant_ps: 0.0, least_ps: 125.0 })
    );
    // A photon in every cell of 62.5 ps.
    assert!(matches!(
        refused(&constant_light(16.1e9, 14e3)),
        Some(MeanResponseError::TooBright { .. })
    ));
    assert_eq!(refused(&constant_light(15.9e9, 14e3)), None);
    // 256 photons in a dead time.
    assert_eq!(
        refused(&constant_light(1e10, 100e3)).map(|e| e.to_string()),
        Some(
            "the brightest light fires a ready detector at 1.000e10 cps; with this dead time and \
             chip period the mean response is solved up to 2.560e9 cps: take less light, or \
             simulate it photon by photon"
                .to_owned()
        )
    );
    // 1,248 dead times of 12,500 chips.
    assert_eq!(
        refused(&constant_light(200e3, 100e6)).map(|e| e.to_string()),
        Some(
            "the detector remembers its start for 1.560e7 chips; the mean response is solved up to \
             4194304 chips: take less light beside so long a dead time, a shorter afterpulsing \
             time constant, or simulate it photon by photon"
                .to_owned()
        )
    );
}

/// Variances and covariance that theory gives, against the sensor of Table I over
/// the steps round its peak; `--nocapture` prints a table.
fn assert_moments_of_table_i(detections: f64, chips: u64) {
    // Primary rates, for detected ones of 1, 10 and 45 million per second.
    for (rate, primary) in [(1e6, 0.81e6), (10e6, 10.3e6), (45e6, 190e6)] {
        let mut scene = table_i_scene(gold_11(), primary, chips);
        scene.scan.first_step = 8;
        scene.scan.steps = 32;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
        let second = SecondMoments::new(&response).expect("it can be solved");
        let per_scan = 32.0 * chips as f64 * 8e-9 * rate;
        let scans = (detections / per_scan).ceil() as u64;
        let mut counts = vec![StepCount::ZERO; (scans * 32) as usize];
        let threads = available_parallelism().unwrap_or(NonZero::<usize>::MIN);
        StepCounter::new(&model).count_on_threads(threads, 9, 0..scans, 0..32, &mut counts);
        let of_steps: Vec<Step> = Step::all(32).collect();
        let expected = second.of_steps(&of_steps);
        let peak = expected.iter().map(|m| m.signed_mean).fold(0.0, f64::max);
        // Sums over scans and steps of deviations from the expected means, and of
        // their products.
        let mut ratios = [Vec::new(), Vec::new(), Vec::new()];
        let (mut off_mean, mut variance) = (0.0, 0.0);
        for (step, expected) in expected.iter().enumerate() {
            let of_step = || counts.iter().skip(step).step_by(32);
            let signed = Moments::of(of_step().map(|c| c.signed as f64));
            let total = Moments::of(of_step().map(|c| c.total as f64));
            let both = Moments::of(of_step().map(|c| (c.signed + c.total as i64) as f64));
            let sum =
                expected.signed_variance + expected.total_variance + 2.0 * expected.covariance;
            off_mean += signed.mean - expected.signed_mean;
            variance += expected.signed_variance / scans as f64;
            ratios[0].push(signed.variance / expected.signed_variance);
            ratios[1].push(total.variance / expected.total_variance);
            ratios[2].push(both.variance / sum);
        }
        println!(
            "{:6.2} Mcps, {scans} scans: mean off by {:+.1e} +- {:.1e} of the peak",
            response.detection_rate_hz() / 1e6,
            off_mean / 32.0 / peak,
            variance.sqrt() / 32.0 / peak
        );
        let what = format!("{rate:.0e}: mean of all steps");
        assert_within_standard_errors(off_mean / variance.sqrt(), 4.0, &what);
        let standard_error = (2.0 / (32.0 * (scans - 1) as f64)).sqrt();
        for (ratios, what) in ratios.into_iter().zip(["r", "N", "r + N"]) {
            let off = Moments::of(ratios).mean - 1.0;
            println!(
                "    variance of {what:5} {:+.2} % +- {:.2} %",
                off * 100.0,
                standard_error * 100.0
            );
            let limit = 0.03_f64.max(4.0 * standard_error);
            assert!(off.abs() < limit, "{rate:.0e}, variance of {what}: off by {off}");
            assert!(limit < 0.08, "too few scans to tell");
        }
    }
}

#[test]
fn variances_are_those_of_the_photons_from_1_to_45_million_detections_per_second() {
    // Two code periods a step; at the highest rate 7,000 steps: variances to 1.7 %.
    assert_moments_of_table_i(1e7, 4_094);
}

#[test]
#[ignore = "hundreds of millions of detections; run with --release --nocapture"]
fn variances_are_those_of_hundreds_of_millions_of_photons() {
    assert_moments_of_table_i(1e9, 13_100);
}

//! What is expected of a detector whose dead time each arrival prolongs: against closed forms, a
//! simulator of other construction, and probabilities stepped through time.

use goldtof::estimate::fit::{FitError, OtherLight, fit_means};
use goldtof::estimate::{CountingTier, calibration_offset_ps, delay_error_ps, distance_m, theory};
use goldtof::photons::DetectorModel;
use goldtof::response::{MeanResponse, MeanResponseError, SecondMoments};
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, PathIndex, Recharge, Scene, parse};
use goldtof::sensor::Sensor;
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, gold_7, gold_11, ideal_scene, naive,
    repeated, stepped::Stepped, table_i_scene,
};
use rand::rngs::StdRng;
use rand::{RngExt as _, SeedableRng};

const SPAD: DetectorIndex = DetectorIndex(0);

fn model(scene: &Scene) -> DetectorModel {
    DetectorModel::new(&Sensor::new(scene), SPAD)
}

/// The sensor of Table I with passive recharge, and without afterpulses.
fn passive(mut scene: Scene) -> Scene {
    let spad = &mut scene.detectors[0];
    spad.recharge = Recharge::Passive;
    spad.afterpulsing_probability = 0.0;
    scene
}

/// r = lambda exp(-lambda D); the pair density is r^2 beyond D and 0 within, so that the variance of
/// N in T is r T - r^2 D (2 T - D). Far below and beyond 1 / D.
#[test]
fn constant_light_gives_the_rate_and_the_variance_of_the_closed_form() {
    for dead_time_s in [14e-9, 9.3e-9, 0.5e-9] {
        for rate in [1e4, 1e6, 20e6, 100e6, 1e9] {
            for chips in [20, 1_000] {
                let mut scene = ideal_scene(code(&[1]), rate, chips);
                let spad = &mut scene.detectors[0];
                (spad.dead_time_ps, spad.recharge) = (dead_time_s * 1e12, Recharge::Passive);
                let model = model(&scene);
                let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
                let found = SecondMoments::new(&response).expect("solved").of_step(Step(3));
                let detected = rate * (-rate * dead_time_s).exp();
                let time_s = chips as f64 * 8e-9;
                let variance = detected * time_s
                    - detected * detected * dead_time_s * (2.0 * time_s - dead_time_s);
                let mean = detected * time_s;
                let told = format!("{rate:e} {dead_time_s:e} {chips}: {found:?} {mean} {variance}");
                assert!((found.total_mean / mean - 1.0).abs() < 1e-6, "{told}");
                // The pairs that the ends of a long step divide are left out: r^2 D^2, which is a thousandth
                // of a mean of 200 at most.
                let is_long = time_s > 300.0 * dead_time_s;
                let limit = if is_long { 1e-3 * mean } else { 1e-5 * variance };
                assert!((found.total_variance - variance).abs() < limit, "{told}");
                assert!((found.signed_variance - variance).abs() < limit, "{told}");
            }
        }
    }
}

/// Primary rates from 10^4 to 10^9 per second on average, nothing aligned to samples: each sample of
/// the code period, mean and variance of the counts, of a simulator that sorts all arrivals.
#[test]
fn modulated_light_is_counted_as_by_another_simulator() {
    for (number, rate) in (0..).zip([1e4, 1e6, 30e6, 200e6, 1e9]) {
        let mut scene = passive(table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), rate, 7 * 40));
        let spad = &mut scene.detectors[0];
        (spad.dead_time_ps, spad.pulse_width_ps) = (11_370.0, 5e3);
        spad.jitter_ps.clear();
        // Enough to show, and no more arrivals than a test has time for.
        spad.dark_count_rate_cps = 1e3;
        let steps = repeated(2_000, 200_000);
        let mut rng = StdRng::seed_from_u64(70 + number);
        let samples = 7 * 8;
        let mut hits = vec![0.0; samples];
        let mut totals = Vec::new();
        for _ in 0..steps {
            let times = naive::detections(&scene, 0, &mut rng, 280.0, 40.0);
            totals.push(times.len() as f64);
            for time in times {
                hits[(time * 8.0).ceil() as usize % samples] += 1.0;
            }
        }
        let model = model(&scene);
        let response = MeanResponse::new(&model).expect("solved");
        let expected = response.hits_per_sample();
        let mut chi_square = 0.0;
        let mut bins = 0.0;
        for (found, expected) in hits.iter().zip(&expected) {
            let mean = expected * 40.0 * steps as f64;
            if mean > 20.0 {
                chi_square += (found - mean).powi(2) / mean;
                bins += 1.0;
            }
        }
        if bins > 0.0 {
            let z = (chi_square - bins) / (2.0_f64 * bins).sqrt();
            assert_within_standard_errors(z, 4.0, &format!("samples at {rate:e}"));
        }
        let totals = Moments::of(totals);
        let expected = SecondMoments::new(&response).expect("solved").of_step(Step(0));
        assert_within_standard_errors(totals.z(expected.total_mean), 3.0, &format!("{rate:e}"));
        if expected.total_mean > 10.0 {
            let z = totals.variance_z(expected.total_variance);
            assert_within_standard_errors(z, 4.0, &format!("variance at {rate:e}"));
        }
    }
}

/// The signed counts of modulated light scatter as photons do, where a dead time spans chips.
#[test]
fn signed_counts_scatter_as_photons_do() {
    let mut scene = passive(table_i_scene(gold_5(), 60e6, 325));
    scene.scan.steps = 31;
    let model = model(&scene);
    let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
    let second = SecondMoments::new(&response).expect("solved");
    let scans = 1_500;
    let mut counts = vec![goldtof::photons::StepCount::ZERO; scans * 31];
    goldtof::photons::fast::StepCounter::new(&model).count(9, 0..scans as u64, 0..31, &mut counts);
    let (mut means, mut ratios) = (Vec::new(), Vec::new());
    for step in 0..31 {
        let expected = second.of_step(Step(step as u64));
        let of_step = counts.iter().skip(step).step_by(31);
        let signed = Moments::of(of_step.map(|count| count.signed as f64));
        means.push(signed.z(expected.signed_mean));
        ratios.push(signed.variance / expected.signed_variance);
    }
    assert_within_standard_errors(Moments::of(means).z(0.0), 4.0, "mean signed counts");
    let ratio = Moments::of(ratios);
    assert_within_standard_errors(ratio.z(1.0), 4.0, "variances of signed counts");
    assert!((ratio.mean - 1.0).abs() < 0.03, "{}", ratio.mean);
}

/// The output stepped through time: it falls exponentially, jumps to its full height at each arrival, and a
/// comparator counts how often it rises above the threshold.
#[test]
fn a_comparator_behind_an_output_that_falls_counts_as_a_paralyzable_detector() {
    const STEP_S: f64 = 20e-12;
    let quick = std::fs::read_to_string("scenes/quick.toml").expect("it is there");
    let mut rng = StdRng::seed_from_u64(17);
    for (rate, time_constant_ns, threshold) in
        [(8e6, 10.0, 0.25), (60e6, 20.0, 0.5), (60e6, 6.0, 0.1)]
    {
        let keys = format!(
            "recharge = \"passive\"\nrecharge_time_constant = \"{time_constant_ns} ns\"\n\
             comparator_threshold = {threshold}"
        );
        let told = parse("x.toml", &quick.replace("dead_time = \"14 ns\"", &keys));
        let mut scene = ideal_scene(code(&[1]), rate, 1_000);
        let spad = &mut scene.detectors[0];
        spad.dead_time_ps = told.expect("it is sound").detectors[0].dead_time_ps;
        spad.recharge = Recharge::Passive;

        let fall = (-STEP_S / (time_constant_ns * 1e-9)).exp();
        let counted = (0..repeated(60, 2_000)).map(|_| {
            // 8 us, after 1 us in which it forgets how it began.
            let (mut output, mut edges, mut arrival) = (0.0, 0, 0.0);
            for step in 0..450_000 {
                output *= fall;
                if f64::from(step) * STEP_S >= arrival {
                    edges += u32::from(step >= 50_000 && output < threshold);
                    output = 1.0;
                    arrival -= (1.0 - rng.random::<f64>()).ln() / rate;
                }
            }
            f64::from(edges)
        });
        let stepped = Moments::of(counted);
        let model = model(&scene);
        let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("solved");
        let expected = SecondMoments::new(&response).expect("solved").of_step(Step(0));
        let what = format!("{rate:e}, {time_constant_ns} ns, {threshold}");
        assert_within_standard_errors(stepped.z(expected.total_mean), 4.0, &what);
        assert_within_standard_errors(stepped.variance_z(expected.total_variance), 4.0, &what);
    }
}

fn scan_around(scene: &mut Scene, halfwidth: u64) {
    let offset_ps = calibration_offset_ps(&Sensor::new(scene), SPAD, CountingTier::Events);
    let all = scene.scan.steps_per_period;
    let peak = ((scene.paths[0].delay_ps + offset_ps) / 1000.0).round() as u64;
    scene.scan.first_step = (peak + all - halfwidth) % all;
    scene.scan.steps = 2 * halfwidth;
}

/// Up to where on-chips have 0.98 arrivals in a dead time; expected counts are stepped.
#[test]
fn the_fit_has_no_bias_up_to_the_fold() {
    for rate in [0.8e6, 8e6, 34.7e6] {
        let mut scene = passive(table_i_scene(gold_7(), rate, 127 * 1_600_000));
        scene.paths[0].delay_ps = 21_350.0;
        scan_around(&mut scene, 14);
        let counts = Stepped::new(&scene, 25.0).counts();
        let sensor = Sensor::new(&scene);
        let fitted = fit_means(&sensor, SPAD, CountingTier::Events, &counts, OtherLight::None)
            .expect("it fits");
        let period_ps = scene.scan.steps_per_period as f64 * 1000.0;
        let error_ps = delay_error_ps(fitted.delay_ps, scene.paths[0].delay_ps, period_ps);
        let error_mm = 1e3 * distance_m(error_ps);
        assert!(error_mm.abs() < 0.01, "{rate:e}: {error_mm} mm");
        // What is expected of the fit is the bound.
        let told = theory(&sensor, SPAD, &[PathIndex(0)], CountingTier::Events);
        assert!(told.bound.is_ok() && told.predictions[0].is_ok(), "{rate:e}");
    }
}

/// Beyond one arrival in a dead time more light makes fewer detections: two lights have the same
/// counts, and neither is told for the other.
#[test]
fn counts_that_fold_over_are_refused_by_name() {
    let mut scene = passive(table_i_scene(gold_11(), 80e6, 2047 * 100_000));
    scan_around(&mut scene, 14);
    let sensor = Sensor::new(&scene);
    let counts =
        MeanResponse::of_tier(&model(&scene), CountingTier::Events).expect("solved").mean_counts();
    let told = theory(&sensor, SPAD, &[PathIndex(0)], CountingTier::Events);
    let refused = told.predictions[0].as_ref().err().map(ToString::to_string).expect("refused");
    assert!(refused.contains("folds over"), "{refused}");
    match fit_means(&sensor, SPAD, CountingTier::Events, &counts, OtherLight::None) {
        Err(FitError::NotCovered(why)) => assert!(why.to_string().contains("folds over"), "{why}"),
        // From the lower light the fit ends there, and its residual tells.
        Ok(fitted) => assert!(fitted.alarm_sigmas() > 5.0, "{fitted:?}"),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn afterpulses_that_prolong_are_refused_by_name() {
    let mut scene = table_i_scene(gold_5(), 8e6, 3_100);
    scene.detectors[0].recharge = Recharge::Passive;
    let refused = MeanResponse::new(&model(&scene)).map(|_| ());
    assert_eq!(refused, Err(MeanResponseError::AfterpulsesProlong));
}

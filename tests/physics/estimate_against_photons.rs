//! Estimates of simulated photons against the truth and the prediction.

use goldtof::estimate::{
    CountingTier, PredictionError, calibration_offset_ps, delay_error_ps, distance_m, estimate,
    predict,
};
use goldtof::photons::{DetectorModel, count_step};
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, PathIndex, Scene};
use goldtof::sensor::Sensor;
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, gold_11, ideal_scene, sampled_counts,
    table_i_scene,
};

/// Cuts the scan down to the steps round the first path.
fn scan_around(scene: &mut Scene, steps: u64) {
    let peak = (scene.paths[0].delay_ps / 1000.0).round() as u64;
    let all = scene.scan.steps_per_period;
    scene.scan.first_step = (peak + all - steps / 2 + 2) % all;
    scene.scan.steps = steps;
}

/// Errors in metres of the fine estimates of many scans.
fn errors_m(scene: &Scene, tier: CountingTier, scans: u64) -> Moments {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let offset_ps = calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), tier);
    let period_ps = scene.scan.steps_per_period as f64 * 1000.0;
    Moments::of((0..scans).map(|repetition| {
        let counts: Vec<i64> = match tier {
            CountingTier::Events => (0..scene.scan.steps)
                .map(|step| count_step(&model, 71, repetition, Step(step)).signed)
                .collect(),
            CountingTier::Sampled | CountingTier::Binned => {
                sampled_counts(scene, &model, 71, repetition, &mut [0.0])
                    .into_iter()
                    .map(|count| count as i64)
                    .collect()
            }
        };
        let found = estimate(&scene.timing(), &counts, offset_ps).expect("a peak");
        assert!(found.is_fine());
        distance_m(delay_error_ps(found.delay_ps, scene.paths[0].delay_ps, period_ps))
    }))
}

#[test]
fn either_tier_is_calibrated_by_its_own_offset() {
    // Nothing but delays: no dead time, so that only the circular error is left,
    // which vanishes for a peak on a step and half-way between two.
    for tier in [CountingTier::Events, CountingTier::Sampled] {
        let mut scene = ideal_scene(gold_5(), 40e6, 31 * 100);
        scene.detectors[0].delay_ps = 1750.0;
        scene.detectors[0].pulse_width_ps = 1001.0;
        scene.detectors[0].counter.rising_delay_ps = 340.0;
        scene.detectors[0].counter.falling_delay_ps = 390.0;
        scene.paths[0].delay_ps =
            40_000.0 - calibration_offset_ps(&Sensor::new(&scene), DetectorIndex(0), tier);
        scan_around(&mut scene, 32);
        let errors = errors_m(&scene, tier, 300);
        assert!(errors.standard_error() < 2e-3);
        assert_within_standard_errors(errors.z(0.0), 5.0, &format!("{tier:?}"));
    }
}

#[test]
fn the_table_i_sensor_errs_and_scatters_as_predicted() {
    // From the scene's 4.9 Mcps to where dead-time walk is far above noise.
    for (rate, scans) in [(4.888e6, 200), (20e6, 60)] {
        let mut scene = table_i_scene(gold_11(), rate, 13_100);
        scan_around(&mut scene, 32);
        let predicted =
            predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Sampled)
                .expect("a prediction");
        let errors = errors_m(&scene, CountingTier::Sampled, scans);
        assert_within_standard_errors(errors.z(predicted.bias_m), 5.0, "bias");
        let z = errors.variance_z(predicted.std_m.powi(2));
        assert_within_standard_errors(z, 5.0, "standard deviation");
    }
}

#[test]
fn strong_light_on_a_short_code_errs_and_scatters_as_predicted() {
    let mut scene = table_i_scene(gold_5(), 40e6, 31 * 40);
    scan_around(&mut scene, 32);
    let predicted =
        predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Sampled)
            .expect("a prediction");
    let errors = errors_m(&scene, CountingTier::Sampled, 1_000);
    assert!(predicted.bias_m.abs() > 10.0 * errors.standard_error(), "{predicted:?}");
    assert_within_standard_errors(errors.z(predicted.bias_m), 5.0, "bias");
    let z = errors.variance_z(predicted.std_m.powi(2));
    assert_within_standard_errors(z, 5.0, "standard deviation");
}

#[test]
fn constant_light_alone_has_no_prediction() {
    let mut scene = ideal_scene(gold_5(), 0.0, 31);
    // So little that hardly any of its pulses merge.
    scene.detectors[0].background_rate_cps = 1e4;
    assert_eq!(
        predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Sampled),
        Err(PredictionError::Flat)
    );
    let mut scene = ideal_scene(code(&[1, 1, 0]), 0.0, 31);
    scene.detectors[0].dead_time_ps = 14e3;
    assert_eq!(
        predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Sampled),
        Err(PredictionError::Flat)
    );
}

//! Paths that move: photons and estimates against closed forms.

use goldtof::estimate::{
    CountingTier, calibration_offset_ps, delay_error_ps, distance_m, estimate, predict, true_delay,
};
use goldtof::photons::fast::{OutsideDomain, StepCounter};
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::response::{MeanResponse, MeanResponseError};
use goldtof::scan::{Group, Step};
use goldtof::scene::{DetectorIndex, Fluctuation, Movement, PathIndex, Scene};
use goldtof::sensor::Sensor;
use optics_support::sequential::Scatter;
use optics_support::{Moments, assert_within_standard_errors, gold_5, ideal_scene, table_i_scene};

const LIGHT_M_PER_S: f64 = 299_792_458.0;

fn at_speed(mut scene: Scene, velocity_m_per_s: f64) -> Scene {
    scene.paths[0].movement = Some(Movement { velocity_m_per_s, fluctuation: None });
    scene
}

fn fluctuating(mut scene: Scene, std_m: f64, correlation_time_ps: f64) -> Scene {
    scene.paths[0].movement = Some(Movement {
        velocity_m_per_s: 0.0,
        fluctuation: Some(Fluctuation { std_m, correlation_time_ps }),
    });
    scene
}

fn scan(model: &DetectorModel, seed: u64, repetition: u64) -> Vec<StepCount> {
    (0..model.timing().scan.steps)
        .map(|step| count_step(model, seed, repetition, Step(step)))
        .collect()
}

#[test]
fn neither_speed_nor_fluctuation_is_no_movement_at_all() {
    let still = table_i_scene(gold_5(), 20e6, 500);
    let neutral = fluctuating(still.clone(), 0.0, 1e9);
    let [still, neutral] =
        [&still, &neutral].map(|scene| DetectorModel::new(&Sensor::new(scene), DetectorIndex(0)));
    assert_eq!(scan(&still, 3, 0), scan(&neutral, 3, 0));
    assert_eq!(StepCounter::new(&neutral).outside_domain(), None);
}

/// A clock that drifts so that a delay would come to change too quickly, and a path that changes anew before the next
/// photon comes.
#[test]
fn the_lanes_leave_wild_paths_to_the_plain_loop() {
    let still = table_i_scene(gold_5(), 20e6, 500);
    let mut drifting = still.clone();
    drifting.sources[0].clock.drift_per_s = 1e-5;
    for (scene, is_reason) in [
        (
            drifting,
            (|reason| matches!(reason, OutsideDomain::MovesTooQuickly { path: PathIndex(0), .. }))
                as fn(OutsideDomain) -> bool,
        ),
        (fluctuating(still, 1e-6, 256.0 * 2.0 * 8e3), |reason| {
            matches!(reason, OutsideDomain::MovesTooOften { path: PathIndex(0), .. })
        }),
    ] {
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let counter = StepCounter::new(&model);
        assert!(counter.outside_domain().is_some_and(is_reason), "{:?}", counter.outside_domain());
        let mut counts = vec![StepCount::ZERO; scene.scan.steps as usize];
        counter.count(3, 0..1, 0..scene.scan.steps, &mut counts);
        assert_eq!(counts, scan(&model, 3, 0));
    }
}

/// Arrivals of an on-off code over a receding path, in the time of the emitter:
/// none outside of on-chips, and each chip as long as the Doppler shift makes it.
#[test]
fn the_code_is_seen_with_its_doppler_shift() {
    let velocity = 7e5;
    let chips = 10_000_000;
    let still = ideal_scene(gold_5(), 30e6, chips);
    let mut scene = at_speed(still, velocity);
    scene.paths[0].delay_ps = 21_000.0;
    let rate = 2.0 * velocity / LIGHT_M_PER_S;
    let code = &scene.sources[0].code.chips;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let (mut total, mut last_chip) = (0_u64, [0_u64; 2]);
    let mut per_quarter = [0_u64; 4];
    for detection in model.step(1, 0, Group(0)) {
        // t - tau(t) in chips; the product is exact to 10^-9.
        let moved = rate * (detection.chip as f64 + detection.fraction) + 21.0 / 8.0;
        let emitted =
            detection.chip as f64 - moved.floor() + detection.fraction - (moved - moved.floor());
        assert_eq!(code[emitted.floor().rem_euclid(31.0) as usize], 1, "{emitted}");
        per_quarter[(emitted.rem_euclid(1.0) * 4.0) as usize] += 1;
        last_chip = [detection.chip, emitted as u64];
        total += 1;
    }
    // Photons are neither lost nor made: their rate drops by 2 v / c.
    let seconds = chips as f64 * 8e-9;
    let expected = 30e6 * seconds * (1.0 - rate);
    assert_within_standard_errors((total as f64 - expected) / expected.sqrt(), 5.0, "number");
    assert!(expected * rate > 5.0 * expected.sqrt(), "the test could not tell");
    let quarter = total as f64 / 4.0;
    for count in per_quarter {
        let z = (count as f64 - quarter) / (quarter * 0.75).sqrt();
        assert_within_standard_errors(z, 5.0, "quarters of a chip");
    }
    let seen = last_chip[0] as f64 - last_chip[1] as f64;
    assert!((seen - rate * last_chip[0] as f64).abs() < 4.0, "{seen}");
}

/// Signed counts of an ideal detector and a code with one triangle: the peak of
/// each step's correlation stands where the light is in the middle of the step.
#[test]
fn the_peak_walks_by_two_v_t_over_c() {
    // 24.4 mm per step of 20 us, 0.163 T_s; strong light, so that walks show.
    let velocity = 1_221.0;
    let scene = at_speed(ideal_scene(gold_5(), 50e6, 2_511), velocity);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let chips = &scene.sources[0].code.chips;
    let on: f64 = chips.iter().map(|&chip| f64::from(chip)).sum();
    let correlation = |lag: i64| -> f64 {
        (0..31_i64)
            .map(|i| {
                let reference = chips[(i - lag).rem_euclid(31) as usize];
                f64::from(chips[i as usize]) * (2.0 * f64::from(reference) - 1.0)
            })
            .sum::<f64>()
            / on
    };
    let mut z = Vec::new();
    let mut walks = 0.0_f64;
    for repetition in 0..40 {
        for (step, count) in scan(&model, 8, repetition).into_iter().enumerate() {
            let middle_s = (step as f64 + 0.5) * 2_511.0 * 8e-9;
            let walk_chips = 2.0 * velocity * middle_s / LIGHT_M_PER_S / 8e-9;
            let lag = step as f64 / 8.0 - walk_chips;
            let (whole, part) = (lag.floor(), lag - lag.floor());
            let mean =
                (1.0 - part) * correlation(whole as i64) + part * correlation(whole as i64 + 1);
            let n = count.total as f64;
            z.push((count.signed as f64 - n * mean) / (n * (1.0 - mean * mean) + 1.0).sqrt());
            walks = walks.max(walk_chips);
        }
    }
    assert!(walks > 4.0);
    let number = z.len() as f64;
    let chi_square: f64 = z.iter().map(|z| z * z).sum();
    // A kink of the triangle within a step's walk and the broken period at its end
    // are worth some per cent of a standard error each.
    assert_within_standard_errors((chi_square - number) / (2.0 * number).sqrt(), 6.0, "chi-square");
    let largest = z.iter().fold(0.0_f64, |a, z| a.max(z.abs()));
    assert!(largest < 5.5, "{largest}");
}

#[test]
fn detection_statistics_do_not_depend_on_slow_movement() {
    let scene = table_i_scene(gold_5(), 30e6, 1_550);
    let [still, moving] = [scene.clone(), at_speed(scene, 30.0)].map(|scene| {
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let totals = (0..8).flat_map(|r| scan(&model, 4, r)).map(|count| count.total as f64);
        Moments::of(totals)
    });
    let error = still.standard_error().hypot(moving.standard_error());
    assert_within_standard_errors((still.mean - moving.mean) / error, 5.0, "mean");
    let variance_error = 2.0 / still.count.sqrt();
    let z = (moving.variance / still.variance - 1.0) / variance_error;
    assert_within_standard_errors(z, 5.0, "variance");
}

/// Phase estimates of scans in the events tier, as many as it takes: their errors less what is expected of them, in the
/// predicted standard deviation.
fn assert_errors_are_as_predicted(what: &str, scene: &Scene, bias_m: f64, std_m: f64) {
    let sensor = Sensor::new(scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    let offset_ps = calibration_offset_ps(&sensor, DetectorIndex(0), CountingTier::Events);
    let truth = true_delay(&sensor, PathIndex(0), CountingTier::Events);
    let period_ps = 31.0 * 8000.0;
    let mut errors = Scatter::new(1.25, 0.4, 0.03);
    for repetition in 0.. {
        let counts: Vec<i64> = scan(&model, 17, repetition).iter().map(|c| c.signed).collect();
        let found = estimate(&scene.timing(), &counts, offset_ps).expect("a peak");
        let error_m = distance_m(delay_error_ps(found.delay_ps, truth.delay_ps, period_ps));
        errors.take((error_m - bias_m) / std_m);
        if !errors.is_open() {
            break;
        }
    }
    errors.assert_holds(what);
}

/// Only the steps round 3.2 m, which the scan comes by in its middle.
fn windowed(mut scene: Scene, integration_chips: u64) -> Scene {
    scene.scan.first_step = 10;
    scene.scan.steps = 25;
    scene.scan.integration_chips = integration_chips;
    scene
}

/// The scan meets the light where first + t / D - 1/2 steps and the delay agree:
/// with d = 3.2 m, v and w = 2 v D T_c / c, at j = (tau + offset + w / 2 - first T_s) /
/// (T_s - w).
#[test]
fn the_true_distance_is_that_of_the_moment_when_the_scan_comes_by() {
    for velocity in [-600.0, 0.5, 900.0] {
        let scene = at_speed(windowed(table_i_scene(gold_5(), 20e6, 1), 3_100), velocity);
        let found = true_delay(&Sensor::new(&scene), PathIndex(0), CountingTier::Events);
        let walk_ps = 2.0 * velocity * 3_100.0 * 8e-9 / LIGHT_M_PER_S * 1e12;
        let offset_ps = 1750.0 - 365.0;
        let start_ps = scene.paths[0].delay_ps;
        let step = (start_ps + offset_ps + 0.5 * walk_ps - 10_000.0) / (1_000.0 - walk_ps);
        let at_ps = (step + 0.5) * 3_100.0 * 8_000.0;
        assert!((found.at_ps.expect("it moves") - at_ps).abs() < 1.0, "{velocity}");
        let delay_ps = start_ps + walk_ps * (step + 0.5);
        assert!((found.delay_ps - delay_ps).abs() < 1e-6, "{velocity}");
    }
}

/// Without dead time and off-light, and with walk w per step, the window sees a
/// triangle in steps of T_s - w; the phase of its samples is the whole bias.
#[test]
fn the_bias_of_a_moving_path_is_that_of_a_stretched_triangle() {
    for velocity in [-1_500.0, 1_500.0] {
        let mut still = windowed(ideal_scene(gold_5(), 40e6, 1), 3_100);
        still.paths[0].delay_ps = 21_400.0;
        let scene = at_speed(still, velocity);
        let truth = true_delay(&Sensor::new(&scene), PathIndex(0), CountingTier::Events);
        let walk_ps = 2.0 * velocity * 3_100.0 * 8e-9 / LIGHT_M_PER_S * 1e12;
        // About a quarter of a phase step, as far as predictions go.
        assert!((240.0..250.0).contains(&walk_ps.abs()), "{walk_ps}");
        let centre = (21_400.0 + 0.5 * walk_ps - 10_000.0) / (1_000.0 - walk_ps);
        let peak = centre.round();
        // The code's side lobes are left to the measured correlation.
        let chips = &scene.sources[0].code.chips;
        let correlation = |lag: f64| -> f64 {
            let at = |lag: i64| -> f64 {
                (0..31_i64)
                    .map(|i| {
                        let reference = chips[(i - lag).rem_euclid(31) as usize];
                        f64::from(chips[i as usize]) * (2.0 * f64::from(reference) - 1.0)
                    })
                    .sum()
            };
            let part = lag - lag.floor();
            (1.0 - part) * at(lag.floor() as i64) + part * at(lag.floor() as i64 + 1)
        };
        // Averaged over the walk within each step.
        let count = |step: f64| -> f64 {
            (0..1_000)
                .map(|part| {
                    let along = step + (f64::from(part) + 0.5) / 1_000.0;
                    let light_ps = 21_400.0 + walk_ps * along;
                    correlation(((step + 10.0) * 1_000.0 - light_ps) / 8_000.0)
                })
                .sum()
        };
        let (mut re, mut im) = (0.0, 0.0);
        for offset in -8..8 {
            let value = count(peak + f64::from(offset));
            let angle = std::f64::consts::PI * f64::from(offset) / 8.0;
            re += value * angle.cos();
            im -= value * angle.sin();
        }
        let phase_ps = -im.atan2(re) / std::f64::consts::PI * 8_000.0;
        let expected_ps = (peak + 10.0) * 1_000.0 + phase_ps - truth.delay_ps;

        let predicted =
            predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Events)
                .expect("slow enough");
        let error_m = predicted.bias_m - distance_m(expected_ps);
        assert!(error_m.abs() < 0.1e-3, "{velocity}: {error_m}");
        let what = format!("{velocity} m/s");
        assert_errors_are_as_predicted(&what, &scene, distance_m(expected_ps), predicted.std_m);
    }
}

/// Table I, dead time and all: measured against predicted.
#[test]
fn moving_scenes_scatter_and_err_as_predicted() {
    let still = windowed(table_i_scene(gold_5(), 25e6, 1), 3_100);
    let mut eight_at_once = at_speed(still.clone(), 400.0);
    eight_at_once.hardware.parallel = 8;
    let scenes = [
        ("receding", at_speed(still.clone(), 400.0)),
        ("eight steps at once", eight_at_once),
        ("slow fluctuation", fluctuating(still.clone(), 15e-3, 1e12)),
        ("quick fluctuation", fluctuating(still.clone(), 18e-3, 50e6)),
    ];
    let still_std_m =
        predict(&Sensor::new(&still), DetectorIndex(0), PathIndex(0), CountingTier::Events)
            .expect("a peak")
            .std_m;
    for (name, scene) in scenes {
        let predicted =
            predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Events)
                .expect("slow enough");
        assert_errors_are_as_predicted(name, &scene, predicted.bias_m, predicted.std_m);
        // The phase scatters with photons and path alike: pi is a chip.
        let scatter_m = predicted.phase_std_rad / std::f64::consts::PI * distance_m(8_000.0);
        assert!((scatter_m / predicted.std_m - 1.0).abs() < 1e-9, "{predicted:?}");
        if name == "slow fluctuation" {
            // It stands still within the window, and adds as it is.
            let expected_m = still_std_m.hypot(15e-3);
            assert!((predicted.std_m / expected_m - 1.0).abs() < 0.01, "{predicted:?}");
        } else if name == "quick fluctuation" {
            // Much of it averages out, but far from all.
            assert!(predicted.std_m < still_std_m.hypot(14e-3), "{predicted:?}");
            assert!(predicted.std_m > still_std_m.hypot(4e-3), "{predicted:?}");
        }
    }
}

#[test]
fn what_is_too_fast_for_a_mean_response_is_refused() {
    let still = windowed(table_i_scene(gold_5(), 25e6, 1), 3_100);
    let refused = |scene: &Scene| {
        MeanResponse::new(&DetectorModel::new(&Sensor::new(scene), DetectorIndex(0))).err()
    };
    // 1 ps in 25 steps of 24.8 us: 0.24 m/s.
    assert_eq!(refused(&at_speed(still.clone(), 0.24)), None);
    assert!(matches!(
        refused(&at_speed(still.clone(), 0.25)),
        Some(MeanResponseError::Moving { .. })
    ));
    let message = |scene: Scene| {
        let error =
            predict(&Sensor::new(&scene), DetectorIndex(0), PathIndex(0), CountingTier::Events)
                .err();
        error.map(|error| error.to_string()).unwrap_or_default()
    };
    insta::assert_snapshot!(
        message(at_speed(still.clone(), 1_600.0)),
        @"within a phase step the delay of path 0 moves by 264.7 ps (walk, and twice the fluctuation's standard deviation); the prediction needs at most 250.0 ps"
    );
    insta::assert_snapshot!(message(fluctuating(still, 20e-3, 1e9)), @"within a phase step the delay of path 0 moves by 266.9 ps (walk, and twice the fluctuation's standard deviation); the prediction needs at most 250.0 ps");
}

//! Detections against closed forms and against a naive simulator.

use goldtof::photons::fast::Recorder;
use goldtof::photons::{Detection, DetectorModel};
use goldtof::scan::Group;
use goldtof::scene::{DetectorIndex, Recharge, Scene};
use goldtof::sensor::Sensor;
use optics_support::compared::{
    Comparisons, Tally, assert_chance, columns_of_times, plain_times, recorded_times,
    steps_of_photons,
};
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, ideal_scene, naive, table_i_scene,
};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rayon::prelude::*;

fn counts_per_step(scene: &Scene, seed: u64, steps: u64) -> Moments {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    Moments::of((0..steps).map(|step| model.step(seed, 0, Group(step)).count() as f64))
}

#[test]
fn dead_time_alone_thins_constant_light_and_quiets_it() {
    // 50 Mcps of background, 14 ns: the detector is dead for 0.7 of 1.7.
    let mut scene = ideal_scene(code(&[1, 0, 1]), 0.0, 2_000);
    scene.detectors[0].background_rate_cps = 50e6;
    scene.detectors[0].dead_time_ps = 14e3;
    let counts = counts_per_step(&scene, 11, 3_000);
    let primary = 50e6 * 2_000.0 * 8e-9;
    assert_within_standard_errors(counts.z(primary / 1.7), 5.0, "mean count");
    let variance = primary / 1.7_f64.powi(3);
    assert_within_standard_errors(counts.variance_z(variance), 5.0, "variance of the count");
}

#[test]
fn afterpulses_alone_multiply_the_rate_as_a_branching_process() {
    let mut scene = ideal_scene(code(&[1, 0, 1]), 0.0, 5_000);
    let spad = &mut scene.detectors[0];
    spad.dark_count_rate_cps = 5e6;
    spad.afterpulsing_probability = 0.3;
    spad.afterpulsing_time_constant_ps = 5e3;
    let counts = counts_per_step(&scene, 12, 2_000);
    let mean_afterpulses = -(0.7_f64.ln());
    let primary = 5e6 * 5_000.0 * 8e-9;
    assert_within_standard_errors(counts.z(primary / (1.0 - mean_afterpulses)), 5.0, "mean");
    // Total progeny of a Poisson branching process (Borel): the clusters'
    // second moment over their mean is 1 / (1 - m)^2.
    let fano = (1.0 - mean_afterpulses).powi(-2);
    let variance = primary / (1.0 - mean_afterpulses) * fano;
    assert_within_standard_errors(counts.variance_z(variance), 5.0, "variance");
}

#[test]
fn without_dead_time_counts_follow_the_delayed_code_as_a_poisson_process() {
    let chips = [1, 1, 0, 1, 0, 0, 0];
    let mut scene = ideal_scene(code(&chips), 20e6, 7 * 500);
    scene.sources[0].extinction_ratio = 4.0;
    scene.paths[0].delay_ps = 8000.0 * (9.0 + 0.3);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));

    // Ten bins per chip, so that the delay's 0.3 chips are a bin border.
    let mut bins = [0.0_f64; 70];
    let steps = 200;
    for step in 0..steps {
        for Detection { chip, fraction } in model.step(13, 0, Group(step)) {
            let position = (step * 7 * 500 + chip) % 7;
            bins[position as usize * 10 + (fraction * 10.0) as usize] += 1.0;
        }
    }
    // Mean rate 20 MHz with three on-chips of seven and rates 4 to 1.
    let off_rate = 20e6 * 7.0 / (3.0 * 4.0 + 4.0);
    let seconds_per_bin = 0.8e-9 * 500.0 * steps as f64;
    let mut chi_square = 0.0;
    for (bin, &count) in bins.iter().enumerate() {
        let emitted = (bin as i64 - 93).rem_euclid(70) / 10;
        let rate = if chips[emitted as usize] == 1 { 4.0 * off_rate } else { off_rate };
        let expected = rate * seconds_per_bin;
        chi_square += (count - expected).powi(2) / expected;
    }
    let z = (chi_square - 70.0) / (2.0_f64 * 70.0).sqrt();
    assert_within_standard_errors(z, 5.0, "chi-square over the code period");
}

#[test]
fn modulated_light_with_dead_time_and_afterpulses_agrees_with_a_naive_simulator() {
    agrees_with_a_naive_simulator(2e5);
}

#[test]
#[ignore = "a hundred million photons of each of ten detectors; a quarter of an hour"]
fn modulated_light_agrees_with_a_naive_simulator_over_10_to_the_8_photons() {
    agrees_with_a_naive_simulator(1e8);
}

/// Both engines, with either recharge: so many primary detections at 10^4 to 10^9 a second, by quarter of a chip of
/// the code period, and all of them.
fn agrees_with_a_naive_simulator(photons: f64) {
    let recharges = [Recharge::Active, Recharge::Passive].into_iter();
    let cases =
        recharges.flat_map(|recharge| [1e4, 1e6, 40e6, 200e6, 1e9].map(|rate| (recharge, rate)));
    let cases: Vec<_> = cases.enumerate().collect();
    let compared = cases.into_par_iter().map(|(number, case)| {
        let (recharge, rate) = case;
        let (chips, steps) = steps_of_photons(photons, rate, 7);
        let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), rate, chips);
        let spad = &mut scene.detectors[0];
        spad.jitter_ps.clear();
        (spad.recharge, spad.dark_count_rate_cps) = (recharge, 1e-2 * rate);
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let recorder = Recorder::new(&model);
        let [mut naive, mut plain, mut fast] = [(); 3].map(|()| Tally::new(29));
        let columns = |times: &[f64]| columns_of_times(times, 7, 4);
        let mut rng = StdRng::seed_from_u64(22 + number as u64);
        let all: Vec<_> = (0..steps).map(|step| (0, Group(step))).collect();
        for groups in all.chunks(recorder.groups_at_once().expect("the lanes do it")) {
            for &(_, group) in groups {
                plain.take(&columns(&plain_times(&model, 21, 0, group)));
                let times = naive::detections(&scene, 0, &mut rng, chips as f64, 600.0);
                naive.take(&columns(&times));
            }
            for times in recorder.record(22, groups) {
                fast.take(&columns(&recorded_times(&times)));
            }
        }
        let mut compared = Comparisons::default();
        for (engine, tally) in [("plain", &plain), ("fast", &fast)] {
            compared.add([tally, &naive], &|column| format!("{engine}, column {column}"));
        }
        (format!("{case:?}"), compared)
    });
    // Both engines are held against the same counts.
    assert_chance("one detector", compared.collect(), 2.0);
}

#[test]
fn delay_and_jitter_shift_registered_times_as_independent_gaussians() {
    let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 10e6, 1_000_000);
    scene.detectors[0].jitter_ps = vec![53.5, 40.0];
    let mut bare = scene.clone();
    bare.detectors[0].jitter_ps.clear();
    bare.detectors[0].delay_ps = 0.0;
    let times = |scene: &Scene| -> Vec<(u64, f64)> {
        let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
        let times = model.step(31, 0, Group(0)).map(|d| (d.chip, d.fraction));
        times.collect()
    };
    // The first registered time may lie just across the border of the step.
    let shift_ps = |a: &(u64, f64), b: &(u64, f64)| {
        ((a.0 as f64 - b.0 as f64) + (a.1 - b.1)) * scene.chip_period_ps
    };
    let (jittered, avalanches) = (times(&scene), times(&bare));
    let skip = usize::from(shift_ps(&jittered[0], &avalanches[0]) < 0.0);
    let shifts = Moments::of(jittered[skip..].iter().zip(&avalanches).map(|(a, b)| shift_ps(a, b)));
    assert!(shifts.count > 50_000.0);
    assert_within_standard_errors(shifts.z(1750.0), 5.0, "mean shift");
    let variance = 53.5_f64.powi(2) + 40.0_f64.powi(2);
    assert_within_standard_errors(shifts.variance_z(variance), 5.0, "variance of the shift");
}

#[test]
fn strong_jitter_still_gives_ordered_times_and_loses_none() {
    let mut scene = ideal_scene(code(&[1]), 200e6, 100_000);
    let without = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))
        .step(41, 0, Group(0))
        .count() as f64;
    scene.detectors[0].jitter_ps = vec![20e3];
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let times: Vec<(u64, f64)> =
        model.step(41, 0, Group(0)).map(|d| (d.chip, d.fraction)).collect();
    assert!(times.is_sorted());
    // Shifting a Poisson process independently leaves it Poisson.
    let mean: f64 = 200e6 * 100_000.0 * 8e-9;
    for count in [without, times.len() as f64] {
        assert_within_standard_errors((count - mean) / mean.sqrt(), 5.0, "count");
    }
}

/// Saturated beyond any warm-up: the first detection of a step comes anywhere in
/// a dead time, as it would to a detector that has run for ever.
#[test]
fn steps_of_a_blinded_detector_start_anywhere_in_its_dead_time() {
    // 10^4 photons in a dead time of an eighth of a chip.
    let mut scene = ideal_scene(gold_5(), 1e13, 20);
    scene.sources[0].extinction_ratio = 1.0;
    scene.detectors[0].dead_time_ps = 1_000.0;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let steps = 200;
    let mut eighths = [0.0; 8];
    for step in 0..steps {
        let first = model.step(2, 0, Group(step)).next().expect("it fires");
        let dead_times = (first.chip as f64 + first.fraction) * 8.0;
        eighths[((dead_times * 8.0) as usize).min(7)] += 1.0;
    }
    let mean = steps as f64 / 8.0;
    let chi_square: f64 = eighths.iter().map(|n| (n - mean).powi(2) / mean).sum();
    // Seven degrees of freedom: 24.3 has a chance of one in a thousand.
    assert!(chi_square < 24.3, "{eighths:?}");
}

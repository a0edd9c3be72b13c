//! Crosstalk between detectors against another simulator and closed forms, and where it is refused.

use goldtof::Jobs as _;
use goldtof::photons::DetectorModel;
use goldtof::photons::fast::{OutsideDomain, Recorder, StepCounter};
use goldtof::response::{MeanResponse, MeanResponseError, SecondMoments};
use goldtof::scan::{Group, Step};
use goldtof::scene::{Crosstalk, DetectorIndex, Path, Scene, parse};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use optics_support::compared::{
    Comparisons, Tally, assert_chance, columns_of_runs, plain_times, recorded_times,
    steps_of_photons,
};
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, ideal_scene, naive, repeated,
    table_i_scene,
};
use rand::rngs::StdRng;
use rand::{RngExt as _, SeedableRng as _};
use rayon::prelude::*;

const CHIPS: u64 = 31 * 60;

/// Detectors in a row, each with light of its own delay and strength, and crosstalk to its
/// neighbours.
fn row(rate_cps: f64, chips: u64, strengths: &[f64], probability: f64, delay_ps: f64) -> Scene {
    let mut scene = table_i_scene(gold_5(), rate_cps, chips);
    scene.scan.steps = 8;
    scene.detectors[0].jitter_ps.clear();
    scene.detectors[0].afterpulsing_probability = 0.0;
    scene.detectors[0].dark_count_rate_cps = 71e3 * rate_cps / 40e6;
    let (spad, path) = (scene.detectors.remove(0), scene.paths.remove(0));
    for (number, &transmission) in strengths.iter().enumerate() {
        let mut spad = spad.clone();
        spad.name = format!("spad {number}");
        spad.delay_ps += 450.0 * number as f64;
        spad.crosstalk = Some(Crosstalk { probability, delay_ps });
        scene.detectors.push(spad);
        let delay_ps = path.delay_ps + 33_000.0 * number as f64;
        let detector = DetectorIndex(number);
        scene.paths.push(Path { detector, delay_ps, transmission, ..path.clone() });
    }
    scene
}

/// The detections of a group, of every detector.
fn simulated(models: &[DetectorModel], seed: u64, group: u64) -> Vec<Vec<f64>> {
    models.iter().map(|model| plain_times(model, seed, 0, Group(group))).collect()
}

/// The same of all groups by the vector lanes, which leave detectors that are mostly blind to the plain loop.
fn recorded(models: &[DetectorModel], groups: u64) -> Vec<Vec<Vec<f64>>> {
    let recorders: Vec<_> = models.iter().map(Recorder::new).collect();
    let at_once = recorders.iter().map(Recorder::groups_at_once).min().flatten();
    let groups: Vec<_> = (0..groups).map(|group| (group / 8, Group(group % 8))).collect();
    let of_groups = |groups: &[(u64, Group)]| {
        let lists: Vec<_> = recorders.iter().map(|r| r.record(4, groups)).collect();
        let of_group = |group: usize| lists.iter().map(|l| recorded_times(&l[group])).collect();
        (0..groups.len()).map(of_group).collect::<Vec<_>>()
    };
    let Some(at_once) = at_once else {
        let mut reasons = models.iter().map(|model| StepCounter::new(model).outside_domain());
        assert!(reasons.all(|reason| matches!(reason, Some(OutsideDomain::MostlyBlind { .. }))));
        return Vec::new();
    };
    groups.chunks(at_once).flat_map(of_groups).collect()
}

/// In the other simulator: which of a row's detectors an avalanche of one fires, if they are ready.
fn fired_by(detectors: usize, probability: f64) -> impl Fn(&mut StdRng, usize) -> Vec<usize> {
    move |rng, of| {
        let of_row = [of.wrapping_sub(1), of + 1].into_iter().filter(|&to| to < detectors);
        of_row.filter(|_| rng.random::<f64>() < probability).collect()
    }
}

fn models(scene: &Scene) -> Vec<DetectorModel> {
    let sensor = Sensor::new(scene);
    DetectorIndex::of(&scene.detectors).map(|spad| DetectorModel::new(&sensor, spad)).collect()
}

#[test]
fn detectors_in_a_row_fire_one_another_as_in_another_simulator() {
    fire_one_another_as_in_another_simulator(9e5);
}

#[test]
#[ignore = "a hundred million photons; some minutes"]
fn detectors_in_a_row_fire_one_another_as_in_another_simulator_over_10_to_the_8_photons() {
    fire_one_another_as_in_another_simulator(1e8);
}

/// So many primary detections in all, at rates of 10^4 to 10^9 a second in full light.
fn fire_one_another_as_in_another_simulator(photons: f64) {
    let rows =
        [(&[1.0, 0.2][..], 0.3, 0.0), (&[0.5, 0.0, 1.0], 0.6, 1_310.0), (&[0.3; 4], 1.0, 310.0)];
    let cases = rows.into_iter().flat_map(|row| [1e4, 40e6, 1e9].map(|rate| (row, rate)));
    let cases: Vec<_> = cases.enumerate().collect();
    let compared = cases.into_par_iter().map(|(number, case)| {
        let ((strengths, probability, delay_ps), rate) = case;
        let lit: f64 = strengths.iter().sum();
        let (chips, steps) = steps_of_photons(photons / 9.0 / lit, rate, 31);
        let scene = row(rate, chips, strengths, probability, delay_ps);
        let models = models(&scene);
        let detectors = strengths.len();
        let [mut product, mut lanes, mut other] =
            [(); 3].map(|()| Tally::new(detectors * 125 + detectors * detectors * 160));
        let mut rng = StdRng::seed_from_u64(5 + number as u64);
        let neighbours = fired_by(detectors, probability);
        for step in 0..steps {
            // Groups of whole code periods begin with the code.
            product.take(&columns_of_runs(&simulated(&models, 3 + step / 8, step % 8)));
            let chips = chips as f64;
            let runs = naive::coupled_detections(&scene, &mut rng, chips, 600.0, &neighbours);
            other.take(&columns_of_runs(&runs));
        }
        for runs in recorded(&models, steps) {
            lanes.take(&columns_of_runs(&runs));
        }
        let mut compared = Comparisons::default();
        for (engine, ours) in [("plain", product), ("lanes", lanes)] {
            compared.add([&ours, &other], &|column| format!("{engine}, column {column}"));
        }
        (format!("{case:?}"), compared)
    });
    // Detectors that surely fire one another tell the same, and both engines are held against the
    // same counts.
    assert_chance("crosstalk", compared.collect(), 8.0);
}

/// Of few photons each fires the neighbour with the probability that the scene has, at the delay that
/// it has, to the last digit: both detectors see one history.
#[test]
fn seldom_photons_fire_the_neighbour_with_the_probability_and_delay_of_the_scene() {
    let mut scene = row(40e6, CHIPS, &[0.01, 0.01], 0.25, 700.0);
    scene.detectors[1].crosstalk = None;
    let models = models(&scene);
    let (mut fired, mut by_other) = (0.0, 0.0);
    for group in 0..3_000 {
        let [first, second] =
            [0, 1].map(|place| simulated(&models, group / 8, group % 8).remove(place));
        fired += first.len() as f64;
        // Registered times differ by the detectors' delays, too.
        let later = (700.0 + 450.0) / 8_000.0;
        let caused = |time: &&f64| second.iter().any(|other| (other - **time - later).abs() < 1e-9);
        by_other += first.iter().filter(caused).count() as f64;
    }
    // The neighbour is ready but for 14 ns after each of its own 0.59 million detections a second.
    let heard = 0.25 * (1.0 - 14e-9 * (0.471e6 * 1.25));
    let z = (by_other / fired - heard) / (0.25 * 0.75 / fired).sqrt();
    println!("{by_other} of {fired}");
    assert!(fired > 1_000.0);
    assert_within_standard_errors(z, 4.0, "probability");
}

#[test]
fn a_probability_of_nothing_changes_no_bit() {
    let with = row(40e6, CHIPS, &[1.0, 0.5], 0.0, 300.0);
    let mut without = with.clone();
    without.detectors.iter_mut().for_each(|spad| spad.crosstalk = None);
    assert_eq!(simulated(&models(&with), 4, 2), simulated(&models(&without), 4, 2));
    // Nor does that of a detector which nobody hears, for itself.
    let mut one_way = row(40e6, CHIPS, &[1.0, 0.5], 0.4, 300.0);
    one_way.detectors[1].crosstalk = None;
    let [alone, heard] = [&without, &one_way].map(|scene| simulated(&models(scene), 4, 2));
    assert_ne!(alone[1], heard[1]);
}

/// Hits of each sample of the code period, and the total's mean and variance, to first order in the
/// probability: of neighbours that are brighter and dimmer, earlier and later than a dead time.
#[test]
fn what_is_expected_is_what_another_simulator_counts() {
    for (number, (strengths, probability, delay_ps)) in
        (0..).zip([(&[1.0, 0.2][..], 0.025, 300.0), (&[0.1, 0.6, 0.0], 0.006, 21_350.0)])
    {
        let mut scene = row(40e6, CHIPS, strengths, probability, delay_ps);
        scene.detectors.iter_mut().for_each(|spad| spad.pulse_width_ps = 5e3);
        let models = models(&scene);
        let mut rng = StdRng::seed_from_u64(90 + number);
        let mut hits = vec![[0.0; 31 * 8]; strengths.len()];
        let mut totals = vec![Vec::new(); strengths.len()];
        let fired = fired_by(strengths.len(), probability);
        for _ in 0..repeated(700, 20_000) {
            let runs = naive::coupled_detections(&scene, &mut rng, CHIPS as f64, 600.0, &fired);
            for (place, times) in runs.iter().enumerate() {
                totals[place].push(times.len() as f64);
                for time in times {
                    hits[place][(time * 8.0).ceil() as usize % (31 * 8)] += 1.0;
                }
            }
        }
        for (place, model) in models.iter().enumerate() {
            let what = format!("{strengths:?}, {place}");
            let response = MeanResponse::new(model).expect("to first order");
            let of_period = response.hits_per_sample();
            let periods = totals[place].len() as f64 * (CHIPS / 31) as f64;
            let expected: Vec<f64> = of_period.iter().map(|hits| hits * periods).collect();
            // Somewhat less than Poisson scatter, behind a dead time.
            let squares = expected.iter().zip(hits[place]).map(|(e, n)| (n - e).powi(2) / e);
            let z = (squares.sum::<f64>() / 248.0 - 1.0) / (2.0_f64 / 248.0).sqrt();
            println!("{what}: chi-square {z:+.2}");
            assert!(z < 4.0, "{what}: chi-square by {z} standard deviations");
            let found = Moments::of(totals[place].clone());
            let mean = expected.iter().sum::<f64>() / found.count;
            let z = (found.mean - mean) / found.standard_error();
            assert_within_standard_errors(z, 4.0, &format!("{what}: mean"));
            let variance =
                SecondMoments::new(&response).expect("solved").of_step(Step(3)).total_variance;
            let z = (found.variance / variance).ln() / (2.0 / (found.count - 1.0)).sqrt();
            assert_within_standard_errors(z, 4.0, &format!("{what}: variance"));
        }
    }
}

/// Constant light: each other's rate is r = lambda / (1 + lambda D), and what hears it has p r more light.
#[test]
fn constant_light_gives_the_closed_form_of_first_order() {
    let mut scene = ideal_scene(code(&[1]), 20e6, 1_000);
    scene.detectors[0].dead_time_ps = 14e3;
    let mut second = scene.detectors[0].clone();
    second.name = "second".to_owned();
    scene.detectors[0].crosstalk = Some(Crosstalk { probability: 0.02, delay_ps: 700.0 });
    scene.detectors.push(second);
    let path = Path { detector: DetectorIndex(1), transmission: 0.3, ..scene.paths[0].clone() };
    scene.paths.push(path);
    let detected = |primary: f64| primary / (1.0 + primary * 14e-9);
    let [first, second] = [20e6, 0.3 * 20e6];
    let expected = [detected(first), detected(second + 0.02 * detected(first))];
    for (model, expected) in models(&scene).iter().zip(expected) {
        let found = MeanResponse::new(model).expect("solved").detection_rate_hz();
        // The model rounds the light to as much.
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }
}

/// A bright neighbour whose avalanches are a dead time apart, without anything heard in turn: events as many at
/// any time would lose 3 % of the counts.
#[test]
fn a_dim_detector_beside_a_bright_one_is_not_expected() {
    let mut scene = row(40e6, CHIPS, &[1.0, 0.02], 0.1, 300.0);
    scene.detectors[1].crosstalk = None;
    let refused = MeanResponse::new(&models(&scene)[1]).err();
    assert!(matches!(refused, Some(MeanResponseError::Crosstalk { .. })), "{refused:?}");
}

#[test]
fn too_much_of_it_is_refused_by_name_and_photons_are_simulated() {
    let scene = row(40e6, CHIPS, &[1.0, 0.5], 0.1, 300.0);
    let model = &models(&scene)[1];
    let refused = MeanResponse::new(model).err();
    assert!(matches!(refused, Some(MeanResponseError::Crosstalk { .. })), "{refused:?}");
    let mut scene = scene;
    scene.scan.steps = scene.scan.steps_per_period;
    scene.scan.integration_chips = 310;
    let sensor = Sensor::new(&scene);
    for tier in [Tier::Expected, Tier::Counts] {
        let error = sensor.simulate(tier.scans(2)).expect_err("refused").to_string();
        assert!(error.contains("crosstalk to first order"), "{tier}: {error}");
    }
    for tier in [Tier::Events, Tier::Sampled] {
        let simulation = sensor.simulate(tier.scans(3)).expect("photons");
        assert_eq!(simulation.estimates.len(), 2);
        for path in &simulation.estimates {
            assert_eq!((path.expected_bias_m, path.bound_m), (None, None));
            let remark = path.remark.as_deref().unwrap_or_default();
            assert!(remark.contains("crosstalk"), "{tier}: {remark}");
        }
    }
}

#[test]
fn scenes_with_crosstalk_that_is_not_simulated_are_refused() {
    let dual = std::fs::read_to_string("scenes/dual-view.toml").expect("it is there");
    let detector = dual.find("[[detector]]").expect("a detector");
    let next = dual[detector + 1..].find("\n[").map_or(dual.len(), |at| detector + 1 + at);
    let spad = &dual[detector..next];
    let talking = spad.replace("[[detector]]", "[[detector]]\ncrosstalk = { probability = 0.1 }");
    let second = spad.replace("name = \"spad\"", "name = \"second\"");
    let scene = |first: &str, second: &str| {
        let text = format!("{}{first}\n{second}\n{}", &dual[..detector], &dual[next..]);
        parse("two.toml", &text).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(scene(&talking, &second), Ok(()));
    let alone = scene(&talking, "").expect_err("alone");
    assert!(alone.contains("the scene has no other detector"), "{alone}");
    let passive = second.replace("[[detector]]", "[[detector]]\nrecharge = \"passive\"");
    let error = scene(&talking, &passive).expect_err("passive");
    assert!(error.contains("recharge = \"active\" alone"), "{error}");
    let lines = talking.lines().filter(|line| !line.trim_start().starts_with("dead_time"));
    let without: Vec<&str> = lines.collect();
    let error = scene(&without.join("\n"), &second).expect_err("no dead time");
    assert!(error.contains("give it a dead_time"), "{error}");
}

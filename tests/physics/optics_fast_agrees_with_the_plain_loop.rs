//! The fast engine against the plain loop: two constructions of one
//! distribution.

use goldtof::code::Code;
use goldtof::photons::fast::StepCounter;
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::scan::{Group, Step};
use goldtof::scene::{
    DetectorIndex, JitterTail, LaserResponse, Movement, Path, Recharge, Scan, Scene, SourceIndex,
    WaveformCurve,
};
use goldtof::sensor::Sensor;
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, gold_11, ideal_scene, repeated,
    table_i_scene,
};

/// Counts of both, by step and scan.
struct Comparison {
    plain: Vec<Vec<StepCount>>,
    fast: Vec<Vec<StepCount>>,
}

impl Comparison {
    /// Simulates the steps of a scene's scan in `scans` scans.
    fn of(scene: &Scene, scans: u64) -> Comparison {
        Comparison::of_seed(1, scene, scans)
    }

    /// The same of the lanes' seed: scenes that differ in what becomes of avalanches alone have
    /// the same ones for the same seed, and are one comparison of totals.
    fn of_seed(seed: u64, scene: &Scene, scans: u64) -> Comparison {
        let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
        let steps = scene.scan.steps;
        let counter = StepCounter::new(&model);
        assert_eq!(counter.outside_domain(), None, "the lanes must be used");
        let mut counts = vec![StepCount::ZERO; (scans * steps) as usize];
        counter.count(seed, 0..scans, 0..steps, &mut counts);
        let by_step = |count: &dyn Fn(u64, u64) -> StepCount| {
            (0..steps).map(|step| (0..scans).map(|scan| count(scan, step)).collect()).collect()
        };
        Comparison {
            plain: by_step(&|scan, step| count_step(&model, 2, scan, Step(step))),
            fast: by_step(&|scan, step| counts[(scan * steps + step) as usize]),
        }
    }

    fn detections(&self) -> u64 {
        self.fast.iter().flatten().map(|count| count.total).sum()
    }

    /// Means and variances of signed and total counts of every step, within 4.5
    /// standard errors each and within 3 together.
    #[track_caller]
    fn assert_same_distribution(&self, what: &str) {
        for (name, value) in [
            ("signed", (|c| c.signed as f64) as fn(&StepCount) -> f64),
            ("total", |c| c.total as f64),
        ] {
            let mut means = Vec::new();
            let mut variances = Vec::new();
            for (step, (plain, fast)) in self.plain.iter().zip(&self.fast).enumerate() {
                let plain: Vec<f64> = plain.iter().map(value).collect();
                let fast: Vec<f64> = fast.iter().map(value).collect();
                let mean = difference_of_means(&plain, &fast);
                let variance = difference_of_means(&deviations(&plain), &deviations(&fast));
                let what = format!("{what}, step {step}, {name}");
                assert_within_standard_errors(mean, 4.5, &format!("{what}: mean"));
                assert_within_standard_errors(variance, 4.5, &format!("{what}: variance"));
                means.push(mean);
                variances.push(variance);
            }
            let what = format!("{what}, {name}");
            assert_together(&means, &format!("{what}: means"));
            assert_together(&variances, &format!("{what}: variances"));
        }
    }
}

/// In standard errors.
fn difference_of_means(a: &[f64], b: &[f64]) -> f64 {
    let [a, b] = [a, b].map(|values| Moments::of(values.iter().copied()));
    (b.mean - a.mean) / a.standard_error().hypot(b.standard_error())
}

/// Squared deviations, whose mean is the variance: no normal distribution is
/// taken for granted, and counts of few detections have none.
fn deviations(values: &[f64]) -> Vec<f64> {
    let mean = Moments::of(values.iter().copied()).mean;
    values.iter().map(|value| (value - mean).powi(2)).collect()
}

/// The sum and the sum of squares of unit normal numbers.
#[track_caller]
fn assert_together(z: &[f64], what: &str) {
    let n = z.len() as f64;
    let sum = z.iter().sum::<f64>() / n.sqrt();
    assert_within_standard_errors(sum, 3.0, what);
    let squares = z.iter().map(|z| z * z).sum::<f64>();
    // As a normal number (Wilson and Hilferty): of few steps it is very skew.
    let ninth = 2.0 / (9.0 * n);
    let chi_square = ((squares / n).cbrt() - (1.0 - ninth)) / ninth.sqrt();
    assert_within_standard_errors(chi_square, 3.5, &format!("chi-square of {what}"));
}

/// Some steps round the peak of Table I's sensor at 3.2 m, at k = 20 to 23, and
/// then a stretch without a peak.
fn table_i_window(detected_rate_cps: f64) -> Scene {
    // Primary rate that gives the detected one with dead time and afterpulses.
    let alive = 1.0 - detected_rate_cps * 14e-9;
    let primary = detected_rate_cps * 0.9 / alive;
    let mut scene = table_i_scene(gold_11(), primary, 13_100);
    scene.scan = Scan { first_step: 12, steps: 24, ..scene.scan };
    scene
}

#[test]
fn table_i_counts_agree_from_1_to_45_million_detections_per_second() {
    for (rate, scans) in [(1e6, 2_100), (10e6, 210), (45e6, 50)] {
        let comparison = Comparison::of(&table_i_window(rate), scans);
        assert!(comparison.detections() > 5_000_000);
        comparison.assert_same_distribution(&format!("{rate:.0e}"));
    }
}

/// In release mode about a minute.
#[test]
#[ignore = "a hundred million detections per rate; run with --release"]
fn table_i_counts_agree_over_a_hundred_million_detections() {
    for (rate, scans) in [(1e6, 40_000), (10e6, 4_200), (45e6, 1_000)] {
        let comparison = Comparison::of(&table_i_window(rate), scans);
        assert!(comparison.detections() > 100_000_000);
        comparison.assert_same_distribution(&format!("{rate:.0e}"));
    }
}

/// A dead time of some 125 chips, in which ten photons come: 230 of them until the plain loop has
/// forgotten its start, and steps of a tenth of one. 992 ns are four periods of the code, to which the
/// detector locks: where in it a step begins decides what it counts.
#[test]
fn starts_of_saturated_detectors_are_drawn_as_they_come_to_be() {
    for (dead_time_ps, probability, rise_time_ps) in
        [(992e3, 0.137, 0.0), (1e6, 0.137, 1e3), (1e6, 0.0, 0.0), (600e3, 0.9, 0.0)]
    {
        let mut scene = table_i_scene(gold_5(), 5e6, 12);
        scene.scan = Scan { first_step: 0, steps: 31, ..scene.scan };
        scene.sources[0].response = LaserResponse::Edges { rise_time_ps, fall_time_ps: 0.0 };
        let spad = &mut scene.detectors[0];
        spad.dead_time_ps = dead_time_ps;
        spad.afterpulsing_probability = probability;
        let comparison = Comparison::of(&scene, repeated(1_000, 3_000));
        assert!(comparison.detections() > 1_500);
        comparison.assert_same_distribution(&format!("{dead_time_ps} ps, {probability}"));
    }
}

/// Jitter of more than a chip, and near edges of several steps that share their light: each detection's
/// is drawn.
#[test]
fn jitter_beyond_a_chip_is_drawn() {
    for (jitter_ps, parallel, transition_ps) in
        [(900.0, 1, 60.0), (3_000.0, 1, 0.0), (300.0, 4, 200.0), (20_000.0, 2, 500.0)]
    {
        let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 60e6, 150);
        scene.chip_period_ps = 2000.0;
        scene.scan.steps = 40;
        scene.hardware.parallel = parallel;
        let spad = &mut scene.detectors[0];
        spad.jitter_ps = vec![jitter_ps];
        spad.dead_time_ps = 900.0;
        spad.pulse_width_ps = 450.0;
        spad.counter.rising_delay_ps = 100.0;
        spad.counter.falling_delay_ps = 310.0;
        spad.counter.transition_ps = transition_ps;
        let comparison = Comparison::of(&scene, repeated(1_000, 2_000));
        comparison.assert_same_distribution(&format!("jitter of {jitter_ps} ps, {parallel} steps"));
    }
}

#[test]
fn jitter_carries_detections_over_the_borders_of_a_step_and_of_chips() {
    // Three chips of 2 ns with 41 ps of jitter: every twelfth detection is near
    // a border. Rising and falling edges are far apart.
    let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 60e6, 3);
    scene.chip_period_ps = 2000.0;
    scene.scan.steps = 40;
    let spad = &mut scene.detectors[0];
    spad.jitter_ps = vec![40.0, 9.0];
    spad.dead_time_ps = 900.0;
    spad.counter.rising_delay_ps = 100.0;
    spad.counter.falling_delay_ps = 310.0;
    spad.counter.transition_ps = 60.0;
    let comparison = Comparison::of(&scene, repeated(10_000, 20_000));
    comparison.assert_same_distribution("jitter at borders");
}

#[test]
fn every_path_and_code_adds_its_light() {
    // Two codes of 31 and 7 chips, three paths, none aligned to samples; 101
    // chips a step, so that steps begin anywhere in the code.
    let mut scene = table_i_scene(gold_5(), 20e6, 101);
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    other.code = code(&[1, 1, 1, 0, 1, 0, 0]);
    other.extinction_ratio = 3.0;
    scene.sources.push(other);
    for (source, delay_ps, transmission) in [(0, 91_234.5, 0.4), (1, 4_321.0, 0.7)] {
        scene.paths.push(Path {
            source: SourceIndex(source),
            detector: DetectorIndex(0),
            delay_ps,
            transmission,
            movement: None,
        });
    }
    Comparison::of(&scene, 600).assert_same_distribution("paths and codes");
}

#[test]
fn a_sharp_counter_and_a_bare_detector_agree_too() {
    let mut scene = ideal_scene(gold_5(), 30e6, 203);
    scene.paths[0].delay_ps = 12_345.6;
    Comparison::of(&scene, 400).assert_same_distribution("bare");
    scene.detectors[0].counter.rising_delay_ps = 700.0;
    scene.detectors[0].dead_time_ps = 31e3;
    Comparison::of(&scene, 400).assert_same_distribution("late rising edges");
}

#[test]
fn strong_afterpulsing_of_a_slow_kind_agrees() {
    let mut scene = table_i_scene(gold_5(), 5e6, 500);
    let spad = &mut scene.detectors[0];
    spad.afterpulsing_probability = 0.45;
    spad.afterpulsing_time_constant_ps = 60e3;
    scene.scan.steps = 40;
    Comparison::of(&scene, 1000).assert_same_distribution("slow afterpulses");
}

#[test]
fn faint_light_and_long_steps_agree() {
    // Waits of many code periods, and counts that are taken in batches.
    let steps = 8;
    let mut scene = table_i_scene(gold_5(), 12e3, 1_000_000);
    scene.detectors[0].dark_count_rate_cps = 3e3;
    scene.scan.steps = steps;
    Comparison::of(&scene, 1500).assert_same_distribution("faint and long");
}

#[test]
fn codes_of_many_lengths_give_the_same_light() {
    for length in [1, 2, 3, 1023, 1500, 4094] {
        // Half of the chips on, or all of one.
        let chips: Vec<u8> = (0..length).map(|chip| u8::from(chip % 3 != 1)).collect();
        let mut scene = table_i_scene(code(&chips), 15e6, 3_333);
        scene.scan = Scan { first_step: 0, steps: 8, steps_per_period: 8 * length, ..scene.scan };
        let comparison = Comparison::of(&scene, 150);
        comparison.assert_same_distribution(&format!("{length} chips"));
    }
}

/// A code is a code: nothing depends on how it was made.
#[test]
fn repeating_a_code_twice_changes_nothing() {
    let once = gold_5();
    let twice: Code = {
        let chips = [once.chips.clone(), once.chips.clone()].concat();
        Code::clone(&code(&chips))
    };
    let counts = |code: Code| {
        let mut scene = table_i_scene(code.into(), 15e6, 500);
        scene.scan = Scan { first_step: 3, steps: 100, steps_per_period: 8 * 62, ..scene.scan };
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let mut counts = vec![StepCount::ZERO; 100];
        StepCounter::new(&model).count(1, 0..1, 0..100, &mut counts);
        counts
    };
    let once = Code::clone(&once);
    assert_eq!(counts(once), counts(twice));
}

/// Light with edges that rise and fall as quickly, or not, and a pulse as measured, of which
/// the lanes thin candidates, where the plain loop adds up lasers.
#[test]
fn edges_of_the_light_agree() {
    let edges = |rise_time_ps, fall_time_ps| LaserResponse::Edges { rise_time_ps, fall_time_ps };
    let stretched = |edge_ps, longer_ps| LaserResponse::Stretched {
        rise_time_ps: edge_ps,
        fall_time_ps: 0.5 * edge_ps,
        longer_ps,
    };
    let long = (0..60).map(|n| [f64::from(n) * 1e3 - 12e3, 1.0 / 60.0]).collect();
    for response in [
        edges(1e3, 1e3),
        edges(1e3, 3e3),
        edges(6e3, 500.0),
        stretched(0.0, 900.0),
        stretched(0.0, -1_300.0),
        stretched(1e3, 2e3),
        LaserResponse::Measured(WaveformCurve {
            points: vec![[-900.0, 0.3], [0.0, 0.4], [9.9e3, 0.3]],
        }),
        // Longer than a profile.
        LaserResponse::Measured(WaveformCurve { points: long }),
    ] {
        let mut scene = table_i_scene(gold_5(), 25e6, 1_000);
        scene.scan.steps = 40;
        scene.sources[0].response = response.clone();
        Comparison::of(&scene, repeated(150, 300))
            .assert_same_distribution(&format!("{response:?}"));
    }
}

/// Paths that walk by some phase steps within a scan, and a source whose clock gains or loses a code period in each,
/// also with edges and with passive recharge.
#[test]
fn light_of_moving_paths_agrees() {
    let edges = LaserResponse::Edges { rise_time_ps: 1e3, fall_time_ps: 3e3 };
    for (velocity_m_per_s, periods, response, recharge) in [
        (1_200.0, 0.0, LaserResponse::Ideal, Recharge::Active),
        (-9_000.0, 0.0, edges.clone(), Recharge::Active),
        (0.0, 1.0, LaserResponse::Ideal, Recharge::Active),
        (4_000.0, -1.0, edges, Recharge::Passive),
    ] {
        let mut scene = table_i_scene(gold_5(), 20e6, 1_000);
        scene.scan.steps = 60;
        scene.paths[0].movement = Some(Movement { velocity_m_per_s, fluctuation: None });
        scene.sources[0].response = response;
        let scan_chips = Sensor::new(&scene).timing().first_chip(1, Group(0)).0;
        scene.sources[0].clock.offset = periods * 31.0 / scan_chips as f64;
        scene.detectors[0].recharge = recharge;
        let comparison = Comparison::of(&scene, repeated(200, 4_000));
        comparison.assert_same_distribution(&format!("{velocity_m_per_s} m/s, {periods}"));
    }
}

#[test]
fn a_paralyzable_detector_agrees() {
    for (rate, afterpulsing) in [(5e6, 0.4), (60e6, 0.137), (400e6, 0.0)] {
        let mut scene = table_i_scene(gold_5(), rate, 1_000);
        scene.scan.steps = 40;
        let spad = &mut scene.detectors[0];
        spad.recharge = Recharge::Passive;
        spad.afterpulsing_probability = afterpulsing;
        spad.afterpulsing_time_constant_ps = 20e3;
        if rate > 50e6 {
            scene.sources[0].response =
                LaserResponse::Edges { rise_time_ps: 1e3, fall_time_ps: 3e3 };
        }
        Comparison::of(&scene, repeated(120, 300))
            .assert_same_distribution(&format!("passive, {rate:.0e}"));
    }
}

/// Jitter that a table of probabilities near edges cannot decide.
#[test]
fn jitter_with_a_tail_and_jitter_over_chips_agree() {
    let mut scene = table_i_scene(gold_5(), 25e6, 1_000);
    scene.scan.steps = 40;
    let scans = repeated(300, 600);
    scene.detectors[0].jitter_ps = vec![3e3];
    Comparison::of_seed(3, &scene, scans).assert_same_distribution("jitter");
    scene.detectors[0].jitter_ps = vec![200.0];
    scene.detectors[0].counter.rising_delay_ps = 9e3;
    scene.detectors[0].jitter_tail = JitterTail::Exponential { share: 0.3, time_constant_ps: 5e3 };
    Comparison::of_seed(4, &scene, scans).assert_same_distribution("exponential tail");
    scene.detectors[0].jitter_tail =
        JitterTail::Measured(WaveformCurve { points: vec![[0.0, 0.5], [2e3, 0.3], [20e3, 0.2]] });
    Comparison::of_seed(5, &scene, scans).assert_same_distribution("measured tail");
}

/// Codes longer than waits, and two whose common period no table holds.
#[test]
fn long_codes_and_unlike_periods_agree() {
    let random = |length: u64| -> Vec<u8> {
        (0..length).map(|chip| ((chip * chip * 2_654_435_761) >> 31 & 1) as u8).collect()
    };
    let mut scene = table_i_scene(code(&random(65_535)), 25e6, 3_001);
    scene.scan = Scan { first_step: 7, steps: 24, steps_per_period: 8 * 65_535, ..scene.scan };
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    other.code = code(&random(3_571));
    scene.sources.push(other);
    scene.paths.push(Path {
        source: SourceIndex(1),
        detector: DetectorIndex(0),
        delay_ps: 654_321.5,
        transmission: 0.4,
        movement: None,
    });
    Comparison::of(&scene, 300).assert_same_distribution("long codes");
}

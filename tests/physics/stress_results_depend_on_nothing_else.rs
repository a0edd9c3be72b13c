//! Results depend on scene and seed: not on threads, on blocks, on the order of
//! tables, or on what ran before.

use std::num::NonZero;
use std::process::Command;

use goldtof::Jobs as _;
use goldtof::estimate::{CountingTier, predict};
use goldtof::photons::fast::StepCounter;
use goldtof::photons::{DetectorModel, PulseStream, StepCount};
use goldtof::response::MeanResponse;
use goldtof::scan::Sample;
use goldtof::scene::{DetectorIndex, PathIndex, Scene, SourceIndex, parse};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use optics_support::{gold_5, table_i_scene};
use serde_json::Value;

const HEADER: &str = r#"
[clock]
chip_period = "8 ns"

[scan]
integration = "8 us"
"#;

const SOURCES: [&str; 3] = [
    r#"
[[source]]
name = "laser"
code = { family = "gold", degree = 5, index = 0 }
wavelength = "783 nm"
mean_power = "20 pW"
extinction_ratio = 10
"#,
    r#"
[[source]]
name = "other"
code = { family = "gold", degree = 5, index = 3 }
wavelength = "850 nm"
mean_power = "13 pW"
extinction_ratio = 7
"#,
    r#"
[[source]]
name = "third"
code = { family = "m-sequence", degree = 4 }
wavelength = "905 nm"
mean_power = "11 pW"
extinction_ratio = 30
"#,
];

const DETECTORS: [&str; 2] = [
    r#"
[[detector]]
name = "left"
reference = "laser"
photon_detection_probability = 0.31
dark_count_rate = "71 kcps"
dead_time = "14 ns"
afterpulsing = { probability = 0.137, time_constant = "5 ns" }
jitter = ["53.5 ps"]
"#,
    r#"
[[detector]]
name = "right"
reference = "other"
photon_detection_probability = 0.2
dead_time = "9 ns"
"#,
];

const PATHS: [(&str, &str, &str); 7] = [
    ("laser", "left", "3.2 m"),
    ("laser", "left", "4.7 m"),
    ("other", "left", "1.1 m"),
    ("third", "left", "0.4 m"),
    ("laser", "right", "2.3 m"),
    ("other", "right", "5.9 m"),
    ("other", "right", "0.7 m"),
];

fn path(place: usize) -> String {
    let (source, detector, distance) = PATHS[place];
    format!(
        "\n[[path]]\nsource = \"{source}\"\ndetector = \"{detector}\"\ndistance = \"{distance}\"\n"
    )
}

/// The scene with its tables in this order.
fn scene(sources: [usize; 3], detectors: [usize; 2], paths: [usize; 7]) -> Scene {
    let mut text = HEADER.to_owned();
    // Tables of different kinds mix, too.
    for (place, &of_path) in paths.iter().enumerate() {
        text += &path(of_path);
        text += sources.get(place).map_or("", |&source| SOURCES[source]);
        text += detectors.get(place).map_or("", |&detector| DETECTORS[detector]);
    }
    parse("order.toml", &text).unwrap()
}

fn in_order() -> Scene {
    scene([0, 1, 2], [0, 1], [0, 1, 2, 3, 4, 5, 6])
}

fn orders() -> Vec<Scene> {
    vec![
        scene([2, 1, 0], [1, 0], [6, 5, 4, 3, 2, 1, 0]),
        scene([1, 2, 0], [0, 1], [3, 0, 6, 1, 5, 2, 4]),
        scene([0, 2, 1], [1, 0], [1, 0, 3, 2, 6, 5, 4]),
    ]
}

fn detector(scene: &Scene, name: &str) -> usize {
    scene.detectors.iter().position(|d| d.name == name).unwrap()
}

fn events(scene: &Scene, name: &str) -> Vec<StepCount> {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(detector(scene, name)));
    let mut counts = vec![StepCount::ZERO; 248];
    StepCounter::new(&model).count(5, 0..1, 0..248, &mut counts);
    counts
}

#[test]
fn the_order_of_tables_changes_no_count_and_no_pulse() {
    let reference = in_order();
    for other in orders() {
        for name in ["left", "right"] {
            assert_eq!(events(&reference, name), events(&other, name), "{name}");
            let pulses = |scene: &Scene| {
                let model =
                    DetectorModel::new(&Sensor::new(scene), DetectorIndex(detector(scene, name)));
                let mut pulses = Vec::new();
                PulseStream::new(&model, 5, 0).advance(Sample(200_000), &mut pulses);
                assert!(pulses.len() > 100);
                pulses
            };
            assert_eq!(pulses(&reference), pulses(&other), "{name}");
        }
    }
}

#[test]
fn the_order_of_tables_changes_no_expected_count() {
    let reference = in_order();
    for other in orders() {
        for name in ["left", "right"] {
            let means = |scene: &Scene| {
                let model =
                    DetectorModel::new(&Sensor::new(scene), DetectorIndex(detector(scene, name)));
                MeanResponse::new(&model).unwrap().mean_counts()
            };
            assert_eq!(means(&reference), means(&other), "{name}");
        }
    }
}

#[test]
fn the_order_of_tables_changes_no_estimate() {
    // By detector and true distance: (estimates, mean, scatter).
    let estimates = |scene: &Scene, tier: Tier| {
        let mut found: Vec<_> = Sensor::new(scene)
            .simulate(tier.scans(3).seeded(5))
            .unwrap()
            .estimates
            .into_iter()
            .map(|e| {
                let true_um = (e.true_distance_m * 1e6).round() as i64;
                (e.detector, true_um, e.estimates, e.mean_distance_m, e.std_m)
            })
            .collect();
        found.sort_by(|a, b| (&a.0, a.1).cmp(&(&b.0, b.1)));
        assert_eq!(found.len(), 4);
        found
    };
    let reference = in_order();
    // Each order by one tier at least; what follows from counts is the same for all.
    let orders = orders();
    for (tier, orders) in
        [(Tier::Events, &orders[..1]), (Tier::Counts, &orders[1..2]), (Tier::Sampled, &orders[..])]
    {
        let expected = estimates(&reference, tier);
        for other in orders {
            assert_eq!(expected, estimates(other, tier), "{tier}");
        }
    }
}

#[test]
fn a_further_source_detector_or_dark_path_changes_no_other_number() {
    let reference = in_order();
    let expected = events(&reference, "right");
    let mut more = reference.clone();
    let mut first = more.detectors[0].clone();
    first.name = "a-first-detector".to_owned();
    more.detectors.insert(0, first);
    for path in &mut more.paths {
        path.detector.0 += 1;
    }
    let mut dark = more.sources[0].clone();
    dark.name = "a-first-source".to_owned();
    dark.mean_power_w = 0.0;
    more.sources.push(dark);
    let mut path = more.paths[0].clone();
    path.source = SourceIndex(more.sources.len() - 1);
    path.detector = DetectorIndex(detector(&more, "right"));
    more.paths.insert(0, path);
    assert_eq!(events(&more, "right"), expected);
}

#[test]
fn threads_do_not_change_a_count() {
    let scene = in_order();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let counts = |threads: usize| {
        let mut counts = vec![StepCount::ZERO; 3 * 248];
        let threads = NonZero::new(threads).unwrap();
        StepCounter::new(&model).count_on_threads(threads, 5, 0..3, 0..248, &mut counts);
        counts
    };
    let one = counts(1);
    assert_eq!(one, counts(2));
    assert_eq!(one, counts(3));
}

/// JSON of a command without its run times.
fn answer(arguments: &[&str]) -> Value {
    let output =
        Command::new(env!("CARGO_BIN_EXE_goldtof")).args(arguments).arg("--json").output().unwrap();
    let mut answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    answer.as_object_mut().unwrap().remove("run_time_s");
    answer
}

#[test]
fn the_same_seed_gives_the_same_answer_whatever_ran_before() {
    let simulate = |tier: &str, seed: &str| {
        answer(&[
            "simulate",
            "scenes/quick.toml",
            "--repeat",
            "5",
            "--fidelity",
            tier,
            "--seed",
            seed,
        ])
    };
    let tiers = ["expected", "counts", "events", "sampled"];
    let first: Vec<Value> = tiers.iter().map(|tier| simulate(tier, "3")).collect();
    for (tier, first) in tiers.iter().zip(&first).rev() {
        assert_eq!(simulate(tier, "3"), *first, "{tier}");
        if *tier != "expected" {
            let other = simulate(tier, "4");
            assert_ne!(other["estimates"], first["estimates"], "{tier}");
        }
    }
    // Within one process, too.
    let scene = table_i_scene(gold_5(), 20e6, 1_000);
    let before = simulate_twice(&scene, &[Tier::Events, Tier::Sampled, Tier::Counts]);
    let after = simulate_twice(&scene, &[Tier::Counts, Tier::Sampled, Tier::Events]);
    assert_eq!(before[0], after[2]);
    assert_eq!(before[1], after[1]);
    assert_eq!(before[2], after[0]);
}

/// Bias and scatter of each tier, one after another in the same process.
fn simulate_twice(scene: &Scene, tiers: &[Tier]) -> Vec<(Option<f64>, Option<f64>)> {
    tiers
        .iter()
        .map(|&tier| {
            let expected =
                predict(&Sensor::new(scene), DetectorIndex(0), PathIndex(0), CountingTier::Sampled)
                    .unwrap();
            assert!(expected.std_m > 0.0);
            let path =
                Sensor::new(scene).simulate(tier.scans(4).seeded(9)).unwrap().estimates.remove(0);
            (path.bias_m, path.std_m)
        })
        .collect()
}

/// Correlation coefficient of two samples of equal length and mean zero, in
/// standard errors.
fn correlation_z(a: &[f64], b: &[f64]) -> f64 {
    let product = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
    product(a, b) / (product(a, a) * product(b, b)).sqrt() * (a.len() as f64).sqrt()
}

/// Total counts less their exact means. Sample means would do for different
/// streams, but the deviations from them are correlated.
fn fluctuations(model: &DetectorModel, seed: u64, scans: u64, steps: u64) -> Vec<f64> {
    let mut counts = vec![StepCount::ZERO; (scans * steps) as usize];
    StepCounter::new(model).count(seed, 0..scans, 0..steps, &mut counts);
    let response = MeanResponse::of_tier(model, CountingTier::Events).unwrap();
    let means = response.mean_counts();
    let of_scan = |scan: &[StepCount]| -> Vec<f64> {
        let pairs = scan.iter().zip(&means);
        pairs.map(|(c, mean)| c.total as f64 - mean.total).collect()
    };
    counts.chunks(steps as usize).flat_map(of_scan).collect()
}

#[test]
fn neighbouring_streams_are_not_correlated() {
    let scene = table_i_scene(gold_5(), 20e6, 1_000);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let (scans, steps) = (200, 248);
    let of_seed = |seed| fluctuations(&model, seed, scans, steps);
    let one = of_seed(1);
    for other in [2, 3, 1 << 32, u64::MAX] {
        let z = correlation_z(&one, &of_seed(other));
        assert!(z.abs() < 4.0, "seeds 1 and {other}: {z:.2} standard errors");
    }
    let n = one.len();
    for lag in [1, 2, 32, steps as usize, 2 * steps as usize] {
        let z = correlation_z(&one[..n - lag], &one[lag..]);
        assert!(z.abs() < 4.0, "{lag} steps apart: {z:.2} standard errors");
    }
}

#[test]
fn detectors_under_the_same_light_are_not_correlated() {
    let mut scene = table_i_scene(gold_5(), 20e6, 1_000);
    let mut twin = scene.detectors[0].clone();
    twin.name = "twin".to_owned();
    scene.detectors.push(twin);
    let mut path = scene.paths[0].clone();
    path.detector = DetectorIndex(1);
    scene.paths.push(path);
    let of_detector = |detector| {
        let model = DetectorModel::new(&Sensor::new(&scene), detector);
        fluctuations(&model, 1, 80, 248)
    };
    let z = correlation_z(&of_detector(DetectorIndex(0)), &of_detector(DetectorIndex(1)));
    assert!(z.abs() < 4.0, "{z:.2} standard errors");
}

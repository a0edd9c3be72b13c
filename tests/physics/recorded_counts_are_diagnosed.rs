//! `goldtof estimate`'s statements about what is wrong with a sensor: how often they are
//! made of a sensor that is as its scene says, and how often of one that is not. Counts
//! are of photons one by one; what they are held against is the exact response.

use std::path::Path;

use goldtof::recorded::{Cause, RecordedScan, assess};
use goldtof::scene::{self, DetectorIndex, Setting};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::scans;
use statrs::distribution::{Beta, ContinuousCDF as _};

/// The scene, with settings.
fn quick(settings: &[&str]) -> Sensor {
    let settings: Vec<Setting> = settings.iter().map(|s| s.parse().unwrap()).collect();
    Sensor::new(&scene::load_with(Path::new("scenes/quick.toml"), &settings).unwrap())
}

/// How many scans stand behind a rate: of the figures in the documents a thousand.
fn scans_or(default: u64) -> u64 {
    let asked = std::env::var("GOLDTOF_SCANS").ok();
    asked.map_or(default, |scans| scans.parse().unwrap())
}

/// The causes that are named for each of some scans of the sensor `built`, by somebody
/// who has the scene `written`.
fn causes(built: &Sensor, written: &Sensor, has_totals: bool, repetitions: u64) -> Vec<Vec<Cause>> {
    let mut found = Vec::new();
    scans(built, DetectorIndex(0), Tier::Sampled, 11, repetitions, |counts| {
        let scan = RecordedScan { detector: DetectorIndex(0), counts: counts.to_vec(), has_totals };
        let diagnosis = assess(written, &scan).diagnosis;
        found.push(diagnosis.expect("there are residuals").causes);
    })
    .unwrap();
    found
}

/// The exact interval of a share at 95 % (Clopper and Pearson).
fn binomial_interval(successes: u64, trials: u64) -> [f64; 2] {
    let quantile = |a: u64, b: u64, p| Beta::new(a as f64, b as f64).unwrap().inverse_cdf(p);
    let failures = trials - successes;
    [
        match successes {
            0 => 0.0,
            _ => quantile(successes, failures + 1, 0.025),
        },
        match failures {
            0 => 1.0,
            _ => quantile(successes + 1, failures, 0.975),
        },
    ]
}

/// Share of scans for which a cause is named, with its exact interval, printed for the
/// documents.
fn share(what: &str, found: &[Vec<Cause>], is_said: impl Fn(&[Cause]) -> bool) -> [f64; 2] {
    let said = found.iter().filter(|causes| is_said(causes)).count() as u64;
    let interval = binomial_interval(said, found.len() as u64);
    println!("{what}: {said} of {}, {interval:.3?}", found.len());
    interval
}

#[test]
fn a_sensor_that_is_as_its_scene_says_is_seldom_accused() {
    for (what, settings, has_totals) in [
        ("with totals", &["path.distance=3.27 m"][..], true),
        ("without totals", &["path.distance=3.27 m"][..], false),
    ] {
        let scene = quick(settings);
        let found = causes(&scene, &scene, has_totals, scans_or(75));
        let accused = share(what, &found, |causes| !causes.is_empty());
        // Five tests at 0.2 %.
        assert!(accused[0] < 0.01, "{what}: {accused:?}");
        assert!(accused[1] < 0.1, "{what}: {accused:?}");
    }
}

/// Seven hits in a step: the tests would accuse one right scene of five.
#[test]
fn of_few_hits_nothing_is_said() {
    let scene = quick(&["scan.integration=400 ns"]);
    scans(&scene, DetectorIndex(0), Tier::Sampled, 11, 3, |counts| {
        let scan =
            RecordedScan { detector: DetectorIndex(0), counts: counts.to_vec(), has_totals: true };
        let diagnosis = assess(&scene, &scan).diagnosis.unwrap();
        assert!(diagnosis.causes.is_empty() && diagnosis.tests.is_empty());
        assert!(diagnosis.sentence.contains("too few hits"));
        assert_eq!(diagnosis.not_tested.len(), 1);
    })
    .unwrap();
}

#[test]
fn what_is_wrong_with_a_sensor_is_named() {
    use Cause::{Code, ConstantLight, DeadTime, LightLevel, Offset};
    let mut wrong = Vec::new();
    // Whether no other cause is named with it: small faults of light level, background
    // and dead time look alike.
    for (what, setting, has_totals, cause, is_alone) in [
        ("3 % more light", "source.mean_power=20.6 pW", true, LightLevel, false),
        ("30 % more light", "source.mean_power=26 pW", true, LightLevel, true),
        ("10 % more light", "source.mean_power=22 pW", false, LightLevel, false),
        ("1 Mcps more background", "detector.background_rate=3 Mcps", true, ConstantLight, false),
        ("dead time 14.5 ns", "detector.dead_time=14.5 ns", true, DeadTime, false),
        ("dead time 20 ns", "detector.dead_time=20 ns", true, DeadTime, true),
        ("0.5 ns of cable", "detector.delay=2.25 ns", true, Offset, true),
        ("0.5 ns of cable", "detector.delay=2.25 ns", false, Offset, true),
        ("another code", "source.code.index=3", true, Code, true),
        ("another code", "source.code.index=3", false, Code, true),
    ] {
        // Only what is said to differ differs: the pulse's width goes with the dead time.
        let fixed = "detector.pulse_width=7 ns";
        let built = quick(&[fixed, setting]);
        let found = causes(&built, &quick(&[fixed]), has_totals, scans_or(12));
        let totals = if has_totals { "with" } else { "without" };
        let what = format!("{what}, {totals} totals");
        let named = share(&what, &found, |causes| causes.contains(&cause));
        let alone = share(&format!("{what}, alone"), &found, |causes| causes == [cause]);
        let first = found.iter().map(|causes| format!("{causes:?}"));
        println!("{:?}", first.collect::<std::collections::BTreeSet<_>>());
        if named[1] <= 0.9 || is_alone && alone[1] <= 0.9 {
            wrong.push(format!("{what}: named {named:?}, alone {alone:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Averages of many scans are no counts: their residuals are too small.
#[test]
fn counts_that_are_no_counts_are_told() {
    let scene = quick(&[]);
    let mut sum = vec![0_i64; scene.scene().scan.steps as usize];
    scans(&scene, DetectorIndex(0), Tier::Sampled, 3, 16, |counts| {
        for (sum, count) in sum.iter_mut().zip(counts) {
            *sum += count.signed;
        }
    })
    .unwrap();
    let scan = RecordedScan {
        detector: DetectorIndex(0),
        counts: sum
            .iter()
            .map(|sum| goldtof::photons::StepCount { signed: sum / 16, total: 0 })
            .collect(),
        has_totals: false,
    };
    let assessment = assess(&scene, &scan);
    let diagnosis = assessment.diagnosis.unwrap();
    assert_eq!(diagnosis.causes, [Cause::TooEven], "{}", diagnosis.sentence);
}

/// The fit's own standard deviation is that of its distances.
#[test]
fn the_fitted_distance_scatters_as_it_says_and_is_unbiased() {
    let scene = quick(&[]);
    let mut pulls = Vec::new();
    scans(&scene, DetectorIndex(0), Tier::Sampled, 5, scans_or(60), |counts| {
        let scan =
            RecordedScan { detector: DetectorIndex(0), counts: counts.to_vec(), has_totals: true };
        let found = assess(&scene, &scan);
        let (distance_m, std_m) =
            (found.fitted_distance_m.unwrap(), found.fitted_distance_std_m.unwrap());
        pulls.push((distance_m - 3.2) / std_m);
    })
    .unwrap();
    let n = pulls.len() as f64;
    let mean = pulls.iter().sum::<f64>() / n;
    let variance = pulls.iter().map(|pull| (pull - mean).powi(2)).sum::<f64>() / (n - 1.0);
    println!("pulls: mean {mean:.3}, variance {variance:.3}");
    assert!(mean.abs() < 4.0 / n.sqrt(), "{mean}");
    assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{variance}");
}

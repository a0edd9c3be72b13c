//! `goldtof estimate`'s statements about a histogram: how often they are made of a sensor
//! that is as its scene says, and how often of one that is not. Bins are of photons one by
//! one; what they are held against is the exact response.

use std::path::Path;

use goldtof::histogram::Histogram;
use goldtof::recorded::{
    Assessment, Cause, RecordedHistogram, assess_histogram, histogram_against_scene,
};
use goldtof::scene::{self, DetectorIndex, Setting};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::histograms;
use statrs::distribution::{Binomial, DiscreteCDF as _};

const FIRST: DetectorIndex = DetectorIndex(0);

/// The scene as a sensor that keeps a histogram of some 3,700 hits, with settings; of four samples a chip, for which the
/// theory takes half as long as for eight.
fn histogram(settings: &[&str]) -> Sensor {
    let always =
        ["hardware.architecture=histogram", "scan.integration=200 us", "clock.samples_per_chip=4"];
    let settings = always.into_iter().chain(settings.iter().copied());
    let settings: Vec<Setting> = settings.map(|s| s.parse().unwrap()).collect();
    Sensor::new(&scene::load_with(Path::new("scenes/quick.toml"), &settings).unwrap())
}

/// How many histograms stand behind a rate: of the figures in the documents more.
fn histograms_or(default: u64) -> u64 {
    let asked = std::env::var("GOLDTOF_SCANS").ok();
    asked.map_or(default, |scans| scans.parse().unwrap())
}

/// What somebody who has the scene `written` is told of histograms of the sensor `built`.
fn assessments(built: &Sensor, written: &Sensor, repetitions: u64) -> Vec<Assessment> {
    let mut found = Vec::new();
    histograms(built, FIRST, Tier::Sampled, 11, repetitions, |histogram| {
        let recorded = RecordedHistogram { detector: FIRST, histogram };
        found.push(assess_histogram(written, &recorded));
    })
    .unwrap();
    found
}

fn causes(assessment: &Assessment) -> &[Cause] {
    &assessment.diagnosis.as_ref().expect("there is one").causes
}

#[test]
fn a_histogram_that_is_as_its_scene_says_is_seldom_accused() {
    let scene = histogram(&[]);
    let found = assessments(&scene, &scene, histograms_or(60));
    let accused = found.iter().filter(|one| !causes(one).is_empty()).count() as u64;
    println!("accused: {accused} of {}", found.len());
    // Seven tests of 0.2 %: so many at most, but once in ten thousand times.
    let chance = Binomial::new(0.01, found.len() as u64).unwrap();
    assert!(chance.sf(accused) > 1e-4, "{accused}");
    // The fitted distance scatters as it says.
    let pulls: Vec<f64> = found
        .iter()
        .map(|one| (one.fitted_distance_m.unwrap() - 3.2) / one.fitted_distance_std_m.unwrap())
        .collect();
    let n = pulls.len() as f64;
    let mean = pulls.iter().sum::<f64>() / n;
    let variance = pulls.iter().map(|pull| (pull - mean).powi(2)).sum::<f64>() / (n - 1.0);
    println!("pulls: mean {mean:.3}, variance {variance:.3}");
    assert!(mean.abs() < 4.0 / n.sqrt(), "{mean}");
    assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{variance}");
}

#[test]
fn what_is_wrong_with_a_sensor_is_named() {
    let written = histogram(&[]);
    for (settings, cause) in [
        (&["source.mean_power=26 pW"][..], Cause::LightLevel),
        (&["detector.dark_count_rate=3 Mcps"], Cause::ConstantLight),
        (&["detector.dead_time=20 ns"], Cause::DeadTime),
        (&["detector.delay=0.5 ns"], Cause::Offset),
        (&["source.code.index=3"], Cause::Code),
        (&["path.transmission=1e-9"], Cause::NoLight),
    ] {
        let built = histogram(settings);
        let found = assessments(&built, &written, histograms_or(5));
        let named = found.iter().filter(|one| causes(one).contains(&cause));
        let alone = found.iter().filter(|one| causes(one) == [cause]).count();
        let (named, of) = (named.count(), found.len());
        println!("{settings:?}: {cause:?} named {named} of {of}, alone {alone}");
        assert!(named * 10 >= of * 8, "{settings:?}: {named} of {of}");
        // Light of another code correlates with this one, too.
        if cause != Cause::Code {
            let distances = found.iter().filter(|one| one.estimate.distance_m.is_some()).count();
            let expected = if cause == Cause::NoLight { 0 } else { of };
            assert_eq!(distances, expected, "{settings:?}");
        }
    }
}

/// Chips that are 1 in 12 of 31 count down what has no modulation: hits of noise have that mean, and not 0.
#[test]
fn an_unbalanced_code_neither_hides_a_peak_nor_makes_one() {
    for index in [0, 2] {
        let code = format!("source.code.index={index}");
        let written = histogram(&[&code]);
        let chips = &written.reference(FIRST).chips;
        assert_ne!(chips.iter().filter(|&&chip| chip == 1).count(), 16, "it is balanced");
        for (light, has_distance) in [("source.mean_power=4 pW", true), (BLOCKED, false)] {
            for one in assessments(&histogram(&[&code, light]), &written, 4) {
                let distance_m = one.estimate.distance_m;
                assert_eq!(distance_m.is_some(), has_distance, "{code}, {light}: {one}");
                assert!(distance_m.is_none_or(|metres| (metres - 3.2).abs() < 0.3), "{one}");
            }
        }
    }
}

const BLOCKED: &str = "path.transmission=1e-9";

/// What a sensor cannot have counted by chance: averages of many histograms.
#[test]
fn averages_are_no_counts() {
    let scene = histogram(&[]);
    let mut sum = vec![0; 124];
    let mut periods = 0;
    histograms(&scene, FIRST, Tier::Sampled, 3, 16, |histogram| {
        periods = histogram.periods();
        for (sum, count) in sum.iter_mut().zip(histogram.bins()) {
            *sum += count;
        }
    })
    .unwrap();
    let average = sum.iter().map(|sum| (sum + 8) / 16).collect();
    let recorded = RecordedHistogram {
        detector: FIRST,
        histogram: Histogram::new(average, 4, periods).unwrap(),
    };
    let found = assess_histogram(&scene, &recorded);
    assert!(causes(&found).contains(&Cause::TooEven), "{found}");
}

/// Residuals of bins beside the scene as it is: of a right one they vary by one, of light elsewhere by
/// much more.
#[test]
fn bins_beside_the_scene_as_it_is_have_residuals_of_one() {
    let scene = histogram(&[]);
    let mean_square = |built: &Sensor, repetitions: u64| {
        let (mut squares, mut number) = (0.0, 0.0);
        histograms(built, FIRST, Tier::Sampled, 13, repetitions, |histogram| {
            let recorded = RecordedHistogram { detector: FIRST, histogram };
            for bin in histogram_against_scene(&scene, &recorded).unwrap() {
                squares += bin.residual_in_std.powi(2);
                number += 1.0;
            }
        })
        .unwrap();
        (squares / number, number)
    };
    let (right, number) = mean_square(&scene, histograms_or(60));
    // A Poisson number's square varies by 2 + 1 / mean.
    assert!((right - 1.0).abs() < 4.0 * (3.0 / number).sqrt(), "{right} of {number}");
    let (elsewhere, _) = mean_square(&histogram(&["path.distance=3.4 m"]), 4);
    assert!(elsewhere > 1.5, "{elsewhere}");
}

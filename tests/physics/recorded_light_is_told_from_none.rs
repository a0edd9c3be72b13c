//! `goldtof estimate`'s statements about light: whether counts have a peak at all, and whether it is that of a path.

use std::path::Path;

use goldtof::estimate::report::Reporter;
use goldtof::estimate::{CountingTier, predict};
use goldtof::photons::StepCount;
use goldtof::recorded::{Cause, assess};
use goldtof::scene::{self, DetectorIndex, EstimatorKind, PathIndex, Setting};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::scans;
use optics_support::repeated;
use optics_support::sequential::Seldom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::recorded_counts_are_diagnosed::{quick, recorded, said, scans_or};

/// Counts of a beam that is blocked have a largest one, too. It is not a distance, by either estimator, and what
/// is wrong is not sought among codes and clocks; the background may be another one where totals tell it.
#[test]
fn a_blocked_beam_gives_no_distance_and_is_named() {
    let blocked = "path.transmission=1e-9";
    let bright = "detector.background_rate=2 Mcps";
    for (what, settings, has_totals, estimator) in [
        ("signed counts", &[blocked][..], false, EstimatorKind::Fft),
        ("with totals", &[blocked], true, EstimatorKind::Fft),
        ("in brighter background", &[blocked, bright], true, EstimatorKind::Model),
        ("signed counts in brighter background", &[blocked, bright], false, EstimatorKind::Fft),
        ("with totals, fitted", &[blocked], true, EstimatorKind::Model),
    ]
    .into_iter()
    .take(repeated(3, 5) as usize)
    {
        let with_totals = ["hardware.total_counts=true"];
        let more = if has_totals { &with_totals[..] } else { &[] };
        let built = quick(&[settings, more].concat());
        let written = quick(more).estimated_by(estimator);
        // A distance of one in fifty; no light explains all but 0.2 %.
        let mut distances = Seldom::new(0.02, 0.2, 0.03);
        let mut unnamed = Seldom::new(0.002, 0.1, 0.2);
        for seed in 5.. {
            scans(&built, DetectorIndex(0), Tier::Sampled, seed, scans_or(18), |counts| {
                let found = assess(&written, &recorded(counts, has_totals));
                let chance = found.estimate.chance_fraction.expect("there are hits");
                assert!(chance < 0.02 || found.estimate.distance_m.is_none(), "{found}");
                distances.take(found.estimate.distance_m.is_some());
                unnamed.take(found.diagnosis.expect("it is known").causes != [Cause::NoLight]);
            })
            .unwrap();
            if !distances.is_open() && !unnamed.is_open() {
                break;
            }
        }
        distances.assert_holds(&format!("{what}: distances"));
        unnamed.assert_holds(&format!("{what}: no light not named"));
    }
}

/// Of counts that are all 0 nothing is fitted: they are darkness, or, where even that counts, a detector that
/// does not.
#[test]
fn counts_that_are_all_zero_are_of_a_detector_that_is_off_or_of_no_light() {
    for has_totals in [false, true] {
        for (settings, cause) in [
            (&[][..], Cause::NoHits),
            (&["scan.integration=400 ns"], Cause::NoHits),
            (&["detector.dark_count_rate=0 cps"], Cause::NoLight),
        ] {
            let written = quick(settings);
            let none = vec![StepCount { signed: 0, total: 0 }; 248];
            let found = assess(&written, &recorded(&none, has_totals));
            assert_eq!(found.diagnosis.expect("it is known").causes, [cause], "{settings:?}");
            assert_eq!((found.estimate.distance_m, found.fitted_distance_m), (None, None));
        }
    }
}

/// A scan of 0.8 to 5.7 m of a target at 9 m has sidelobes alone: they tell where it is, and no distance is read from
/// the largest of them.
#[test]
fn a_target_outside_of_the_scan_is_told_from_its_sidelobes() {
    let window = ["scan.steps={ first = 8, count = 33 }", "hardware.total_counts=true"];
    let written = quick(&window);
    let built = quick(&[&window[..], &["path.distance=9 m"]].concat());
    scans(&built, DetectorIndex(0), Tier::Sampled, 5, 10, |counts| {
        let found = assess(&written, &recorded(counts, true));
        let (distance_m, std_m) = (found.fitted_distance_m, found.fitted_distance_std_m);
        let error_m = distance_m.expect("a fit") - 9.0;
        assert!(error_m.abs() < 5.0 * std_m.expect("a fit") && std_m < Some(0.06), "{found}");
        assert_eq!(found.estimate.distance_m, None, "{found}");
        assert!(found.diagnosis.expect("it is known").causes.contains(&Cause::Offset));
    })
    .unwrap();
}

/// Three tenths of the scene's light within the window are no sidelobes: the distance stays, and the light is named.
#[test]
fn dim_light_in_a_window_is_not_told_to_be_outside() {
    let window = ["scan.steps={ first = 8, count = 33 }", "hardware.total_counts=true"];
    for code in [
        "source.code.index=3",
        "source.code.index=7",
        "source.code={ family = \"m-sequence\", degree = 5 }",
    ] {
        let written = quick(&[&window[..], &[code]].concat());
        let built = quick(&[&window[..], &[code, "source.mean_power=6 pW"]].concat());
        scans(&built, DetectorIndex(0), Tier::Sampled, 5, 4, |counts| {
            let found = assess(&written, &recorded(counts, true));
            let distance_m = found.estimate.distance_m.expect("it is in the window");
            assert!((distance_m - 3.2).abs() < 0.4, "{code}: {found}");
            let causes = &found.diagnosis.as_ref().expect("it is known").causes;
            assert!(causes.contains(&Cause::LightLevel), "{code}: {found}");
        })
        .unwrap();
    }
}

/// Where one hit is expected in a scan, none is not a fault.
#[test]
fn a_scene_of_hardly_any_light_may_count_nothing() {
    let dim = quick(&["detector.dark_count_rate=0 cps", "source.mean_power=1e-7 pW"]);
    let none = vec![StepCount { signed: 0, total: 0 }; 248];
    let found = assess(&dim, &recorded(&none, true));
    assert!(found.diagnosis.expect("it is known").causes.is_empty());
}

/// Beside a source ten times as bright the largest count is of its light, at a step that says nothing of the
/// own distance: with the own path blocked there is none.
#[test]
fn other_light_that_correlates_is_no_distance() {
    let scene = |settings: &[&str]| {
        let settings = settings.iter().chain(&["hardware.total_counts=true"]);
        let settings: Vec<Setting> = settings.map(|text| text.parse().unwrap()).collect();
        let file = Path::new("tests/scenes/near-far.toml");
        Sensor::new(&scene::load_with(file, &settings).unwrap())
    };
    let (built, written) = (scene(&["path[0].transmission=0"]), scene(&[]));
    for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
        let (written, mut distances) = (written.estimated_by(estimator), 0);
        let reporter = Reporter::new(&written, DetectorIndex(0)).without_theory();
        scans(&built, DetectorIndex(0), Tier::Sampled, 5, 10, |counts| {
            let found = reporter.scan(counts);
            distances += u64::from(found.distance_m.is_some());
        })
        .unwrap();
        assert!(distances <= 1, "{estimator:?}: {distances} of 10");
    }
}

/// Settings of a sensor as somebody may build it, at random.
fn at_random(random: &mut Xoshiro256PlusPlus) -> Vec<String> {
    let mut log = |least: f64, most: f64| least * (most / least).powf(random.random::<f64>());
    let mut settings = vec![
        format!("clock.chip_period={} ns", log(1.0, 100.0)),
        // Of each degree more the theory takes four times as long.
        format!("source.code.degree={}", log(5.0, repeated(7, 8) as f64) as u32),
        format!("source.mean_power={} pW", log(0.1, 1e4)),
        format!("source.extinction_ratio={}", log(2.0, 1e3)),
        format!("detector.dead_time={} ns", log(1.0, 100.0)),
        format!("detector.dark_count_rate={} cps", log(1e3, 1e6)),
        format!("detector.background_rate={} cps", log(1e3, 1e7)),
        format!("detector.afterpulsing.probability={}", log(0.003, 0.3)),
        format!("path.distance={} m", log(1e-3, 100.0)),
        format!("scan.integration={} us", log(3.0, 30.0)),
    ];
    let one_of = |of: &[u32], random: &mut Xoshiro256PlusPlus| of[random.random_range(0..of.len())];
    settings.push(format!("clock.samples_per_chip={}", one_of(&[1, 2, 4, 8], random)));
    settings.push(format!("source.code.index={}", random.random_range(-2..31)));
    settings.push(format!("hardware.parallel={}", one_of(&[1, 1, 1, 4, 16], random)));
    settings
}

/// Over sensors at random: a peak that theory hardly ever misses is not taken for chance, and of blocked beams one
/// in fifty has a distance, with total counts or without, in one background or another.
#[test]
fn peaks_of_light_are_no_chance_and_those_of_none_are() {
    let (mut open, mut refused, mut blocked, mut distances) = (0, Vec::new(), 0, Vec::new());
    let mut random = Xoshiro256PlusPlus::seed_from_u64(29);
    let mut of_none = Seldom::new(0.02, 0.2, 0.03);
    for sensor in 0.. {
        assert!(sensor < 1_000, "hardly any of these sensors finds its peak");
        if open >= 4 && !of_none.is_open() && sensor >= repeated(0, 200) {
            break;
        }
        let settings = at_random(&mut random);
        // Whether the peak is found does not depend on what else the hardware sends.
        let settings_of_all: Vec<&str> = settings.iter().map(String::as_str).collect();
        let theory = predict(
            &quick(&settings_of_all),
            DetectorIndex(0),
            PathIndex(0),
            CountingTier::Sampled,
        );
        let missed = theory.ok().and_then(|theory| theory.missed_fraction);
        let is_found = missed.is_some_and(|missed| missed < 1e-4);
        for totals in ["hardware.total_counts=false", "hardware.total_counts=true"] {
            let more = |more: &[&'static str]| {
                let settings = settings.iter().map(String::as_str).chain([totals]);
                quick(&settings.chain(more.iter().copied()).collect::<Vec<_>>())
            };
            let written = more(&[]);
            let reporter = Reporter::new(&written, DetectorIndex(0)).without_theory();
            for (built, has_light) in [
                (more(&[]), true),
                (more(&["path.transmission=0"]), false),
                (more(&["path.transmission=0", "detector.background_rate=20 Mcps"]), false),
            ] {
                if has_light && !is_found {
                    continue;
                }
                // The scatter of a shorter scan does not tell that it is brighter.
                let samples_per_chip: u64 = built.clock().samples_per_chip.into();
                let is_short = built.timing().scan.steps * samples_per_chip < 62;
                let is_brighter =
                    built.scene().detectors[DetectorIndex(0)].background_rate_cps == 20e6;
                if is_short && is_brighter && totals.ends_with("false") {
                    continue;
                }
                scans(&built, DetectorIndex(0), Tier::Sampled, 3, 1, |counts| {
                    let counts = recorded(counts, totals.ends_with("true")).counts;
                    let found = reporter.scan(&counts);
                    let told = (settings.clone(), totals, found.chance_fraction, found.remark);
                    match (has_light, found.distance_m) {
                        (true, None) => refused.push(told),
                        (false, Some(_)) => distances.push(told),
                        _ => {}
                    }
                    if has_light {
                        open += 1;
                    } else {
                        blocked += 1;
                        of_none.take(found.distance_m.is_some());
                    }
                })
                .unwrap();
            }
        }
    }
    println!("refused {} of {open}, a distance of {} of {blocked}", refused.len(), distances.len());
    assert!(refused.is_empty(), "{open}: {refused:#?}");
    assert!(of_none.holds(), "of {blocked}: {distances:#?}");
}

/// Light that is a hundredth of the scene's, whose peak stands out, is not taken for none.
#[test]
fn dim_light_is_not_taken_for_none() {
    let built = quick(&["source.mean_power=2 pW", "hardware.total_counts=true"]);
    let written = quick(&["hardware.total_counts=true"]);
    for (causes, sentence) in said(&built, &written, true, 5, 11) {
        assert!(causes.contains(&Cause::LightLevel), "{sentence}");
    }
    let reporter = Reporter::new(&written, DetectorIndex(0)).without_theory();
    scans(&built, DetectorIndex(0), Tier::Sampled, 5, 20, |counts| {
        let found = reporter.scan(counts);
        assert!(found.chance_fraction.is_some_and(|chance| chance < 0.01), "{found:?}");
        assert!((found.distance_m.expect("a peak") - 3.2).abs() < 1.0, "{found:?}");
    })
    .unwrap();
}

/// Over 4,088 steps one dim peak leaves chi-square as it is without any light. It stands out all the same: it is
/// not called darkness.
#[test]
fn a_dim_peak_among_many_steps_is_not_taken_for_none() {
    let long = ["source.code.degree=9", "hardware.total_counts=true"];
    let built = quick(&[&long[..], &["source.mean_power=2 pW"]].concat());
    let written = quick(&long);
    scans(&built, DetectorIndex(0), Tier::Sampled, 2, repeated(1, 2), |counts| {
        let found = assess(&written, &recorded(counts, true));
        assert!(found.estimate.chance_fraction.is_some_and(|chance| chance < 0.01), "{found}");
        let causes = found.diagnosis.expect("it is known").causes;
        assert!(!causes.contains(&Cause::NoLight), "{causes:?}");
    })
    .unwrap();
}

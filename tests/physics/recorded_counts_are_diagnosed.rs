//! `goldtof estimate`'s statements about what is wrong with a sensor: how often they are
//! made of a sensor that is as its scene says, and how often of one that is not. Counts
//! are of photons one by one; what they are held against is the exact response.

use std::path::Path;
use std::sync::Arc;

use goldtof::code::{Code, CodeSpec, Family, Generator};
use goldtof::photons::StepCount;
use goldtof::recorded::{AsItIs, Cause, RecordedScan, against_scene, assess};
use goldtof::scene::{self, DetectorIndex, Setting, SourceIndex};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::scans;
use optics_support::repeated;
use optics_support::sequential::Seldom;
use statrs::distribution::{Beta, ContinuousCDF as _};

/// The scene, with settings.
pub fn quick(settings: &[&str]) -> Sensor {
    let settings: Vec<Setting> = settings.iter().map(|s| s.parse().unwrap()).collect();
    Sensor::new(&scene::load_with(Path::new("scenes/quick.toml"), &settings).unwrap())
}

/// The same of four samples a chip, whose phase steps count for twice as long: as much light, and of half as many steps
/// the theory takes half as long.
pub fn coarse(settings: &[&str]) -> Sensor {
    let coarse = ["clock.samples_per_chip=4", "scan.integration=40 us"];
    quick(&[&coarse[..], settings].concat())
}

/// How many scans stand behind a rate: of the figures in the documents a thousand.
pub fn scans_or(default: u64) -> u64 {
    let asked = std::env::var("GOLDTOF_SCANS").ok();
    asked.map_or(default, |scans| scans.parse().unwrap())
}

/// The causes that are named for each of some scans of the sensor `built`, by somebody
/// who has the scene `written`: block after block, until these suffice.
fn causes_until(
    built: &Sensor,
    written: &Sensor,
    has_totals: bool,
    block: u64,
    mut suffice: impl FnMut(&[Cause]) -> bool,
) -> Vec<Vec<Cause>> {
    let mut found = Vec::new();
    for seed in 11.. {
        let said = said(built, written, has_totals, block, seed);
        let decided = said.iter().fold(false, |_, (causes, _)| suffice(causes));
        found.extend(said.into_iter().map(|(causes, _)| causes));
        if decided {
            break;
        }
    }
    found
}

/// Counts as a file has them: without total counts these are 0.
pub fn recorded(counts: &[StepCount], has_totals: bool) -> RecordedScan {
    let sent =
        |count: &StepCount| StepCount { total: if has_totals { count.total } else { 0 }, ..*count };
    let counts = counts.iter().map(sent).collect();
    RecordedScan { detector: DetectorIndex(0), counts, has_totals }
}

/// The same, each with the sentence.
pub fn said(
    built: &Sensor,
    written: &Sensor,
    has_totals: bool,
    repetitions: u64,
    seed: u64,
) -> Vec<(Vec<Cause>, String)> {
    let mut found = Vec::new();
    scans(built, DetectorIndex(0), Tier::Sampled, seed, repetitions, |counts| {
        let scan = recorded(counts, has_totals);
        let diagnosis = assess(written, &scan).diagnosis;
        let diagnosis = diagnosis.expect("there are residuals");
        found.push((diagnosis.causes, diagnosis.sentence));
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
        // The other recharge is tried, too.
        (
            "without afterpulses",
            &["path.distance=3.27 m", "detector.afterpulsing.probability=0"][..],
            true,
        ),
    ] {
        let scene = coarse(settings);
        // The tests together have a level of 1.4 %.
        let mut accused = Seldom::new(0.005, 0.1, 0.02);
        let found = causes_until(&scene, &scene, has_totals, scans_or(13), |causes| {
            accused.take(!causes.is_empty());
            !accused.is_open()
        });
        share(what, &found, |causes| !causes.is_empty());
        accused.assert_holds(what);
    }
}

/// Seven hits in a step: the tests would accuse one right scene of five.
#[test]
fn of_few_hits_nothing_is_said() {
    let scene = quick(&["scan.integration=400 ns"]);
    scans(&scene, DetectorIndex(0), Tier::Sampled, 11, 3, |counts| {
        let diagnosis = assess(&scene, &recorded(counts, true)).diagnosis.unwrap();
        assert!(diagnosis.causes.is_empty() && diagnosis.tests.is_empty());
        assert!(diagnosis.sentence.contains("too few hits"));
        assert_eq!(diagnosis.not_tested.len(), 1);
    })
    .unwrap();
}

#[test]
fn what_is_wrong_with_a_sensor_is_named() {
    use Cause::{ChipPeriod, Code, ConstantLight, DeadTime, Integration, LightLevel, Offset};
    let mut wrong = Vec::new();
    // Whether no other cause is named with it: small faults of light level, background
    // and dead time look alike.
    for (what, setting, has_totals, cause, is_alone) in [
        ("3 % more light", "source.mean_power=20.6 pW", true, LightLevel, false),
        ("30 % more light", "source.mean_power=26 pW", true, LightLevel, false),
        ("twice the light", "source.mean_power=40 pW", true, LightLevel, true),
        ("10 % more light", "source.mean_power=22 pW", false, LightLevel, false),
        ("1 Mcps more background", "detector.background_rate=3 Mcps", true, ConstantLight, false),
        ("dead time 14.5 ns", "detector.dead_time=14.5 ns", true, DeadTime, false),
        ("dead time 20 ns", "detector.dead_time=20 ns", true, DeadTime, true),
        ("0.5 ns of cable", "detector.delay=2.25 ns", true, Offset, true),
        ("0.5 ns of cable", "detector.delay=2.25 ns", false, Offset, true),
        // The hardware counts chips, whatever its clock.
        (
            "chip period 9 ns",
            "clock.chip_period=9 ns; scan.integration=45 us",
            true,
            ChipPeriod,
            true,
        ),
        (
            "chip period 6 ns",
            "clock.chip_period=6 ns; scan.integration=30 us",
            true,
            ChipPeriod,
            true,
        ),
        ("half the integration time", "scan.integration=20 us", true, Integration, true),
        ("twice the integration time", "scan.integration=80 us", true, Integration, true),
        ("twice the integration time", "scan.integration=80 us", false, Integration, false),
        // More detections than dead times: no light explains them.
        ("four times the integration time", "scan.integration=160 us", true, Integration, true),
        ("another code", "source.code.index=3", true, Code, true),
        ("another code", "source.code.index=3", false, Code, true),
    ]
    .into_iter()
    .step_by(repeated(2, 1) as usize)
    {
        // Only what is said to differ differs: the pulse's width goes with the dead time.
        let fixed = "detector.pulse_width=7 ns";
        let settings: Vec<&str> = std::iter::once(fixed).chain(setting.split("; ")).collect();
        let built = coarse(&settings);
        let totals = if has_totals { "with" } else { "without" };
        let what = format!("{what}, {totals} totals");
        let mut unnamed = Seldom::new(0.05, 0.5, 0.1);
        let mut not_alone = Seldom::new(0.05, 0.5, 0.1);
        let found = causes_until(&built, &coarse(&[fixed]), has_totals, scans_or(4), |causes| {
            unnamed.take(!causes.contains(&cause));
            not_alone.take(causes != [cause]);
            !(unnamed.is_open() || is_alone && not_alone.is_open())
        });
        let named = share(&what, &found, |causes| causes.contains(&cause));
        let alone = share(&format!("{what}, alone"), &found, |causes| causes == [cause]);
        let first = found.iter().map(|causes| format!("{causes:?}"));
        println!("{:?}", first.collect::<std::collections::BTreeSet<_>>());
        if !unnamed.holds() || is_alone && !not_alone.holds() {
            wrong.push(format!("{what}: named {named:?}, alone {alone:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Afterpulsing is the least known of a detector's values. A scene that has another one is not accused of its clock, which
/// would move the distance with it: the best fit stays where the target is.
#[test]
fn another_afterpulsing_is_named_and_leaves_the_distance() {
    let mut wrong = Vec::new();
    for (built, written, power, has_totals) in [
        (0.1, 0.137, "20 pW", true),
        (0.0, 0.137, "20 pW", true),
        (0.0, 0.137, "5 pW", true),
        (0.137, 0.0, "20 pW", true),
        (0.05, 0.0, "20 pW", true),
        (0.0, 0.137, "20 pW", false),
        (0.0, 0.137, "5 pW", false),
    ] {
        let sensor = |probability: f64| {
            let probability = format!("detector.afterpulsing.probability={probability}");
            let power = format!("source.mean_power={power}");
            coarse(&["path.distance=3.27 m", "scan.integration=200 us", &power, &probability])
        };
        let (mut found, mut pulls) = (Vec::new(), Vec::new());
        let written_sensor = sensor(written);
        let seen = |counts: &[StepCount]| {
            let told = assess(&written_sensor, &recorded(counts, has_totals));
            let (distance_m, std_m) = (told.fitted_distance_m, told.fitted_distance_std_m);
            pulls.push((distance_m.expect("a fit") - 3.27) / std_m.expect("a fit"));
            println!("{}", told.diagnosis.as_ref().expect("residuals").sentence);
            found.push(told.diagnosis.expect("there are residuals").causes);
        };
        scans(&sensor(built), DetectorIndex(0), Tier::Sampled, 11, scans_or(repeated(4, 12)), seen)
            .unwrap();
        let totals = if has_totals { "with" } else { "without" };
        let what = format!("afterpulsing {built} for {written}, {power}, {totals} totals");
        let of =
            |cause: Cause| share(&format!("{what}, {cause:?}"), &found, |c| c.contains(&cause));
        let [named, clock, offset] =
            [Cause::Afterpulsing, Cause::ChipPeriod, Cause::Offset].map(of);
        share(&format!("{what}, alone"), &found, |causes| causes == [Cause::Afterpulsing]);
        let n = pulls.len() as f64;
        let mean = pulls.iter().sum::<f64>() / n;
        let within = pulls.iter().filter(|pull| pull.abs() < 1.96).count();
        println!("{what}: pulls of {mean:.2} on average, {within} of {n} within 95 %; {pulls:.2?}");
        let is_named = found.iter().all(|causes| causes.contains(&Cause::Afterpulsing));
        let has_clock = found.iter().any(|causes| causes.contains(&Cause::ChipPeriod));
        if !is_named || has_clock || offset[1] > 0.9 || mean.abs() > 4.0 / n.sqrt() {
            wrong.push(format!("{what}: named {named:?}, clock {clock:?}, {offset:?}, {mean:.2}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Counts of a detector with the other recharge, without afterpulses: among the causes is the recharge, in bright light
/// alone; of a scene with afterpulsing, of which passive recharge has no expectation, it is not tested, by name.
#[test]
fn another_recharge_is_named() {
    let mut wrong = Vec::new();
    for (built, written, power, is_alone) in [
        ("passive", "active", "20 pW", false),
        ("active", "passive", "20 pW", false),
        ("passive", "active", "60 pW", true),
    ] {
        let sensor = |recharge: &str| {
            let recharge = format!("detector.recharge={recharge}");
            let power = format!("source.mean_power={power}");
            let without = "detector.afterpulsing.probability=0";
            coarse(&["path.distance=3.27 m", "scan.integration=200 us", &power, without, &recharge])
        };
        let found = said(&sensor(built), &sensor(written), true, scans_or(repeated(4, 12)), 11);
        found.iter().for_each(|(_, sentence)| println!("{sentence}"));
        let found: Vec<_> = found.into_iter().map(|(causes, _)| causes).collect();
        let what = format!("recharge {built} for {written}, {power}");
        share(&what, &found, |causes| causes.contains(&Cause::Recharge));
        share(&format!("{what}, alone"), &found, |causes| causes == [Cause::Recharge]);
        let is_said = |causes: &Vec<Cause>| match is_alone {
            true => *causes == [Cause::Recharge],
            false => causes.contains(&Cause::Recharge),
        };
        if !found.iter().all(is_said) {
            wrong.push(format!("{what}: {found:?}"));
        }
    }
    let [built, written] =
        ["detector.dead_time=20 ns", "detector.dead_time=14 ns"].map(|s| coarse(&[s]));
    scans(&built, DetectorIndex(0), Tier::Sampled, 11, 1, |counts| {
        let diagnosis = assess(&written, &recorded(counts, true)).diagnosis.expect("residuals");
        assert!(!diagnosis.causes.contains(&Cause::Recharge), "{}", diagnosis.sentence);
        let not_tested = diagnosis.not_tested.iter().find(|reason| reason.starts_with("recharge"));
        assert!(not_tested.is_some(), "{:?}", diagnosis.not_tested);
    })
    .unwrap();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Of the whole Gold set, the two m-sequences of which it is made among them, in the light, the
/// reference or both. Light and reference with either m-sequence see the same.
#[test]
fn another_code_is_named_wherever_it_is() {
    let gold = |index: i64| {
        let mut spec = CodeSpec::new(Family::Gold);
        (spec.degree, spec.index) = (Some(5), Some(index));
        Arc::new(spec.build().unwrap())
    };
    let written = coarse(&["source.code.index=3"]);
    let places = ["the light alone", "the reference alone", "light and reference"];
    // Ones that a mere correlation of codes misses at this light, and the default: the first in every place.
    for (index, places) in [
        (0, &places[..]),
        (15, &places[..repeated(1, 3) as usize]),
        (-1, &places[repeated(2, 0) as usize..]),
    ] {
        for &place in places {
            let built = written.with(|scene| {
                let mut light = scene.sources[0].clone();
                let light_has_it = place != "the reference alone";
                light.code = if light_has_it { gold(index) } else { gold(3) };
                scene.sources[0].code =
                    if place == "the light alone" { gold(3) } else { gold(index) };
                scene.sources.push(light);
                scene.paths[0].source = SourceIndex(1);
            });
            let name = match index {
                0.. => format!("the code whose index is {} higher", (index - 3).rem_euclid(31)),
                _ => format!("the code of index {index}"),
            };
            for (causes, sentence) in said(&built, &written, true, 1, 11) {
                assert_eq!(causes, [Cause::Code], "{index} {place}: {sentence}");
                assert!(sentence.contains(&name), "{index} {place}: {sentence}");
                assert!(sentence.contains(place), "{index} {place}: {sentence}");
            }
        }
    }
}

#[test]
fn what_is_the_other_way_round_is_told_as_such() {
    let written = coarse(&[]);
    let opposite = written.with(|scene| {
        let chips = scene.sources[0].code.chips.iter().map(|chip| 1 - chip).collect();
        let mut light = scene.sources[0].clone();
        light.code = Arc::new(Code::new(Generator::Chips(chips), 0).unwrap());
        scene.sources.push(light);
        scene.paths[0].source = SourceIndex(1);
    });
    for (causes, sentence) in said(&opposite, &written, true, repeated(2, 4), 11) {
        assert_eq!(causes, [Cause::Polarity], "{sentence}");
        assert!(sentence.contains("the light is inverted"), "{sentence}");
    }
    scans(&written, DetectorIndex(0), Tier::Sampled, 11, repeated(2, 4), |counts| {
        let mut counts = counts.to_vec();
        counts.iter_mut().for_each(|count| count.signed = -count.signed);
        for has_totals in [true, false] {
            let counts = counts.clone();
            let scan = RecordedScan { detector: DetectorIndex(0), counts, has_totals };
            let diagnosis = assess(&written, &scan).diagnosis.unwrap();
            assert_eq!(diagnosis.causes, [Cause::Polarity], "{}", diagnosis.sentence);
            assert!(diagnosis.sentence.contains("opposite sign"), "{}", diagnosis.sentence);
        }
    })
    .unwrap();
}

/// Another source's light is ten times as bright: the phase takes its side lobe for the peak.
#[test]
fn a_right_scene_with_brighter_light_of_others_is_not_accused() {
    let scene = Sensor::new(&scene::load(Path::new("tests/scenes/near-far.toml")).unwrap());
    let found = causes_until(&scene, &scene, true, scans_or(6), |_| true);
    let accused = share("near and far", &found, |causes| !causes.is_empty());
    assert!(accused[0] < 0.01, "{accused:?}");
}

/// Averages of many scans are no counts: their residuals are too small.
#[test]
fn counts_that_are_no_counts_are_told() {
    let scene = coarse(&[]);
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
    let scene = coarse(&[]);
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

/// Chi-squares of scans of one sensor beside another as it is, with nothing fitted, and their
/// degrees of freedom.
fn chi_squares(built: &Sensor, written: &Sensor, repetitions: u64) -> (Vec<f64>, f64) {
    let mut found = Vec::new();
    let mut numbers = 0;
    let as_it_is = AsItIs::new(written, DetectorIndex(0));
    scans(built, DetectorIndex(0), Tier::Sampled, 7, repetitions, |counts| {
        let scan =
            RecordedScan { detector: DetectorIndex(0), counts: counts.to_vec(), has_totals: false };
        let steps = against_scene(written, &scan, &as_it_is).unwrap();
        numbers = steps.len();
        found.push(steps.iter().map(|step| step.residual_in_std.powi(2)).sum());
    })
    .unwrap();
    (found, numbers as f64)
}

/// The chi-square of a right scene has as many degrees of freedom as there are phase steps, since nothing
/// is fitted; that of light elsewhere is far beyond.
#[test]
fn counts_beside_the_scene_as_it_is_have_residuals_of_one() {
    // Also steps that share their light: each by itself has that residual.
    for settings in [&[][..], &["hardware.parallel=4"]] {
        let scene = coarse(settings);
        let repetitions = scans_or(40);
        let (found, numbers) = chi_squares(&scene, &scene, repetitions);
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        // Groups of four vary as a quarter of the numbers would, at most.
        let groups = numbers / f64::from(scene.scene().hardware.parallel);
        let std = numbers * (2.0 / groups / found.len() as f64).sqrt();
        println!("chi-square {mean:.1} for {numbers}, {std:.1}");
        assert!((mean - numbers).abs() < 4.0 * std, "{mean} for {numbers}, {std}");
    }
    let scene = coarse(&[]);
    let (elsewhere, numbers) = chi_squares(&coarse(&["path.distance=3.4 m"]), &scene, 4);
    assert!(elsewhere.iter().all(|one| *one > 1.5 * numbers), "{elsewhere:?}");
}

#[test]
fn where_nothing_is_expected_it_is_said_why() {
    let scan = |sensor: &Sensor, steps: usize| {
        let counts = vec![goldtof::photons::StepCount { signed: 0, total: 0 }; steps];
        against_scene(
            sensor,
            &RecordedScan { detector: DetectorIndex(0), counts, has_totals: true },
            &AsItIs::new(sensor, DetectorIndex(0)),
        )
    };
    for (settings, steps, told) in [
        (&["path.velocity=30 m/s"][..], 248, "moves"),
        (&["hardware.architecture=histogram"], 248, "same photons"),
        (&["detector.recharge=passive"], 248, "recharge is passive"),
        (&[], 247, "not whole"),
    ] {
        let refused = scan(&quick(settings), steps).expect_err(told);
        assert!(refused.contains(told), "{refused}");
    }
}

//! The model estimator against simulated photons and a bound worked out by hand.

use std::sync::Arc;

use goldtof::code::{Code, CodeSpec, Family};
use goldtof::estimate::bound::bound;
use goldtof::estimate::fit::{FitError, Fitter, ModelEstimate, OtherLight, fit};
use goldtof::estimate::{
    CountingTier, NoEstimate, calibration_offset_ps, delay_error_ps, distance_m, estimate,
};
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, Path, PathIndex, Scene, Source, SourceIndex};
use goldtof::sensor::Sensor;
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, gold_11, ideal_scene, m_sequence,
    repeated, table_i_scene,
};

const TIER: CountingTier = CountingTier::Events;

fn scan_around(scene: &mut Scene, halfwidth: u64) {
    let peak_ps = scene.paths[0].delay_ps
        + calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), TIER);
    let all = scene.scan.steps_per_period;
    scene.scan.first_step = ((peak_ps / 1000.0).round() as u64 + all - halfwidth) % all;
    scene.scan.steps = 2 * halfwidth;
}

fn photons(scene: &Scene, repetition: u64) -> Vec<StepCount> {
    photons_of(&DetectorModel::new(&Sensor::new(scene), DetectorIndex(0)), repetition)
}

fn photons_of(model: &DetectorModel, repetition: u64) -> Vec<StepCount> {
    let steps = model.timing().scan.steps;
    (0..steps).map(|step| count_step(model, 97, repetition, Step(step))).collect()
}

fn error_m(scene: &Scene, delay_ps: f64) -> f64 {
    let period_ps = scene.scan.steps_per_period as f64 * 1000.0;
    distance_m(delay_error_ps(delay_ps, scene.paths[0].delay_ps, period_ps))
}

fn phase_error_m(scene: &Scene, counts: &[StepCount]) -> f64 {
    let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
    let offset_ps = calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), TIER);
    let found = estimate(&scene.timing(), &signed, offset_ps).expect("a peak");
    error_m(scene, found.delay_ps)
}

fn fitted(scene: &Scene, counts: &[StepCount], other: OtherLight) -> ModelEstimate {
    fit(&Sensor::new(scene), DetectorIndex(0), TIER, counts, other).expect("it fits")
}

#[test]
fn the_dead_time_walk_of_strong_light_is_gone() {
    let mut scene = table_i_scene(gold_11(), 60e6, 13_100 * 10);
    scan_around(&mut scene, 14);
    let (mut pulls, mut phase, mut alarms) = (0.0, 0.0, 0.0);
    let scans = 4;
    for repetition in 0..scans {
        let counts = photons(&scene, repetition);
        let found = fitted(&scene, &counts, OtherLight::None);
        pulls += error_m(&scene, found.delay_ps) / found.std_m;
        phase += phase_error_m(&scene, &counts) / found.std_m;
        alarms += found.alarm_sigmas();
    }
    let number = scans as f64;
    assert_within_standard_errors(pulls / number.sqrt(), 4.0, "model");
    assert!((phase / number.sqrt()).abs() > 20.0, "the phase walks: {phase}");
    assert_within_standard_errors(alarms / number.sqrt(), 4.0, "chi-square");
}

#[test]
fn errors_are_unbiased_scatter_as_the_bound_says_and_match_their_own_deviation() {
    for (rate, part_ps) in [(10e6, 348.0), (40e6, 723.0)] {
        let mut scene = table_i_scene(gold_5(), rate, 31 * 60 + 7);
        scene.paths[0].delay_ps = 60_000.0 + part_ps;
        scan_around(&mut scene, 14);
        let mut alarms = Vec::new();
        let mut stated = Vec::new();
        let sensor = Sensor::new(&scene);
        let model = DetectorModel::new(&sensor, DetectorIndex(0));
        let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, OtherLight::None);
        let errors = Moments::of((0..repeated(150, 300)).map(|repetition| {
            let found = fitter.fit(&photons_of(&model, repetition)).expect("it fits");
            alarms.push(found.alarm_sigmas());
            stated.push(found.std_m);
            error_m(&scene, found.delay_ps)
        }));
        let bound = bound(&Sensor::new(&scene), DetectorIndex(0), TIER).expect("a bound");
        let bound_m = bound.of_path(PathIndex(0)).expect("the path is lit");
        assert_within_standard_errors(errors.z(0.0), 4.0, "bias");
        let z = errors.variance_z(bound_m.powi(2));
        assert_within_standard_errors(z, 4.0, "variance beside the bound");
        let stated = Moments::of(stated).mean;
        assert!((stated / bound_m - 1.0).abs() < 0.05, "{stated} {bound_m}");
        // Chi-square has unit spread, and no drift worth an alarm.
        assert!(Moments::of(alarms).mean.abs() < 0.3);
    }
}

/// Codes 0 and 5 of the default Gold set of degree 7, with equal power.
fn two_sources(relative_chips: f64) -> Scene {
    let code = |index: i64| -> Arc<Code> {
        let mut spec = CodeSpec::new(Family::Gold);
        spec.degree = Some(7);
        spec.index = Some(index);
        Arc::new(spec.build().expect("a code of the set"))
    };
    let mut scene = table_i_scene(code(0), 10e6, 127 * 40 + 11);
    scene.sources.push(Source {
        name: "other".to_owned(),
        code: code(5),
        ..scene.sources[0].clone()
    });
    scene.paths.push(Path {
        source: SourceIndex(1),
        delay_ps: scene.paths[0].delay_ps + relative_chips * 8000.0,
        ..scene.paths[0].clone()
    });
    scene
}

#[test]
fn an_equal_interferer_does_no_harm_whether_its_code_is_given_or_found() {
    let mut pulls = Vec::new();
    for (repetition, relative) in [0.3, 1.0, 17.6, 101.2].into_iter().enumerate() {
        let scene = two_sources(relative);
        let counts = photons(&scene, repetition as u64);
        let given = fitted(&scene, &counts, OtherLight::Given);
        let found = fitted(&scene, &counts, OtherLight::Search);
        for fit in [&given, &found] {
            let other = &fit.paths[1];
            assert_eq!(other.code.chips, scene.sources[1].code.chips, "{relative}");
            let error = delay_error_ps(other.delay_ps, scene.paths[1].delay_ps, 127.0 * 8000.0);
            assert!(error.abs() < 5.0 * other.delay_std_ps, "{relative}: {error}");
            let ratio = other.rate_hz / fit.paths[0].rate_hz;
            let std = other.rate_relative_std + fit.paths[0].rate_relative_std;
            assert!((ratio.ln()).abs() < 5.0 * std, "{relative}: {ratio}");
            assert!(fit.alarm_sigmas().abs() < 5.0, "{}", fit.alarm_sigmas());
        }
        assert!((given.delay_ps - found.delay_ps).abs() < 0.1 * given.paths[0].delay_std_ps);
        pulls.push(error_m(&scene, given.delay_ps) / given.std_m);
    }
    let chi_square: f64 = pulls.iter().map(|pull| pull * pull).sum();
    // Beyond the 1 in 10,000 point of chi-square with four degrees of freedom.
    assert!(chi_square < 23.5, "{pulls:?}");
}

#[test]
fn an_interferer_left_out_of_the_model_raises_the_alarm() {
    let mut scene = two_sources(17.6);
    scene.scan.integration_chips = 127 * 4_000;
    scan_around(&mut scene, 14);
    let blind = fitted(&scene, &photons(&scene, 0), OtherLight::None);
    assert!(blind.alarm_sigmas() > 5.0, "{}", blind.alarm_sigmas());
}

#[test]
fn weak_light_is_fitted_with_the_constant_light_at_its_limit() {
    // Nothing constant at all: half of the fits would want less than that.
    let mut scene = ideal_scene(gold_11(), 1e6, 13_100);
    scene.paths[0].delay_ps = 20_000.0;
    scan_around(&mut scene, 14);
    let constant: Vec<f64> = (0..20)
        .map(|repetition| {
            let found = fitted(&scene, &photons(&scene, repetition), OtherLight::None);
            let error = error_m(&scene, found.delay_ps);
            assert!(error.abs() < 5.0 * found.std_m, "{error}");
            found.constant_rate_hz
        })
        .collect();
    assert!(constant.iter().all(|&rate| rate >= 0.0));
    assert!(constant.contains(&0.0), "{constant:?}");
}

#[test]
fn light_that_is_not_there_is_not_found() {
    let scene = table_i_scene(two_sources(0.0).sources[0].code.clone(), 10e6, 127 * 20);
    let counts = photons(&scene, 0);
    let found = fitted(&scene, &counts, OtherLight::Search);
    assert_eq!(found.paths.len(), 1);
}

#[test]
fn two_paths_of_one_source_are_told_apart() {
    let mut scene = two_sources(3.4);
    scene.paths[1].source = SourceIndex(0);
    scene.paths[1].transmission = 0.6;
    scene.sources.truncate(1);
    let found = fitted(&scene, &photons(&scene, 0), OtherLight::Given);
    for (path, truth) in found.paths.iter().zip(&scene.paths) {
        let error = delay_error_ps(path.delay_ps, truth.delay_ps, 127.0 * 8000.0);
        assert!(error.abs() < 4.0 * path.delay_std_ps, "{error}");
    }
    let ratio = found.paths[1].rate_hz / found.paths[0].rate_hz;
    assert!((ratio - 0.6).abs() < 0.1, "{ratio}");
}

#[test]
fn extinction_ratio_and_ambient_light_need_not_be_known_but_the_dead_time_must() {
    let mut scene = table_i_scene(gold_11(), 40e6, 13_100 * 4);
    scene.detectors[0].background_rate_cps = 20e6;
    scan_around(&mut scene, 14);
    let counts = photons(&scene, 0);
    let known = fitted(&scene, &counts, OtherLight::None);
    let mut assumed = scene.clone();
    assumed.sources[0].extinction_ratio = 4.0;
    assumed.detectors[0].background_rate_cps = 0.0;
    let blind = fitted(&assumed, &counts, OtherLight::None);
    assert!((known.delay_ps - blind.delay_ps).abs() < 1e-3 * known.paths[0].delay_std_ps);

    assumed.detectors[0].dead_time_ps = 20e3;
    let wrong = fitted(&assumed, &counts, OtherLight::None);
    assert!(wrong.alarm_sigmas() > 5.0, "{}", wrong.alarm_sigmas());
}

/// Without dead time and jitter, counts upwards and downwards are independent
#[test]
fn the_bound_of_poisson_counts_is_that_of_the_textbook() {
    // The derivative by the background is that of less background, too, where there is as much.
    for background_cps in [5e6, 1e5] {
        let mut scene = ideal_scene(gold_5(), 20e6, 31 * 50);
        scene.detectors[0].background_rate_cps = background_cps;
        scene.paths[0].delay_ps = 64_300.0;
        assert_textbook_bound(&scene);
        scan_around(&mut scene, 14);
        assert_textbook_bound(&scene);
    }
}

/// Poisson numbers whose means are the code's correlation, interpolated.
fn assert_textbook_bound(scene: &Scene) {
    let chips = scene.sources[0].code.chips.clone();
    let ones = chips.iter().map(|&c| f64::from(c)).sum::<f64>();
    let on_rate = 20e6 * 31.0 / ones * 8e-9;
    // Chips of overlap of the light with reference level `level`.
    let overlap = |delay_chips: f64, level: u8| -> f64 {
        let whole = delay_chips.floor();
        let part = delay_chips - whole;
        let count = |shift: i64| {
            (0..31_i64)
                .filter(|&i| chips[i as usize] == 1)
                .filter(|&i| chips[(i + shift).rem_euclid(31) as usize] == level)
                .count() as f64
        };
        (1.0 - part) * count(whole as i64) + part * count(whole as i64 + 1)
    };
    let constant = scene.detectors[0].background_rate_cps * 8e-9;
    let counts = |k: f64, delay: f64, rate: f64, constant: f64| -> [f64; 2] {
        let share = [ones, 31.0 - ones];
        [1, 0].map(|level| {
            let lit = overlap(delay - k / 8.0, level);
            50.0 * (rate * lit + constant * share[1 - usize::from(level)])
        })
    };
    let delay = 64.3 / 8.0;
    let mut information = [[0.0; 3]; 3];
    for step in 0..scene.scan.steps {
        let k = scene.scan.phase_step(Step(step)) as f64;
        let at = counts(k, delay, on_rate, constant);
        let h = 1e-6;
        let derivative = |shifted: [f64; 2]| [0, 1].map(|side| (shifted[side] - at[side]) / h);
        let slopes = [
            derivative(counts(k, delay + h, on_rate, constant)),
            derivative(counts(k, delay, on_rate + h, constant)),
            derivative(counts(k, delay, on_rate, constant + h)),
        ];
        for (i, row) in information.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                for side in 0..2 {
                    *entry += slopes[i][side] * slopes[j][side] / at[side];
                }
            }
        }
    }
    let [a, b, c] = information;
    let minor = b[1] * c[2] - b[2] * c[1];
    let determinant =
        a[0] * minor - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    let expected_m = distance_m((minor / determinant).sqrt() * 8000.0);
    let found = bound(&Sensor::new(scene), DetectorIndex(0), TIER).expect("a bound");
    assert_eq!(found.steps as u64, scene.scan.steps);
    let bound_m = found.paths[0].slope_m;
    assert!((bound_m / expected_m - 1.0).abs() < 1e-3, "{bound_m} {expected_m}");
}

/// Where all counts scatter alike, what they tell of the delay is the sum of the squared slopes
/// of the code's autocorrelation: a Gold code's side lobes have as much of it as its peak, an
/// m-sequence's none.
#[test]
fn side_lobes_tell_as_much_as_the_code_says() {
    for (code, by_hand) in [(gold_11(), 2.0), (code(&m_sequence(11, &[11, 2])), 1.0)] {
        let signs: Vec<i64> = code.chips.iter().map(|&c| 2 * i64::from(c) - 1).collect();
        let theta = |lag: usize| -> i64 {
            (0..signs.len()).map(|i| signs[i] * signs[(i + lag) % signs.len()]).sum()
        };
        let thetas: Vec<i64> = (0..=signs.len()).map(|lag| theta(lag % signs.len())).collect();
        let squares = thetas.windows(2).map(|ends| ((ends[1] - ends[0]) as f64).powi(2));
        let squares: Vec<f64> = squares.collect();
        let peak = squares[0] + squares[squares.len() - 1];
        let ratio = squares.iter().sum::<f64>() / peak;
        assert!((ratio - by_hand).abs() < 0.1, "{ratio}");
        let mut scene = ideal_scene(code, 1e5, 2047 * 50);
        scene.detectors[0].background_rate_cps = 2e7;
        scene.paths[0].delay_ps = 64_300.0;
        let bound_m = |scene: &Scene| {
            let found = bound(&Sensor::new(scene), DetectorIndex(0), TIER).expect("a bound");
            found.paths[0].slope_m
        };
        let all_m = bound_m(&scene);
        // Strength and background are not known, which a window of 100 steps hardly feels.
        scan_around(&mut scene, 50);
        let gain = (bound_m(&scene) / all_m).powi(2);
        assert!((gain / ratio - 1.0).abs() < 0.02, "{gain} {ratio}");
    }
}

#[test]
fn what_cannot_be_fitted_says_why() {
    let mut scene = two_sources(5.0);
    let none = StepCount { signed: 0, total: 0 };
    let refused = |scene: &Scene, counts: &[StepCount], other| {
        fit(&Sensor::new(scene), DetectorIndex(0), TIER, counts, other).expect_err("no fit")
    };
    let empty = vec![none; 1016];
    assert_eq!(
        refused(&scene, &empty, OtherLight::None),
        FitError::NoPeak(NoEstimate::Flat { count: 0 })
    );
    assert_eq!(
        refused(&scene, &empty[1..], OtherLight::None),
        FitError::WrongNumberOfCounts { found: 1015, steps: 1016 }
    );
    scan_around(&mut scene, 14);
    let counts = photons(&scene, 0);
    assert_eq!(
        refused(&scene, &counts, OtherLight::Given),
        FitError::NeedsWholeScan { steps: 28, steps_per_period: 1016 }
    );
    let mut scene = table_i_scene(gold_5(), 10e6, 31);
    scene.scan.integration_chips = 3_100;
    let counts = photons(&scene, 0);
    assert_eq!(refused(&scene, &counts, OtherLight::Search), FitError::NoGoldSet);
}

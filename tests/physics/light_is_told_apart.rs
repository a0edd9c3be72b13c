//! Several paths and sensors in one scan: what the joint fit finds, how far off it is
//! beside the Cramer-Rao bound, and what it says where the light does not tell.
//!
//! Counts are drawn from their exact moments, with fixed seeds; codes of degree 7, or of degree 5, where it is for paths of
//! one source that are near one another: a quarter of the phase steps, each for four times as long.

use std::sync::Arc;

use goldtof::code::{Code, CodeSpec, Family};
use goldtof::estimate::bound::bound;
use goldtof::estimate::fit::{FitError, Fitter, ModelEstimate, OtherLight, shared_light};
use goldtof::estimate::{CountingTier, delay_error_ps, distance_m};
use goldtof::photons::DetectorModel;
use goldtof::response::{CountSampler, MeanResponse, SecondMoments};
use goldtof::scene::{DetectorIndex, Path, PathIndex, Scene, Source, SourceIndex};
use goldtof::sensor::Sensor;
use optics_support::sequential::Seldom;
use optics_support::{Moments, assert_within_standard_errors, table_i_scene};

const TIER: CountingTier = CountingTier::Events;
const PERIOD_PS: f64 = 127.0 * 8000.0;
const PERIOD_OF_DEGREE_5_PS: f64 = 31.0 * 8000.0;

fn gold(degree: u32, index: i64) -> Arc<Code> {
    let spec = CodeSpec { degree: Some(degree), index: Some(index), ..CodeSpec::new(Family::Gold) };
    Arc::new(spec.build().expect("a code of the set"))
}

/// The sensor of Table I with `paths`: index of the code, delay in chips, share of
/// the light.
fn scene(mean_rate_cps: f64, integration_chips: u64, paths: &[(i64, f64, f64)]) -> Scene {
    scene_of_degree(7, mean_rate_cps, integration_chips, paths)
}

fn scene_of_degree(
    degree: u32,
    mean_rate_cps: f64,
    integration_chips: u64,
    paths: &[(i64, f64, f64)],
) -> Scene {
    let mut scene = table_i_scene(gold(degree, paths[0].0), mean_rate_cps, integration_chips);
    let (source, path) = (scene.sources[0].clone(), scene.paths[0].clone());
    scene.paths.clear();
    for &(index, delay_chips, share) in paths {
        let code = gold(degree, index);
        let known = scene.sources.iter().position(|s| s.code.chips == code.chips);
        let number = known.unwrap_or_else(|| {
            scene.sources.push(Source { name: format!("code-{index}"), code, ..source.clone() });
            scene.sources.len() - 1
        });
        scene.paths.push(Path {
            source: SourceIndex(number),
            delay_ps: delay_chips * 8000.0,
            transmission: share,
            ..path.clone()
        });
    }
    scene
}

fn fits(scene: &Scene, other: OtherLight, scans: u64) -> Vec<Result<ModelEstimate, FitError>> {
    let mut fits = Vec::new();
    fits_until(scene, other, |fitted| {
        fits.push(fitted);
        fits.len() as u64 == scans
    });
    fits
}

/// Fits scan after scan, until that suffices.
fn fits_until(
    scene: &Scene,
    other: OtherLight,
    suffices: impl FnMut(Result<ModelEstimate, FitError>) -> bool,
) {
    let sensor = Sensor::new(scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, TIER).expect("a response");
    let second = SecondMoments::new(&response).expect("second moments");
    let sampler = CountSampler::of(&model, &second).expect("finite moments");
    let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, other);
    let _ = (0..).map(|scan| fitter.fit(&sampler.scan(11, scan))).any(suffices);
}

/// Errors in bounds, path by path, of the scans that found all paths within a chip;
/// and the largest error of any in its own standard deviations.
fn errors_in_bounds(
    scene: &Scene,
    fits: &[Result<ModelEstimate, FitError>],
) -> (Vec<Vec<f64>>, f64) {
    let bound = bound(&Sensor::new(scene), DetectorIndex(0), TIER).expect("a bound");
    let mut errors = vec![Vec::new(); scene.paths.len()];
    let mut largest: f64 = 0.0;
    for fitted in fits.iter().flatten() {
        let mut found = fitted.paths.clone();
        found.sort_by(|a, b| a.delay_ps.total_cmp(&b.delay_ps));
        let errors_ps: Vec<Option<(f64, f64)>> = scene
            .paths
            .iter()
            .map(|path| {
                let code = &scene.sources[path.source].code.chips;
                let place = found.iter().position(|f| &f.code.chips == code)?;
                let fitted = found.remove(place);
                let error = delay_error_ps(fitted.delay_ps, path.delay_ps, PERIOD_PS);
                (error.abs() < 8000.0).then_some((error, fitted.delay_std_ps))
            })
            .collect();
        if errors_ps.iter().all(Option::is_some) {
            for (number, (error, std)) in errors_ps.into_iter().flatten().enumerate() {
                let bound_m = bound.of_path(PathIndex(number)).expect("a lit path");
                errors[number].push(distance_m(error) / bound_m);
                largest = largest.max((error / std).abs());
            }
        }
    }
    (errors, largest)
}

fn root_mean_square(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn paths_closer_than_a_chip_are_told_apart_at_the_bound() {
    for (apart, ratio) in [(0.6, 1.0), (0.9, 0.3)] {
        let scene = scene(5e6, 400_000, &[(3, 40.3, 1.0), (3, 40.3 + apart, ratio)]);
        let scans = 40;
        let fits = fits(&scene, OtherLight::Given, scans);
        let (errors, largest) = errors_in_bounds(&scene, &fits);
        for of_path in &errors {
            assert!(of_path.len() as u64 >= scans - 1, "{apart}: {}", of_path.len());
            // Of 40 squares the mean is within 1 +- 0.22; bias is in it.
            let rms = root_mean_square(of_path);
            assert!((0.7..1.35).contains(&rms), "{apart} {ratio}: {rms}");
        }
        assert!(largest < 5.0, "{largest}");
    }
}

/// Where the paths of a close pair are may be in doubt; where a third one beside them is, is
/// not. With the pair's doubt added to it, it said 170 times what it scatters.
#[test]
fn a_path_beside_a_close_pair_scatters_as_the_fit_says() {
    let paths = [(3, 3.66, 0.33), (3, 4.23, 0.47), (3, 5.54, 0.17)];
    let scene = scene_of_degree(5, 20e6, 572_000, &paths);
    let scans = 60;
    let (mut errors_ps, mut said_ps2) = (vec![Vec::new(); 3], vec![Vec::new(); 3]);
    for fitted in fits(&scene, OtherLight::Given, scans).iter().flatten() {
        let mut found = fitted.paths.clone();
        found.sort_by(|a, b| a.delay_ps.total_cmp(&b.delay_ps));
        assert_eq!(found.len(), 3);
        for (number, (found, path)) in found.iter().zip(&scene.paths).enumerate() {
            errors_ps[number].push(delay_error_ps(
                found.delay_ps,
                path.delay_ps,
                PERIOD_OF_DEGREE_5_PS,
            ));
            said_ps2[number].push(found.delay_std_ps.powi(2));
        }
    }
    for (errors_ps, said_ps2) in errors_ps.into_iter().zip(said_ps2) {
        assert_eq!(errors_ps.len() as u64, scans);
        let said = Moments::of(said_ps2).mean;
        let scatter = Moments::of(errors_ps);
        assert_within_standard_errors(scatter.z(0.0), 4.0, "bias");
        // Of 60 squares the mean is within 1 +- 0.18.
        assert_within_standard_errors(scatter.variance_z(said), 4.0, "scatter");
    }
}

#[test]
fn paths_too_close_for_the_light_are_said_to_be_and_no_answer_is_confident_and_wrong() {
    let scene = scene(5e6, 20_000, &[(3, 40.3, 1.0), (3, 40.5, 1.0)]);
    let fits = fits(&scene, OtherLight::Given, 40);
    let mut told = 0;
    for fitted in fits.iter().flatten() {
        told += u32::from(fitted.untold.is_none());
        let nearest = |delay_ps: f64| {
            let errors =
                scene.paths.iter().map(|p| delay_error_ps(delay_ps, p.delay_ps, PERIOD_PS));
            errors.map(f64::abs).fold(f64::INFINITY, f64::min)
        };
        let path = &fitted.paths[0];
        assert!(nearest(path.delay_ps) < 4.0 * path.delay_std_ps, "{path:?}");
        if let Some(untold) = &fitted.untold {
            assert_eq!(untold.missing, 1);
            // Half of what could hide is in the standard deviation.
            assert!(fitted.std_m >= 0.49 * untold.resolution_m);
            assert!(untold.resolution_m > distance_m(0.2 * 8000.0));
        }
    }
    assert!(told < 10, "{told} of 40 told what the light does not");
}

/// Of paths less than two phase steps apart the counts tell middle and width, and hardly how the
/// light is shared out: a pair the other way round fits as well. In a straight valley of
/// likelihood one scan in a dozen was off by more than four of its standard deviations.
#[test]
fn paths_that_may_be_the_other_way_round_are_not_said_to_be_known() {
    let scene = scene_of_degree(5, 5e6, 240_000, &[(3, 9.0375, 1.0), (3, 9.2375, 0.3)]);
    let mut wrong = Seldom::new(0.01, 1.0 / 12.0, 0.015);
    let mut untold = Seldom::new(0.4, 0.8, 0.001);
    let mut refused = 0;
    fits_until(&scene, OtherLight::Given, |fitted| {
        // A fit that is refused is not told apart, but has to be seldom.
        refused += usize::from(fitted.is_err());
        assert!(refused < 20, "{fitted:?}");
        let Ok(fitted) = fitted else { return false };
        untold.take(fitted.untold.is_some());
        wrong.take(fitted.paths.iter().any(|found| {
            let errors = scene.paths.iter();
            let errors =
                errors.map(|p| delay_error_ps(found.delay_ps, p.delay_ps, PERIOD_OF_DEGREE_5_PS));
            let nearest = errors.map(f64::abs).fold(f64::INFINITY, f64::min);
            nearest > 4.0 * found.delay_std_ps
        }));
        !wrong.is_open() && !untold.is_open()
    });
    untold.assert_holds("not told");
    wrong.assert_holds("wrong");
}

/// A path of another source that the counts do not show is said to be missing, and one that
/// they show is not.
#[test]
fn a_path_of_another_source_that_is_not_seen_is_said_to_be_missing() {
    let missing_of_others = |share: f64| -> Vec<usize> {
        let scene = scene(5e6, 20_000, &[(3, 40.3, 1.0), (9, 90.7, share)]);
        let fits = fits(&scene, OtherLight::Given, 20);
        let untold = fits.iter().flatten().map(|fitted| match &fitted.untold {
            Some(untold) => {
                assert_eq!((untold.missing, fitted.paths.len()), (0, 1));
                assert!(untold.to_string().contains("other sources"), "{untold}");
                untold.missing_of_others
            }
            None => 0,
        });
        untold.collect()
    };
    assert_eq!(missing_of_others(1.0), [0; 20]);
    assert_eq!(missing_of_others(0.001), [1; 20]);
}

#[test]
fn a_weak_own_path_is_found_under_a_strong_sensor_or_refused_with_its_significance() {
    let paths = [(3, 40.3, 0.05), (9, 90.7, 1.0)];
    let bright = scene(10e6, 400_000, &paths);
    let fits_bright = fits(&bright, OtherLight::Given, 40);
    let mut sorted = bright.clone();
    sorted.paths.sort_by(|a, b| a.delay_ps.total_cmp(&b.delay_ps));
    let (errors, largest) = errors_in_bounds(&sorted, &fits_bright);
    assert!(errors[0].len() >= 39, "{}", errors[0].len());
    assert!((0.7..1.35).contains(&root_mean_square(&errors[0])));
    assert!(largest < 5.0, "{largest}");

    let dark = scene(10e6, 1_000, &paths);
    let fits_dark = fits(&dark, OtherLight::Given, 40);
    let refused = fits_dark.iter().filter(
        |fitted| matches!(fitted, Err(FitError::OwnNotSeen { sigmas, needed }) if sigmas < needed),
    );
    // At a sixth of a per cent of wrong ones at most one of 40 is a guess.
    assert!(refused.count() >= 38);
}

#[test]
fn unknown_sensors_are_found_by_their_codes_and_none_that_is_not_there() {
    let scene_of = |paths: &[(i64, f64, f64)]| scene(9e6, 60_000, paths);
    let scene = scene_of(&[(3, 40.3, 1.0), (60, 71.6, 1.0), (101, 110.2, 1.0)]);
    let found = fits(&scene, OtherLight::Search, 25);
    let (errors, largest) = errors_in_bounds(&scene, &found);
    for of_path in &errors {
        assert_eq!(of_path.len(), 25);
        assert!((0.65..1.45).contains(&root_mean_square(of_path)));
    }
    assert!(largest < 5.0, "{largest}");
    assert!(found.iter().flatten().all(|fitted| fitted.paths.len() == 3));

    // Bright light, whose dead time multiplies it with itself: products of a Gold code
    // with itself are codes of its set.
    let mut alone = scene_of(&[(3, 40.3, 1.0)]);
    alone.sources[0].mean_power_w *= 6.0;
    for fitted in fits(&alone, OtherLight::Search, 25) {
        assert_eq!(fitted.expect("it fits").paths.len(), 1);
    }
}

#[test]
fn two_paths_in_a_scan_round_them_are_told_apart() {
    let mut scene = scene(8e6, 400_000, &[(3, 40.3, 1.0), (3, 42.4, 0.5)]);
    scene.scan.first_step = 40 * 8 - 16;
    scene.scan.steps = 52;
    let fits = fits(&scene, OtherLight::Given, 30);
    let (errors, largest) = errors_in_bounds(&scene, &fits);
    for of_path in &errors {
        assert_eq!(of_path.len(), 30);
        assert!((0.65..1.4).contains(&root_mean_square(of_path)));
    }
    assert!(largest < 5.0, "{largest}");
}

/// With several steps at once the counts of a group go together, in a scan that is too long
/// to work out every group's moments: every path is found, what noise makes of neighbours
/// that go together passes for no light, and chi-square is what it should be. Scatter is
/// not the bound's, and a warning says so.
#[test]
fn steps_that_share_their_light_are_told_apart() {
    for parallel in [4, 16] {
        let mut scene = scene(10e6, 20_000, &[(3, 40.3, 0.6), (3, 42.1, 0.4), (9, 90.7, 0.6)]);
        scene.hardware.parallel = parallel;
        let warned = shared_light(&Sensor::new(&scene), DetectorIndex(0)).expect("a warning");
        assert!(warned.contains("3 times"), "{warned}");
        let fits = fits(&scene, OtherLight::Given, 24);
        let (errors, _) = errors_in_bounds(&scene, &fits);
        let found: Vec<&ModelEstimate> = fits.iter().flatten().collect();
        let degrees = found.iter().map(|fit| fit.degrees_of_freedom as f64);
        let reduced = found.iter().map(|fit| fit.chi_square).sum::<f64>() / degrees.sum::<f64>();
        for (number, of_path) in errors.iter().enumerate() {
            let mut sizes: Vec<f64> = of_path.iter().map(|error| error.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let median = sizes[sizes.len() / 2];
            println!(
                "parallel {parallel}, path {number}: {} of 24 found, median error {median:.3} \
                 bounds, rms {:.3}, chi-square {reduced:.4} a degree",
                of_path.len(),
                root_mean_square(of_path)
            );
            assert!(of_path.len() >= 23, "{parallel}: {}", of_path.len());
            // Half of a normal distribution's is within 0.67, of 24 draws within 0.67 +- 0.5
            // (3 standard errors); the joint fit's scatter is here up to 1.7 times the bound.
            assert!((0.17..1.7).contains(&median), "{parallel}: {median}");
        }
        // 24 scans of 1016 steps and their totals scatter by 0.8 %; few groups stand for all.
        assert!((0.95..1.05).contains(&reduced), "{parallel}: {reduced}");
        assert!(found.iter().all(|fit| fit.paths.len() == 3));
    }
    let alone = scene(10e6, 20_000, &[(3, 40.3, 0.6)]);
    assert_eq!(shared_light(&Sensor::new(&alone), DetectorIndex(0)), None);
}

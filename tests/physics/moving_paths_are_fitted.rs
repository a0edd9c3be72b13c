//! A path at a constant speed, fitted with its speed unknown: against counts of exact
//! moments, against photons, and against the bound.

use goldtof::estimate::bound::{PathBound, bound};
use goldtof::estimate::fit::{FitError, Fitter, ModelEstimate, OtherLight, fit_means};
use goldtof::estimate::{CountingTier, distance_m, true_delay};
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::response::{CountMoments, CountSampler, MeanCount, MeanResponse, SecondMoments};
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, Fluctuation, Movement, PathIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::scans;
use optics_support::{assert_within_standard_errors, gold_5, repeated, table_i_scene};

const SPAD: DetectorIndex = DetectorIndex(0);
const TIER: CountingTier = CountingTier::Events;

/// Table I with a code of 31 chips, 12 million primary detections per second, and a path that
/// walks by 0.05 phase steps in each.
fn scene(chips: u64, walk_steps: f64) -> Scene {
    let mut scene = table_i_scene(gold_5(), 12e6, chips);
    let step_s = chips as f64 * 8e-9;
    scene.paths[0].movement = Some(Movement {
        velocity_m_per_s: distance_m(1000.0 * walk_steps) / step_s,
        fluctuation: None,
    });
    scene
}

fn bound_of(scene: &Scene) -> PathBound {
    let bound = bound(&Sensor::new(scene), SPAD, TIER).expect("a bound");
    // Whoever reads the number is told that it is not of the whole scan.
    let remark = bound.remark(PathIndex(0)).unwrap_or_default();
    let said = format!("of the {} phase steps round the peak", bound.steps);
    assert!(remark.contains(&said), "{remark}");
    bound.paths[0]
}

/// What the steps of a scan expect, each by a path that stands still at many places of its
/// way in turn.
fn expected(scene: &Scene, places: u32) -> Vec<MeanCount> {
    let sensor = Sensor::new(scene);
    let timing = sensor.timing();
    let of_step = |step: Step| {
        let mut sum = MeanCount { signed: 0.0, total: 0.0 };
        for place in 0..places {
            let share = (f64::from(place) + 0.5) / f64::from(places) - 0.5;
            let at_ps = timing.middle_of_step_ps(step) + share * timing.integration_ps();
            let model = DetectorModel::new(&sensor.still_at(at_ps), SPAD);
            let response = MeanResponse::of_tier(&model, TIER).expect("a response");
            let mean = response.mean_count(step);
            sum.signed += mean.signed / f64::from(places);
            sum.total += mean.total / f64::from(places);
        }
        sum
    };
    Step::all(scene.scan.steps).map(of_step).collect()
}

/// The moment is that of the truth, and there the fit says where the path is, and how fast,
/// whatever the speed.
#[test]
fn expected_counts_of_a_path_that_moves_give_its_distance_and_speed() {
    for walk in [-0.2, 0.0, 0.05, 0.2] {
        let mut scene = scene(31 * 200 + 17, walk);
        if walk == 0.0 {
            scene.paths[0].movement = None;
        }
        let sensor = Sensor::new(&scene);
        let fitted = fit_means(&sensor, SPAD, TIER, &expected(&scene, 9), OtherLight::Given);
        let fitted = fitted.expect("a fit");
        let truth = true_delay(&sensor, PathIndex(0), TIER);
        let error_mm = 1e3 * distance_m(fitted.delay_ps - truth.delay_ps);
        println!("walk {walk}: off by {error_mm:.4} mm, {:?}", fitted.velocity);
        // A step that moves by a fifth of its own is an average of more than two places.
        assert!(error_mm.abs() < 0.02 + 0.5 * walk.abs(), "walk {walk}: {error_mm} mm");
        let Some(velocity) = fitted.velocity else {
            assert_eq!(walk, 0.0);
            continue;
        };
        let movement = scene.paths[0].movement.expect("it moves");
        let off = velocity.m_per_s - movement.velocity_m_per_s;
        assert!(off.abs() < 0.01 * velocity.std_m_per_s, "walk {walk}: {off} m/s");
        let moment_s = truth.at_ps.expect("it moves") * 1e-12;
        assert!((velocity.at_s - moment_s).abs() < 1e-15);
    }
}

/// Holds fits of many scans against truth and bound: bias, scatter, what the fits say of
/// themselves, and chi-square.
fn check(scene: &Scene, fits: &[ModelEstimate], what: &str) {
    let bound = bound_of(scene);
    let truth = true_delay(&Sensor::new(scene), PathIndex(0), TIER);
    let movement = scene.paths[0].movement.expect("it moves");
    let velocity_bound = bound.velocity_bound_m_per_s.expect("it moves");
    let of_fit = |fit: &ModelEstimate| {
        let velocity = fit.velocity.expect("it moves");
        [
            (distance_m(fit.delay_ps - truth.delay_ps), fit.std_m, bound.bound_m),
            (velocity.m_per_s - movement.velocity_m_per_s, velocity.std_m_per_s, velocity_bound),
        ]
    };
    let scans = fits.len() as f64;
    for unknown in 0..2 {
        let values: Vec<(f64, f64, f64)> = fits.iter().map(|fit| of_fit(fit)[unknown]).collect();
        let bias = values.iter().map(|v| v.0).sum::<f64>() / scans;
        let squares = values.iter().map(|v| (v.0 - bias).powi(2)).sum::<f64>();
        let std = (squares / (scans - 1.0)).sqrt();
        let claimed = values.iter().map(|v| v.1).sum::<f64>() / scans;
        let bound = values[0].2;
        println!(
            "{what}: bias {:.3} bounds, std / bound {:.3}, claimed / std {:.3}, bound {bound:.4}",
            bias / bound,
            std / bound,
            claimed / std
        );
        let error = 1.0 / (2.0 * (scans - 1.0)).sqrt();
        assert_within_standard_errors((std / bound - 1.0) / error, 4.0, what);
        assert_within_standard_errors((claimed / std - 1.0) / error, 4.0, what);
        assert_within_standard_errors(bias / bound * scans.sqrt(), 4.0, what);
    }
    let degrees = fits[0].degrees_of_freedom as f64;
    let chi_square = fits.iter().map(|fit| fit.chi_square).sum::<f64>() / scans / degrees;
    println!("{what}: chi-square {chi_square:.4} a degree");
    let spread = (2.0 / degrees / scans).sqrt();
    assert_within_standard_errors((chi_square - 1.0) / spread, 5.0, what);
}

/// Counts of each step drawn from the exact moments of a path that stands still where this
/// one is in the step's middle.
#[test]
fn fits_to_counts_of_exact_moments_scatter_as_the_bound_says() {
    let scene = scene(31 * 400 + 17, 0.05);
    let sensor = Sensor::new(&scene);
    let fitter = Fitter::new(&sensor, SPAD, TIER, OtherLight::Given);
    let moment_ps = true_delay(&sensor, PathIndex(0), TIER).at_ps;
    let moment_ps = moment_ps.expect("it moves");
    let of_step = |step: Step| {
        let step_ps = sensor.timing().middle_of_step_ps(step);
        // Where the peak is not, it does not matter where the path is.
        let is_near = (step_ps - moment_ps).abs() < 40.0 * sensor.timing().integration_ps();
        let at_ps = if is_near { step_ps } else { moment_ps };
        let model = DetectorModel::new(&sensor.still_at(at_ps), SPAD);
        let response = MeanResponse::of_tier(&model, TIER).expect("a response");
        SecondMoments::new(&response).expect("second moments").of_step(step)
    };
    let moments: Vec<CountMoments> = Step::all(scene.scan.steps).map(of_step).collect();
    let model = DetectorModel::new(&sensor, SPAD);
    let sampler = CountSampler::new(&model, &moments).expect("finite moments");
    let fits: Result<Vec<ModelEstimate>, FitError> =
        (0..repeated(50, 80)).map(|scan| fitter.fit(&sampler.scan(5, scan))).collect();
    check(&scene, &fits.expect("fits"), "exact moments");
}

#[test]
fn fits_to_photons_scatter_as_the_bound_says() {
    let scene = scene(31 * 200 + 17, 0.1);
    let sensor = Sensor::new(&scene);
    let fitter = Fitter::new(&sensor, SPAD, TIER, OtherLight::Given);
    let mut fits = Vec::new();
    scans(&sensor, SPAD, Tier::Events, 7, repeated(40, 60), |scan| {
        fits.push(fitter.fit(scan).expect("a fit"));
    })
    .expect("scans");
    check(&scene, &fits, "photons");
}

#[test]
fn movements_that_no_fit_follows_are_refused_with_the_reason() {
    let mut fluctuating = scene(31 * 200, 0.05);
    fluctuating.paths[0].movement = Some(Movement {
        velocity_m_per_s: 0.0,
        fluctuation: Some(Fluctuation { std_m: 0.01, correlation_time_ps: 1e9 }),
    });
    let mut two = scene(31 * 200, 0.05);
    two.paths.push(two.paths[0].clone());
    two.paths[1].delay_ps += 40e3;
    for scene in [fluctuating, two] {
        let sensor = Sensor::new(&scene);
        let counts = vec![StepCount { signed: 3, total: 5 }; scene.scan.steps as usize];
        let refused = Fitter::new(&sensor, SPAD, TIER, OtherLight::Given).fit(&counts);
        assert_eq!(refused.err(), Some(FitError::Moves { path: PathIndex(0) }));
        assert!(bound(&sensor, SPAD, TIER).is_err());
    }
    // Twice as fast as a fit follows: by the counts of a scan whose peak is as much too narrow.
    let mut fast = scene(31 * 200, 0.5);
    let counts = expected(&fast, 9);
    fast.paths[0].movement = scene(31 * 200, 0.05).paths[0].movement;
    let refused = fit_means(&Sensor::new(&fast), SPAD, TIER, &counts, OtherLight::Given);
    assert!(matches!(refused, Err(FitError::TooFast { .. })), "{refused:?}");
}

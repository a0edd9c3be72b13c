//! Own light under another sensor's whose clock is not the detector's: what that sensor's
//! code adds to the scatter is in what the fit says of itself.

use goldtof::estimate::fit::{FitError, Fitter, ModelEstimate, OtherLight};
use std::sync::Arc;

use goldtof::Jobs as _;
use goldtof::code::{CodeSpec, Family};
use goldtof::estimate::{CountingTier, delay_error_ps, distance_m};
use goldtof::scene::{DetectorIndex, EstimatorKind, Path, Scene, SourceIndex, load_with};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::path_statistics::PathStatistics;
use goldtof::simulate::scans::scans;

use optics_support::{
    Moments, assert_within_standard_errors, code, gold, m_sequence, repeated, table_i_scene,
};

const SPAD: DetectorIndex = DetectorIndex(0);
const CODE_CHIPS: f64 = 127.0;
/// Chips of a step, not in whole code periods.
const CHIPS: u64 = 127 * 50 + 13;

/// Own light and `ratio` times as much of another's, whose clock slips by so many chips in a
/// step, in a window of 5 chips to either side of the own path.
fn scene(ratio: f64, slip_chips: f64) -> Scene {
    let mut scene = table_i_scene(gold(7, &[7, 3], &[7, 3, 2, 1]), 20e6 / ratio, CHIPS);
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    other.mean_power_w *= ratio;
    other.code = {
        // Another code of the set.
        let [u, v] = [m_sequence(7, &[7, 3]), m_sequence(7, &[7, 3, 2, 1])];
        let chips: Vec<u8> = (0..127).map(|i| u[i] ^ v[(i + 5) % 127]).collect();
        code(&chips)
    };
    other.clock.offset = slip_chips / CHIPS as f64;
    scene.sources.push(other);
    scene.paths[0].delay_ps = 20.037 * scene.chip_period_ps;
    scene.paths.push(Path { source: SourceIndex(1), ..scene.paths[0].clone() });
    scene.scan.first_step = 8 * 15;
    scene.scan.steps = 80;
    scene
}

fn fits(scene: &Scene, repetitions: u64) -> Vec<Result<ModelEstimate, FitError>> {
    let sensor = Sensor::new(scene);
    let fitter = Fitter::new(&sensor, SPAD, CountingTier::Events, OtherLight::Given);
    let mut fits = Vec::new();
    scans(&sensor, SPAD, Tier::Events, 5, repetitions, |counts| {
        fits.push(fitter.fit(counts));
    })
    .expect("scans");
    fits
}

/// What fits of a scene's scans say of the own path.
struct Said {
    fitted: u64,
    /// Refused, because the own light does not stand out.
    not_seen: u64,
    /// Errors over the fits' own standard deviations.
    errors_in_sigmas: Vec<f64>,
    chi_square_per_degree: Moments,
}

impl Said {
    fn of(scene: &Scene, scans: u64) -> Said {
        let all = fits(scene, scans);
        let refused = |fit: &&Result<ModelEstimate, FitError>| matches!(fit, Err(FitError::OwnNotSeen { sigmas, needed }) if sigmas < needed);
        let fitted: Vec<&ModelEstimate> = all.iter().flatten().collect();
        let truth_ps = scene.paths[0].delay_ps;
        let error = |fit: &&ModelEstimate| {
            let error_ps =
                delay_error_ps(fit.delay_ps, truth_ps, CODE_CHIPS * scene.chip_period_ps);
            error_ps / fit.paths[0].delay_std_ps
        };
        let chi_square = |fit: &&ModelEstimate| fit.chi_square / fit.degrees_of_freedom as f64;
        Said {
            fitted: fitted.len() as u64,
            not_seen: all.iter().filter(refused).count() as u64,
            errors_in_sigmas: fitted.iter().map(error).collect(),
            chi_square_per_degree: Moments::of(fitted.iter().map(chi_square)),
        }
    }

    /// Off by more than four of the fit's own standard deviations.
    fn wrong(&self) -> usize {
        let errors = self.errors_in_sigmas.iter();
        errors.filter(|error| error.abs() > 4.0).count()
    }
}

/// Photons, so that nothing is shared with the covariance that the fit works out. Without
/// it chi-square per degree is 1.24 here, and errors scatter by 1.5 standard deviations.
#[test]
fn what_another_clocks_code_adds_to_the_scatter_is_in_what_the_fit_says() {
    let scans = repeated(60, 150);
    let said = Said::of(&scene(3.0, 2.6), scans);
    assert_eq!(said.fitted, scans);
    assert_eq!(said.wrong(), 0);
    // Some 45 degrees: a scan's chi-square is within 1 +- 0.21, the mean of 60 within 0.03;
    // the code's correlation is not Gaussian.
    let chi_square = said.chi_square_per_degree.mean;
    assert!((0.88..1.12).contains(&chi_square), "{chi_square}");
    let errors = Moments::of(said.errors_in_sigmas);
    assert_within_standard_errors(errors.z(0.0), 4.0, "bias");
    assert_within_standard_errors(errors.variance_z(1.0), 4.0, "scatter");
}

/// Without a say on whether the own light stands out a quarter of the scans of the first
/// ratio, and two thirds of those of the second, were wrong by four standard deviations.
#[test]
fn own_light_that_another_clocks_code_hides_is_refused_and_not_guessed() {
    let scans = repeated(50, 150);
    let few = Said::of(&scene(10.0, 2.6), scans);
    assert_eq!(few.fitted + few.not_seen, scans);
    // A third to two thirds stand out; noise and what stands out by chance: 1 or 2 of 150.
    assert!(few.fitted > scans / 3 && few.not_seen > scans / 5);
    assert!(few.wrong() <= 3, "{} of {}", few.wrong(), few.fitted);

    let none = Said::of(&scene(30.0, 2.6), scans);
    assert!(none.not_seen >= scans - 2, "{}", none.fitted);
}

/// `quick` in steps of 104.8 us, beside two sensors whose clocks are off by nearly as much as the reference steps on, to either
/// side.
fn beside_two_sensors(estimator: EstimatorKind) -> Scene {
    let integration = "scan.integration=104.8 us".parse().expect("a setting");
    let mut scene = load_with("scenes/quick.toml".as_ref(), &[integration]).expect("it is sound");
    scene.estimator = estimator;
    for (index, metres, offset) in [(2, 5.0, 18e-6), (4, 7.0, -17.43e-6)] {
        let spec = CodeSpec { degree: Some(5), index: Some(index), ..CodeSpec::new(Family::Gold) };
        let mut other = scene.sources[0].clone();
        other.name = format!("code {index}");
        other.code = Arc::new(spec.build().expect("a code of the set"));
        other.clock.offset = offset;
        let source = SourceIndex(scene.sources.len());
        scene.sources.push(other);
        let delay_ps = metres / distance_m(1.0);
        scene.paths.push(Path { source, delay_ps, ..scene.paths[0].clone() });
    }
    scene
}

/// What photons make of the own path.
fn own_path(scene: &Scene, scans: u64) -> PathStatistics {
    let simulated = Sensor::new(scene).simulate(Tier::Events.scans(scans).seeded(77));
    simulated.expect("the scene can be simulated").estimates.remove(0)
}

/// Beside the steps one code hardly moves, and looks like a path, here in one scan of eight. Those errors, of metres, must not
/// come back, and fits scatter as is expected.
#[test]
fn two_sensors_that_slip_nearly_as_the_reference_steps_do_not_mislead() {
    let scans = repeated(30, 600);
    let own = own_path(&beside_two_sensors(EstimatorKind::Model), scans);
    assert_eq!(own.missed_scans, 0, "of {scans}");
    let (found, expected) = (own.std_m.expect("a number"), own.expected_std_m.expect("a number"));
    // Fits of 300 scans scatter by 1.00 +- 0.04 of what is expected.
    let error = 1.0 / f64::sqrt(2.0 * scans as f64);
    assert!((found / expected - 1.0).abs() < 0.1 + 3.0 * error, "{found} {expected}");
}

/// The phase takes the largest correlation of the other sensors' codes for its own light's where that is missing: no distance
/// then, and one of most scans where it is there, but for some in which those codes take from its peak. With several steps at once,
/// and for a fit, the same.
#[test]
fn the_largest_correlation_of_other_clocks_codes_is_refused() {
    for (estimator, parallel) in
        [(EstimatorKind::Fft, 1), (EstimatorKind::Fft, 4), (EstimatorKind::Model, 4)]
    {
        let mut scene = beside_two_sensors(estimator);
        scene.hardware.parallel = parallel;
        let lit = own_path(&scene, repeated(6, 20));
        let refused = lit.refused_fraction.expect("of scans");
        assert!(refused < 0.4, "{estimator:?}, {parallel}: {lit:?}");
        scene.sources[0].mean_power_w *= 1e-9;
        let dark = own_path(&scene, repeated(6, 40));
        let refused = dark.refused_fraction.expect("of scans");
        let given = (1.0 - refused) * dark.estimates as f64;
        assert!(given <= 1.0, "{estimator:?}, {parallel}: {dark:?}");
    }
}

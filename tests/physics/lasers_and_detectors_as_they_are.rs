//! A laser's edges and the tail of a detector's jitter, in photons, expected counts and
//! the fit, against a detector that is stepped through time.

use goldtof::estimate::CountingTier;
use goldtof::estimate::distance_m;
use goldtof::estimate::fit::{OtherLight, fit_means};
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::response::{MeanCount, MeanResponse, SecondMoments};
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, JitterTail, LaserResponse, Scene, WaveformCurve};
use goldtof::sensor::Sensor;

use optics_support::stepped::Stepped;
use optics_support::{Moments, assert_within_standard_errors, gold_5, ideal_scene, table_i_scene};

const TIER: CountingTier = CountingTier::Events;
/// Time of flight in whole steps of 25 ps.
const DELAY_PS: f64 = 21_350.0;

/// The sensor of Table I with a slow laser and a detector with a diffusion tail.
fn slow(rate_cps: f64, integration_chips: u64) -> Scene {
    let mut scene = table_i_scene(gold_5(), rate_cps, integration_chips);
    scene.paths[0].delay_ps = DELAY_PS;
    scene.sources[0].response = LaserResponse::Edges { rise_time_ps: 600.0, fall_time_ps: 1_200.0 };
    scene.detectors[0].jitter_tail =
        JitterTail::Exponential { share: 0.15, time_constant_ps: 400.0 };
    scene
}

fn means(scene: &Scene) -> Vec<MeanCount> {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, TIER).expect("it can be solved");
    response.mean_counts()
}

/// Largest difference of signed and of total counts, as a share of the peak.
fn differences(a: &[MeanCount], b: &[MeanCount]) -> [f64; 2] {
    let peak = a.iter().map(|count| count.signed).fold(0.0, f64::max);
    let largest = |of: &dyn Fn(&MeanCount) -> f64| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (of(a) - of(b)).abs()).fold(0.0, f64::max) / peak
    };
    [largest(&|count| count.signed), largest(&|count| count.total)]
}

#[test]
fn edges_and_a_tail_count_as_a_detector_stepped_through_time() {
    let scene = slow(30e6, 31 * 100);
    let stepped = Stepped::new(&scene, 25.0).counts();
    let [signed, total] = differences(&stepped, &means(&scene));
    assert!(signed < 5e-4 && total < 5e-4, "{signed:.1e} {total:.1e}");

    // Each of the two matters by far more than that.
    let mut without_edges = scene.clone();
    without_edges.sources[0].response = LaserResponse::Ideal;
    let mut without_tail = scene.clone();
    without_tail.detectors[0].jitter_tail = JitterTail::None;
    for other in [without_edges, without_tail] {
        let [signed, _] = differences(&stepped, &means(&other));
        assert!(signed > 5e-3, "{signed:.1e}");
    }
}

/// Light that lasts longer than its chips, or shorter, of the same mean power.
#[test]
fn a_distorted_duty_cycle_counts_as_a_detector_stepped_through_time() {
    let edges = slow(30e6, 31 * 100);
    for (rise_time_ps, fall_time_ps, longer_ps) in
        [(600.0, 1_200.0, 1_400.0), (0.0, 0.0, 900.0), (0.0, 0.0, -1_550.0), (400.0, 400.0, -3e3)]
    {
        let mut scene = edges.clone();
        scene.sources[0].response =
            LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps };
        let stepped = Stepped::new(&scene, 25.0).counts();
        let [signed, total] = differences(&stepped, &means(&scene));
        assert!(signed < 5e-4 && total < 5e-4, "{longer_ps}: {signed:.1e} {total:.1e}");
        let mut as_chips = scene.clone();
        as_chips.sources[0].response = LaserResponse::Edges { rise_time_ps, fall_time_ps };
        let [signed, _] = differences(&stepped, &means(&as_chips));
        assert!(signed > 1e-2, "{longer_ps}: {signed:.1e}");
        photons_count_as_expected(&scene);
    }
    // Without dead time, detections are those of the mean power.
    let mut ideal = ideal_scene(gold_5(), 10e6, 310);
    for longer_ps in [-3e3, 0.0, 2e3] {
        let edges = (0.0, 500.0);
        let (rise_time_ps, fall_time_ps) = edges;
        ideal.sources[0].response =
            LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps };
        let found = means(&ideal)[0].total;
        assert!((found - 10e6 * 310.0 * 8e-9).abs() < 1e-6, "{longer_ps}: {found}");
    }
}

/// The fit that is told, and the one that is not.
#[test]
fn the_fit_has_no_bias_from_a_duty_cycle_that_it_is_told_of() {
    let mut scene = slow(20e6, 31 * 1000);
    scene.sources[0].response =
        LaserResponse::Stretched { rise_time_ps: 600.0, fall_time_ps: 600.0, longer_ps: 800.0 };
    let counts = Stepped::new(&scene, 25.0).counts();
    let fit = fit_means(&Sensor::new(&scene), DetectorIndex(0), TIER, &counts, OtherLight::Given);
    let error_mm = 1e3 * (fit.expect("a fit").distance_m - distance_m(DELAY_PS));
    assert!(error_mm.abs() < 0.1, "{error_mm:.3} mm");
}

/// A box of 1 ns is what straight edges of 0.8 ns between 10 and 90 % come from.
#[test]
fn a_measured_response_counts_as_the_edges_that_it_makes() {
    let mut scene = slow(30e6, 31 * 100);
    scene.sources[0].response = LaserResponse::Edges { rise_time_ps: 800.0, fall_time_ps: 800.0 };
    let edges = means(&scene);
    let points = (0..16).map(|n| [62.5 * (f64::from(n) - 7.5), 1.0 / 16.0]);
    scene.sources[0].response = LaserResponse::Measured(WaveformCurve { points: points.collect() });
    let [signed, total] = differences(&edges, &means(&scene));
    assert!(signed < 5e-4 && total < 5e-4, "{signed:.1e} {total:.1e}");
}

/// A histogram that has an exponential's shape, in steps of a twentieth of its mean.
#[test]
fn a_measured_tail_counts_as_the_exponential_that_it_is() {
    let scene = slow(30e6, 31 * 100);
    let mut measured = scene.clone();
    let bin_ps = 20.0;
    let late = |n: i32| 0.15 * (-f64::from(n) * bin_ps / 400.0_f64).exp();
    let mut points: Vec<[f64; 2]> = vec![[0.0, 0.85]];
    points.extend((0..400).map(|n| {
        // The mean of an exponential number within a bin.
        let ratio = bin_ps / 400.0;
        let inside = 400.0 * (1.0 - ratio / (ratio.exp() - 1.0));
        [f64::from(n) * bin_ps + inside, late(n) - late(n + 1)]
    }));
    measured.detectors[0].jitter_tail = JitterTail::Measured(WaveformCurve { points });
    let [signed, total] = differences(&means(&scene), &means(&measured));
    assert!(signed < 1e-4 && total < 1e-4, "{signed:.1e} {total:.1e}");
}

/// Counts of the stepped detector, fitted with what is right and with what is wrong.
#[test]
fn the_fit_has_no_bias_from_edges_and_tails_that_it_is_told_of() {
    let scene = slow(20e6, 31 * 1000);
    let counts = Stepped::new(&scene, 25.0).counts();
    let error_mm = |assumed: &Scene| {
        let sensor = Sensor::new(assumed);
        let fit = fit_means(&sensor, DetectorIndex(0), TIER, &counts, OtherLight::Given);
        let fit = fit.expect("a fit");
        1e3 * (fit.distance_m - distance_m(DELAY_PS))
    };
    let told = error_mm(&scene);
    assert!(told.abs() < 0.1, "{told:.3} mm");
    let mut edges = scene.clone();
    edges.sources[0].response = LaserResponse::Ideal;
    let mut tail = scene.clone();
    tail.detectors[0].jitter_tail = JitterTail::None;
    let (edges, tail) = (error_mm(&edges), error_mm(&tail));
    println!("told {told:.3} mm, edges not told {edges:.2} mm, tail not told {tail:.2} mm");
    // 0.15 x 400 ps are 9 mm.
    assert!((tail - 9.0).abs() < 2.0, "{tail:.2} mm");
}

#[test]
fn photons_with_edges_and_a_tail_count_as_expected() {
    photons_count_as_expected(&slow(30e6, 1_503));
}

fn photons_count_as_expected(scene: &Scene) {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, TIER).expect("it can be solved");
    let second = SecondMoments::new(&response).expect("it can be solved");
    let means = response.mean_counts();
    let scans = 60;
    let steps: Vec<u64> = (0..scene.scan.steps).step_by(3).collect();
    let mut z = [Vec::new(), Vec::new()];
    let mut ratios = Vec::new();
    for &step in &steps {
        let counts: Vec<StepCount> =
            (0..scans).map(|scan| count_step(&model, 5, scan, Step(step))).collect();
        let moments = second.of_step(Step(step));
        let mean = means[step as usize];
        let signed = Moments::of(counts.iter().map(|count| count.signed as f64));
        let total = Moments::of(counts.iter().map(|count| count.total as f64));
        let error = |variance: f64| (variance / scans as f64).sqrt();
        z[0].push((signed.mean - mean.signed) / error(moments.signed_variance));
        z[1].push((total.mean - mean.total) / error(moments.total_variance));
        ratios.push(signed.variance / moments.signed_variance);
    }
    for (z, what) in z.into_iter().zip(["signed", "total"]) {
        let number = z.len() as f64;
        let chi_square: f64 = z.iter().map(|z| z * z).sum();
        let spread = (chi_square - number) / (2.0 * number).sqrt();
        assert_within_standard_errors(spread, 5.0, &format!("chi-square of {what} means"));
        let mean = z.iter().sum::<f64>() / number.sqrt();
        assert_within_standard_errors(mean, 5.0, &format!("all {what} means together"));
    }
    let ratio = Moments::of(ratios);
    assert_within_standard_errors(ratio.z(1.0), 5.0, "variances");
}

//! One histogram against phase steps one after another, at the same light and measuring time.

use std::path::Path;
use std::sync::LazyLock;

use goldtof::Jobs as _;
use goldtof::scene::{Architecture, EstimatorKind, Scene, load};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::study::architectures::{ArchitectureComparison, ArchitecturePoint, compare};
use optics_support::{gold_9, repeated, table_i_scene};

fn scene(primary_cps: f64, integration_chips: u64) -> Scene {
    table_i_scene(gold_9(), primary_cps, integration_chips)
}

/// Chips of a phase step of the standard scenes: eight measuring times.
const ALL_TIMES: u64 = 13_100;
/// Of these the five shortest.
const FIVE_TIMES: u64 = 200;

/// In bright light, for two tests.
static IN_BRIGHT_LIGHT: LazyLock<ArchitectureComparison> =
    LazyLock::new(|| compare(&scene(25e6, ALL_TIMES)).expect("it can be compared"));

/// The points of one sensor by one estimator, in order of time.
fn points<'c>(
    compared: &'c ArchitectureComparison,
    name: &str,
    estimator: EstimatorKind,
) -> Vec<&'c ArchitecturePoint> {
    let way = compared.ways.iter().find(|way| way.name == name);
    let points = way.expect("there is one").points.iter();
    points.filter(|point| point.estimator == estimator).collect()
}

/// From 4 to 20 million detections per second. Sixteen steps each see a sixteenth of the
/// light, so that their counts scatter four times as much; but their errors are independent,
/// and those of a histogram's steps are not, which takes half of that from the phase, and
/// nothing from the fit to bins.
#[test]
fn a_histogram_is_four_times_as_precise_as_sixteen_steps() {
    // How errors fall with time is the same at any light: in dim light over fewer times.
    let dim = compare(&scene(3.2e6, FIVE_TIMES)).expect("it can be compared");
    for (compared, detected_mcps, times) in [(&dim, 3.56, 5), (&*IN_BRIGHT_LIGHT, 19.3, 8)] {
        assert!((compared.detected_rate_cps / 1e6 / detected_mcps - 1.0).abs() < 0.01);
        let ratios = |estimator| -> Vec<f64> {
            let steps = points(compared, "sequential, near the peak", estimator);
            let histograms = points(compared, "histogram", estimator);
            // Of the shortest time nothing is expected of fits to steps in dim light, which scatter by a quarter of a
            // chip, nor, in bright light, of a histogram's phase: seven code periods say too little of the dead time.
            assert!(steps.len() + 1 >= times && histograms.len() + 1 >= times);
            let of_that_time = |histogram: &ArchitecturePoint| -> Option<f64> {
                let mut steps = steps.iter();
                let times =
                    |steps: &ArchitecturePoint| steps.measuring_time_s / histogram.measuring_time_s;
                let found = steps.find(|steps| (times(steps) - 1.0).abs() < 3e-3)?;
                Some(found.std_m / histogram.std_m)
            };
            let ratios: Vec<f64> = histograms.into_iter().filter_map(of_that_time).collect();
            assert!(ratios.len() + 1 >= times);
            ratios
        };
        for ratio in ratios(EstimatorKind::Model) {
            // Of a few hundred photons estimates see more than one bin: a twentieth less.
            assert!((3.4..4.5).contains(&ratio), "{detected_mcps}: {ratio}");
        }
        let of_phase = ratios(EstimatorKind::Fft);
        for (time, ratio) in of_phase.iter().enumerate() {
            // Of a few hundred photons independent steps take turns to have the largest count.
            let most = if detected_mcps < 4.0 && time < 2 { 2.8 } else { 2.2 };
            assert!((1.6..most).contains(ratio), "{detected_mcps}: {of_phase:?}");
        }
        // Walk stays in the phase of counts, and goes with the histogram's correction.
        let last = |name| *points(compared, name, EstimatorKind::Fft).last().expect("some");
        assert!(last("histogram").bias_m.abs() < 1.6e-3);
        let walk = last("parallel 16, near the peak").bias_m;
        assert!(walk < -2e-3 * detected_mcps, "{walk}");
        // Sixteen steps of the same light have the errors of a histogram's.
        let phase = last("histogram").std_m / last("parallel 16, near the peak").std_m;
        assert!((phase - 1.0).abs() < 0.03, "{phase}");
    }
}

#[test]
fn the_front_is_what_nothing_beats() {
    let all: Vec<&ArchitecturePoint> = IN_BRIGHT_LIGHT
        .ways
        .iter()
        .filter(|way| way.whole_range)
        .flat_map(|way| &way.points)
        .filter(|point| point.coarse_failure_bound_fraction.expect("whole range") <= 0.01)
        .collect();
    for point in &all {
        let is_beaten = all.iter().any(|other| {
            other.measuring_time_s <= 1.001 * point.measuring_time_s
                && other.rms_error_m < point.rms_error_m
        });
        assert_eq!(point.pareto, !is_beaten);
    }
    assert!(all.iter().filter(|point| point.pareto).count() >= 7);
    let mut part = scene(8e6, ALL_TIMES);
    part.scan.steps = 64;
    assert!(compare(&part).is_err());
    let mut dark = scene(8e6, ALL_TIMES);
    dark.sources[0].mean_power_w = 0.0;
    assert!(compare(&dark).is_err());
}

/// Of steps that count the same light a fit has an expectation only where neighbours differ by 50
/// detections: those that come within a phase step of one of the code's edges.
#[test]
fn too_few_photons_for_a_fit_of_shared_light_have_a_remark_in_place_of_numbers() {
    let quick = load(Path::new("scenes/quick.toml")).expect("it is sound");
    let compared = compare(&quick).expect("it can be compared");
    let chips = &quick.sources[0].code.chips;
    let edges = (0..31).filter(|&i| chips[i] != chips[(i + 1) % 31]).count() as f64 / 31.0;
    let of_a_chip = compared.detected_rate_cps * 8e-9 / 8.0;
    for (name, groups) in [("parallel 16", 16.0), ("parallel 16, near the peak", 1.0)] {
        let differing = |point: &ArchitecturePoint| {
            let chips = point.measuring_time_s / 8e-9 / groups;
            chips * edges * of_a_chip
        };
        let all = points(&compared, name, EstimatorKind::Fft);
        let fits = points(&compared, name, EstimatorKind::Model);
        let enough = |point: &&&ArchitecturePoint| differing(point) > 50.0;
        assert!(fits.iter().all(|fit| differing(fit) > 50.0 * 0.9), "{name}");
        assert_eq!(fits.len(), all.iter().filter(enough).count(), "{name}");
        assert!(!fits.is_empty() && fits.len() < all.len(), "{name}");
        let way = compared.ways.iter().find(|way| way.name == name).expect("there is one");
        let told = |remark: &String| remark.contains("differences of neighbouring phase steps");
        assert!(way.remarks.iter().any(told), "{:?}", way.remarks);
    }
}

/// The same ratio, of photons: 16 steps of 8,942 chips against 280 code periods.
#[test]
fn photons_say_so_too() {
    let scans = repeated(120, 250);
    let measured = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene(8e6, ALL_TIMES);
        scene.estimator = EstimatorKind::Model;
        change(&mut scene);
        let said =
            Sensor::new(&scene).simulate(Tier::Sampled.scans(scans).seeded(3)).expect("it does");
        let path = &said.estimates[0];
        assert_eq!(path.estimates, scans, "{:?}", path.remark);
        [path.std_m, path.std_std_error_m].map(|value| value.expect("some"))
    };
    let [steps, steps_error] = measured(&|scene| {
        // The delay and the sampling's 2.75 ns are 24 steps.
        scene.scan.first_step = 24 - 8;
        scene.scan.steps = 16;
        scene.scan.integration_chips = 280 * 511 / 16;
    });
    let [histogram, histogram_error] = measured(&|scene| {
        scene.hardware.architecture = Architecture::Histogram;
        scene.scan.integration_chips = 280 * 511;
    });
    let ratio = steps / histogram;
    let error = ratio * (steps_error / steps).hypot(histogram_error / histogram);
    println!("{:.2} mm, {:.2} mm: {ratio:.2} +- {error:.2}", steps * 1e3, histogram * 1e3);
    assert!((ratio - 4.2).abs() < 4.0 * error, "{ratio} +- {error}");
}

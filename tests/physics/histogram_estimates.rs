//! Estimates from histograms against expected ones of a detector stepped through time, and
//! against photons.

use std::path::Path;

use goldtof::Jobs as _;
use goldtof::estimate::fit::{BinFitter, FitError};
use goldtof::estimate::histogram::{Uncorrected, dead_time};
use goldtof::estimate::report::Reporter;
use goldtof::estimate::{delay_error_ps, distance_m};
use goldtof::histogram::Histogram;
use goldtof::histogram::correlation::HistogramCorrelator;
use goldtof::photons::{DetectorModel, Pulse, PulseStream, StepCount};
use goldtof::response::{MeanResponse, SecondMoments};
use goldtof::scan::Sample;
use goldtof::scene::{Architecture, DetectorIndex, EstimatorKind, Scene, load_with};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::histograms;
use optics_support::stepped::Stepped;
use optics_support::{
    Moments, assert_within_standard_errors, gold_5, gold_9, repeated, table_i_scene,
};

const STEP_PS: f64 = 25.0;
const DELAY_PS: f64 = 21_350.0;
const FIRST: DetectorIndex = DetectorIndex(0);

/// Table I's sensor with a histogram over so many code periods.
fn scene(primary_cps: f64, periods: u64) -> Scene {
    let mut scene = table_i_scene(gold_9(), primary_cps, 511 * periods);
    scene.paths[0].delay_ps = DELAY_PS;
    scene.hardware.architecture = Architecture::Histogram;
    scene
}

fn made(scene: &Scene, tier: Tier, seed: u64, repetitions: u64) -> Vec<Histogram> {
    let mut made = Vec::new();
    let keep = |histogram| made.push(histogram);
    histograms(&Sensor::new(scene), FIRST, tier, seed, repetitions, keep).expect("the tier does");
    made
}

/// The sign of each rising edge looked up for each phase step: what the up/down sensor
/// counts over the same code periods.
#[test]
fn every_phase_step_counts_what_the_up_down_sensor_would() {
    let scene = scene(8e6, 28);
    let model = DetectorModel::new(&Sensor::new(&scene), FIRST);
    let mut pulses = Vec::new();
    PulseStream::new(&model, 5, 0).advance(Sample(28 * 4_088), &mut pulses);
    assert!(pulses.len() > 600);
    let chips = &scene.sources[0].code.chips;
    let expected: Vec<i64> = (0..4_088)
        .map(|k: i64| {
            let sign = |pulse: &Pulse| {
                let chip = (pulse.first.0 as i64 - k).div_euclid(8).rem_euclid(511);
                2 * i64::from(chips[chip as usize]) - 1
            };
            pulses.iter().map(sign).sum()
        })
        .collect();
    let [sampled] = &made(&scene, Tier::Sampled, 5, 1)[..] else {
        panic!("one histogram");
    };
    assert_eq!(sampled.total(), pulses.len() as u64);
    assert_eq!(HistogramCorrelator::new(&gold_9(), 8).signed_counts(sampled), expected);
    // Pulses of 7 ns never merge after a dead time of 14 ns. What the window's rims cut is in
    // the bin of the period's first sample.
    let [of_events] = &made(&scene, Tier::Events, 5, 1)[..] else {
        panic!("one histogram");
    };
    assert_eq!(of_events.bins()[1..], sampled.bins()[1..]);
}

/// Covariances of bins at all distances, as those of sums of two bins and of all bins with
/// signs.
#[test]
fn bins_go_together_as_photons_do() {
    let mut scene = table_i_scene(gold_5(), 40e6, 31 * 40);
    scene.hardware.architecture = Architecture::Histogram;
    let model = DetectorModel::new(&Sensor::new(&scene), FIRST);
    let response = MeanResponse::new(&model).expect("it is solved");
    let second = SecondMoments::new(&response).expect("it is solved");
    let means = response.mean_bins();
    let mut sums: Vec<Vec<f64>> = [1, 2, 5, 14, 15, 20]
        .iter()
        .map(|distance| {
            let mut sum = vec![0.0; means.len()];
            sum[100] = 1.0;
            sum[100 + distance] = 1.0;
            sum
        })
        .collect();
    let with_signs = |stride: usize, bins: usize| -> Vec<f64> {
        let weight = |bin: usize| match bin < bins {
            true => [-1.0, 1.0][bin / stride % 2],
            false => 0.0,
        };
        (0..means.len()).map(weight).collect()
    };
    // Drawn first bins do not follow the same histogram's last ones.
    for bins in [means.len(), means.len() - 60] {
        sums.extend([23, 31, 62].map(|stride| with_signs(stride, bins)));
    }
    let covariance = second.covariance_of_bin_sums(&sums);
    let number = repeated(16_000, 40_000);
    let photons = made(&scene, Tier::Sampled, 3, number);
    let drawn = made(&scene, Tier::Counts, 3, number);
    for (tier, histograms) in [("photons", photons), ("drawn", drawn)] {
        for (number, sum) in sums.iter().enumerate() {
            if tier == "drawn" && (6..9).contains(&number) {
                continue;
            }
            let counted = |histogram: &Histogram| -> f64 {
                let pairs = histogram.bins().iter().zip(sum);
                pairs.map(|(&count, weight)| count as f64 * weight).sum()
            };
            let moments = Moments::of(histograms.iter().map(counted));
            let mean: f64 = means.iter().zip(sum).map(|(mean, weight)| mean * weight).sum();
            let what = format!("{tier} {number}");
            assert_within_standard_errors(moments.z(mean), 4.0, &format!("mean {what}"));
            let z = moments.variance_z(covariance[number][number]);
            assert_within_standard_errors(z, 4.0, &format!("variance {what}"));
            if (6..9).contains(&number) {
                // Bins that did not go together would be more than five standard errors off.
                let poisson: f64 = means.iter().zip(sum).map(|(mean, w)| mean * w * w).sum();
                assert!(moments.variance_z(poisson).abs() > 5.0, "{what}");
            }
        }
    }
}

/// Drawn bins fit as photons do: bias, scatter and chi-square.
#[test]
fn drawn_bins_fit_as_those_of_photons() {
    let mut scene = scene(8e6, 280);
    scene.estimator = EstimatorKind::Model;
    let said =
        Sensor::new(&scene).simulate(Tier::Counts.scans(repeated(120, 300))).expect("it does");
    let path = &said.estimates[0];
    let bound = path.bound_m.expect("there is one");
    let [std, std_error] = [path.std_m, path.std_std_error_m].map(|m| m.expect("some"));
    assert_within_standard_errors((std - bound) / std_error, 4.0, "std");
    let [bias, error] = [path.bias_m, path.bias_std_error_m].map(|m| m.expect("some"));
    assert_within_standard_errors(bias / error, 4.0, "bias");
    assert_eq!(path.chi_square_alarm_fraction, Some(0.0));
}

/// Thirty periods of a short code: the phase is up to a chip off, and from there a fit may settle
/// in a wrong place, or nowhere. 1 to 2 % of the scans did, some of them by half a metre.
#[test]
fn few_periods_are_fitted_from_more_than_one_start() {
    let mut scene = table_i_scene(gold_5(), 64e6, 31 * 30);
    scene.paths[0].delay_ps = 77_300.0;
    scene.hardware.architecture = Architecture::Histogram;
    scene.estimator = EstimatorKind::Model;
    let said = Sensor::new(&scene).simulate(Tier::Events.scans(120)).expect("it does");
    let path = &said.estimates[0];
    let [std, bound] = [path.std_m, path.bound_m].map(|m| m.expect("some"));
    assert_eq!(path.estimates, 120);
    assert!(std < 1.25 * bound, "{std} {bound}");
}

/// However few the periods: the total of the corrected light is that of the expected
/// histogram's, and nearly that of the scene.
#[test]
fn the_corrected_light_has_no_bias() {
    for (primary_cps, periods, repetitions) in [(8e6, 7, 400), (60e6, 70, 100), (31e6, 12, 400)] {
        let scene = scene(primary_cps, periods);
        let detector = dead_time(&Sensor::new(&scene), FIRST).expect("it can be taken out");
        let lights = made(&scene, Tier::Events, 7, repetitions).into_iter().map(|histogram| {
            let light = detector.correct(&histogram).expect("it is of this detector");
            light.per_period.iter().sum::<f64>()
        });
        let moments = Moments::of(lights);
        let bins = Stepped::new(&scene, STEP_PS).hits_per_sample();
        let light = detector.correct_means(&bins, 1.0).expect("it is of this detector");
        let expected = light.per_period.iter().sum::<f64>();
        let of_scene = (primary_cps + 71e3) * 511.0 * 8e-9;
        assert!((expected / of_scene - 1.0).abs() < 0.01, "{primary_cps}: {expected}");
        // A detection that blinded the detector for itself would be 1 / (2 x periods) of it.
        let off = moments.mean / expected - 1.0;
        let allowed = 4.0 * moments.standard_error() / expected + 1.5e-3;
        assert!(off.abs() < allowed, "{primary_cps} over {periods}: {off}");
    }
}

#[test]
fn the_phase_of_corrected_light_is_what_theory_expects() {
    let repetitions = repeated(400, 1_000);
    for (primary_cps, periods) in [(8e6, 112), (60e6, 280)] {
        let scene = scene(primary_cps, periods);
        let said = Sensor::new(&scene).simulate(Tier::Events.scans(repetitions)).expect("it does");
        let path = &said.estimates[0];
        assert_eq!(path.estimates, repetitions, "{:?}", path.remark);
        let [bias, expected] = [path.bias_m, path.expected_bias_m].map(|m| 1e3 * m.expect("some"));
        let error = 1e3 * path.bias_std_error_m.expect("there is one");
        assert!((bias - expected).abs() < 4.0 * error + 0.2, "{bias} {expected} {error}");
        assert!(expected.abs() < 1.6, "walk and circular error together: {expected} mm");
        let [std, expected] = [path.std_m, path.expected_std_m].map(|m| 1e3 * m.expect("some"));
        let error = 1e3 * path.std_std_error_m.expect("there is one");
        assert!((std - expected).abs() < 4.0 * error + 0.03 * std, "{std} {expected} {error}");
    }
}

#[test]
fn the_fit_to_bins_has_no_walk() {
    for (primary_cps, detected_mcps) in [(0.8e6, 0.99), (8e6, 8.06), (31e6, 22.3), (170e6, 45.8)] {
        let scene = scene(primary_cps, 400_000);
        let stepped = Stepped::new(&scene, STEP_PS);
        assert!((stepped.detection_rate_hz() / 1e6 / detected_mcps - 1.0).abs() < 0.01);
        let bins: Vec<f64> = stepped.hits_per_sample().iter().map(|hits| hits * 4e5).collect();
        let sensor = Sensor::new(&scene);
        let fitter = BinFitter::new(&sensor, FIRST).expect("it is one path");
        let fitted = fitter.fit_means(&bins).expect("it settles");
        let error_ps = delay_error_ps(fitted.delay_ps, DELAY_PS, 511.0 * 8e3);
        let error_mm = 1e3 * distance_m(error_ps);
        assert!(error_mm.abs() < 0.01, "{primary_cps}: {error_mm} mm");
        // Chi-square of expected bins is what the two solutions differ by.
        assert!(fitted.chi_square < 0.01 * fitted.degrees_of_freedom as f64);
    }
}

#[test]
fn the_fit_to_bins_scatters_as_the_bound_says() {
    let mut scene = scene(8e6, 280);
    scene.estimator = EstimatorKind::Model;
    let scans = repeated(100, 200);
    let said = Sensor::new(&scene).simulate(Tier::Sampled.scans(scans)).expect("it does");
    let path = &said.estimates[0];
    assert_eq!(path.estimates, scans, "{:?}", path.remark);
    let bound = path.bound_m.expect("there is one");
    let [std, error] = [path.std_m, path.std_std_error_m].map(|m| m.expect("some"));
    assert!((std / bound - 1.0).abs() < 4.0 * error / bound, "{std} {bound}");
    let [bias, error] = [path.bias_m, path.bias_std_error_m].map(|m| m.expect("some"));
    assert!(bias.abs() < 4.0 * error, "{bias} {error}");
    assert_eq!(path.chi_square_alarm_fraction, Some(0.0));
}

/// Seven periods of bright light: bins for which the detector seems to have been blind in all of them count by jitter alone.
/// As if that were next to impossible, fits scattered nearly twice as far.
#[test]
fn fits_to_few_periods_of_bright_light_scatter_as_the_bound_says() {
    let settings = ["source.mean_power=60 pW", "estimate.estimator=model"];
    let settings = settings.map(|text| text.parse().expect("a setting"));
    let scene = load_with(Path::new("scenes/histogram.toml"), &settings).expect("it is sound");
    let scans = repeated(60, 300);
    let said = Sensor::new(&scene).simulate(Tier::Sampled.scans(scans)).expect("it does");
    let path = &said.estimates[0];
    assert_eq!(path.estimates, scans, "{:?}", path.remark);
    let [std, bound] = [path.std_m, path.bound_m].map(|m| m.expect("some"));
    // Standard error of 60 scans: 9 %.
    assert!((0.65..1.35).contains(&(std / bound)), "{std} {bound}");
}

#[test]
fn what_histograms_do_not_show_is_said() {
    let of = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene(8e6, 28);
        change(&mut scene);
        Sensor::new(&scene)
    };
    let short = of(&|scene| scene.detectors[0].pulse_width_ps = 500.0);
    let merging = of(&|scene| scene.detectors[0].dead_time_ps = 7_500.0);
    assert!(matches!(dead_time(&short, FIRST), Err(Uncorrected::PulsesMissed { .. })));
    assert!(matches!(dead_time(&merging, FIRST), Err(Uncorrected::PulsesMerge { .. })));
    assert!(matches!(BinFitter::new(&short, FIRST), Err(FitError::Uncorrected(_))));
    let two = of(&|scene| {
        let mut path = scene.paths[0].clone();
        path.delay_ps += 20e3;
        scene.paths.push(path);
    });
    let refused = BinFitter::new(&two, FIRST).map(|_| ());
    assert_eq!(refused, Err(FitError::NotOnePath { paths: 2, own: 2 }));
    // Drawn bins do not go together round the end of a code period: of 31 chips that is
    // said, of 511 it is nothing.
    let mut scene_of_31 = table_i_scene(gold_5(), 8e6, 31 * 40);
    scene_of_31.hardware.architecture = Architecture::Histogram;
    let told = |sensor: &Sensor, tier: Tier| {
        let said = sensor.simulate(tier.scans(2)).expect("it does");
        let is_it = |warning: &String| warning.contains("of the code period: drawn first bins");
        said.warnings.iter().any(is_it)
    };
    let of_31 = Sensor::new(&scene_of_31);
    assert!(told(&of_31, Tier::Counts) && !told(&of_31, Tier::Sampled));
    assert!(!told(&of(&|_| ()), Tier::Counts));
    // The phase goes without the correction, and says so.
    let said = merging.simulate(Tier::Sampled.scans(2)).expect("it does");
    assert!(said.warnings.iter().any(|warning| warning.contains("range walk is left in")));
    let refused = histograms(&short, FIRST, Tier::Counts, 1, 1, |_| ()).expect_err("it draws none");
    assert!(refused.to_string().contains("between two samples"), "{refused}");
}

/// A histogram has a report like a scan's; the counts of its phase steps alone keep the walk,
/// and say so.
#[test]
fn a_report_says_what_the_bins_say() {
    let mut scene = scene(60e6, 2_800);
    let [histogram] = &made(&scene, Tier::Sampled, 9, 1)[..] else {
        panic!("one histogram");
    };
    for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
        scene.estimator = estimator;
        let report = Reporter::new(&Sensor::new(&scene), FIRST).histogram(histogram);
        assert!(report.error_m.expect("there is one").abs() < 10e-3);
        assert!(report.deviation_in_std.expect("there is one").abs() < 4.0);
        assert_eq!(report.fit.is_some(), estimator == EstimatorKind::Model);
    }
    let total = histogram.total();
    let signed = HistogramCorrelator::new(&gold_9(), 8).signed_counts(histogram).into_iter();
    let counts: Vec<StepCount> = signed.map(|signed| StepCount { signed, total }).collect();
    scene.estimator = EstimatorKind::Fft;
    let report = Reporter::new(&Sensor::new(&scene), FIRST).scan(&counts);
    assert!((report.error_m.expect("there is one") + 155e-3).abs() < 10e-3);
    assert!(report.deviation_in_std.expect("there is one").abs() < 4.0);
    assert!(report.remark.expect("one").contains("range walk is left in"));
    scene.estimator = EstimatorKind::Model;
    let report = Reporter::new(&Sensor::new(&scene), FIRST).scan(&counts);
    assert_eq!(report.distance_m, None);
    assert!(report.remark.expect("one").contains("bins of the histogram do not follow"));
}

/// A dead time shorter than a sample lets two detections into one, of which the hardware sees one
/// rising edge: the tier that counts detections says so, and the tier of sampled pulses counts on.
#[test]
fn detections_that_share_a_sample_are_refused_where_each_counts() {
    let mut scene = scene(400e6, 1);
    scene.detectors[0].dead_time_ps = 300.0;
    scene.detectors[0].pulse_width_ps = 150.0;
    let of = |tier: Tier| histograms(&Sensor::new(&scene), FIRST, tier, 1, 4, |_| ());
    let error = of(Tier::Events).expect_err("two in a sample of 1 ns").to_string();
    assert!(error.contains("of 1 code periods"), "{error}");
    assert!(error.contains("take --fidelity sampled"), "{error}");
    of(Tier::Sampled).expect("one rising edge a sample");
}

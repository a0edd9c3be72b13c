//! Pulses as sampled hardware sees them: those between two samples leave no trace,
//! and those without a low sample between them are one rising edge. Means, variances
//! and covariance of the counts against simulated photons, painted sample by sample.

use goldtof::Jobs as _;
use goldtof::estimate::estimator::Estimator;
use goldtof::estimate::fit::{Fitter, OtherLight};
use goldtof::estimate::{bound::bound, calibration_offset_ps, distance_m, estimate, predict};
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::response::{
    CountMoments, CountingTier, MeanResponse, MeanResponseError, SecondMoments,
};
use goldtof::scan::{Sampler, Step};
use goldtof::scene::{DetectorIndex, EstimatorKind, PathIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use optics_support::sequential::Scatter;
use optics_support::{
    Moments, assert_within_standard_errors, full_scan, gold_5, painted_counts, table_i_scene,
};

/// Holds what the mean response of the sampled hardware says against photons.
fn compare(name: &str, scene: &Scene, scans: u64) {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let response = MeanResponse::new(&model).expect("it can be solved");
    let second = SecondMoments::new(&response).expect("it can be solved");
    let expected: Vec<CountMoments> =
        Step::all(scene.scan.steps).map(|s| second.of_step(s)).collect();

    let period = scene.sources[0].code.len() as usize * scene.samples_per_chip as usize;
    let mut hits = vec![0.0; period];
    let counts: Vec<Vec<[f64; 2]>> =
        (0..scans).map(|seed| painted_counts(scene, &model, seed, &mut hits)).collect();

    let chips = scene.scan.steps * scene.scan.integration_chips * scans;
    let periods = chips as f64 / scene.sources[0].code.len() as f64;
    let means: Vec<f64> = response.hits_per_sample().iter().map(|h| h * periods).collect();
    let total: f64 = means.iter().sum();
    // Hits of one sample are rare and nearly Poisson. Samples that hardly ever see
    // one are left to the sums below.
    let seen = hits.iter().zip(&means).filter(|(_, mean)| **mean > 20.0);
    let squares: Vec<f64> = seen.map(|(found, mean)| (found - mean).powi(2) / mean).collect();
    let number = squares.len() as f64;
    let chi_square = (squares.iter().sum::<f64>() - number) / (2.0 * number).sqrt();
    let found: f64 = hits.iter().sum();
    eprintln!(
        "{name}: {:.4} hits a chip; hits' chi-square {chi_square:+.2}, total {:+.2}",
        total / chips as f64,
        (found - total) / total.sqrt()
    );
    assert_within_standard_errors(chi_square, 5.0, &format!("{name}: hits by sample"));

    let mut sums = [0.0; 2];
    let mut ratios = [Vec::new(), Vec::new(), Vec::new()];
    for (step, expected) in expected.iter().enumerate() {
        let of = |f: &dyn Fn([f64; 2]) -> f64| Moments::of(counts.iter().map(|scan| f(scan[step])));
        let (signed, total) = (of(&|c| c[0]), of(&|c| c[1]));
        let both = of(&|c| c[0] + c[1]);
        let of_mean = |found: &Moments, mean: f64, variance: f64| {
            (found.mean - mean) / (variance / scans as f64).sqrt()
        };
        sums[0] += of_mean(&signed, expected.signed_mean, expected.signed_variance).powi(2);
        sums[1] += of_mean(&total, expected.total_mean, expected.total_variance);
        let variance_of_both =
            expected.signed_variance + expected.total_variance + 2.0 * expected.covariance;
        ratios[0].push(signed.variance / expected.signed_variance);
        ratios[1].push(total.variance / expected.total_variance);
        ratios[2].push(both.variance / variance_of_both);
    }
    let steps = scene.scan.steps as f64;
    let chi_square = (sums[0] - steps) / (2.0 * steps).sqrt();
    assert_within_standard_errors(chi_square, 5.0, &format!("{name}: signed counts"));
    let z = sums[1] / steps.sqrt();
    assert_within_standard_errors(z, 5.0, &format!("{name}: total counts"));
    for (ratio, what) in ratios.into_iter().zip(["signed", "total", "sum"]) {
        let ratio = Moments::of(ratio);
        eprintln!("   {what}: variance x {:.4} ({:+.2})", ratio.mean, ratio.z(1.0));
        assert_within_standard_errors(ratio.z(1.0), 5.0, &format!("{name}: variance, {what}"));
    }
    let all = second.of_scan();
    for (step, (one, all)) in expected.iter().zip(&all).enumerate() {
        for (one, all) in [
            (one.signed_variance, all.signed_variance),
            (one.total_variance, all.total_variance),
            (one.covariance + one.total_mean, all.covariance + one.total_mean),
        ] {
            assert!((all / one - 1.0).abs() < 0.02, "{name} {step}: {one} {all}");
        }
    }
}

/// Long beside a pulse: each simulated step has light of its own, so that a pulse of the
/// step before may cover a first one that has nothing to do with it.
const STEP_CHIPS: u64 = 1_503;

struct Case {
    samples_per_chip: u32,
    pulse_width_ps: f64,
    dead_time_ps: f64,
    rate_cps: f64,
    time_constant_ps: f64,
    jitter_ps: f64,
    /// Of the samples' bins, in sample periods; none for samples that are equally far apart.
    widths: &'static [f64],
}

impl Case {
    fn scene(&self) -> Scene {
        let mut scene = table_i_scene(gold_5(), self.rate_cps, STEP_CHIPS);
        scene.samples_per_chip = self.samples_per_chip;
        scene.scan = full_scan(self.samples_per_chip, &scene.sources[0].code, STEP_CHIPS);
        let spad = &mut scene.detectors[0];
        spad.pulse_width_ps = self.pulse_width_ps;
        spad.dead_time_ps = self.dead_time_ps;
        spad.afterpulsing_time_constant_ps = self.time_constant_ps;
        if self.time_constant_ps == 0.0 {
            spad.afterpulsing_probability = 0.0;
        }
        spad.jitter_ps = vec![self.jitter_ps];
        if !self.widths.is_empty() {
            spad.sampler = Sampler::of_widths(self.widths);
        }
        scene
    }

    fn compare(&self, name: &str) {
        // As many steps in all, however many samples a chip has.
        compare(name, &self.scene(), 128 / u64::from(self.samples_per_chip));
    }
}

const TABLE_I: Case = Case {
    samples_per_chip: 8,
    pulse_width_ps: 7e3,
    dead_time_ps: 14e3,
    rate_cps: 40e6,
    time_constant_ps: 5e3,
    jitter_ps: 53.6,
    widths: &[],
};

#[test]
fn pulses_between_two_samples_do_not_count() {
    for (name, case) in [
        ("half a sample", Case { pulse_width_ps: 500.0, ..TABLE_I }),
        ("a tenth", Case { pulse_width_ps: 100.0, jitter_ps: 0.0, ..TABLE_I }),
        ("wide jitter", Case { pulse_width_ps: 300.0, jitter_ps: 900.0, ..TABLE_I }),
        ("a sample", Case { pulse_width_ps: 1000.0, ..TABLE_I }),
        ("2 samples", Case { samples_per_chip: 2, pulse_width_ps: 2_700.0, ..TABLE_I }),
        ("16 samples", Case { samples_per_chip: 16, pulse_width_ps: 210.0, ..TABLE_I }),
        (
            "fast afterpulses",
            Case {
                pulse_width_ps: 400.0,
                dead_time_ps: 3_370.0,
                time_constant_ps: 150.0,
                ..TABLE_I
            },
        ),
    ] {
        case.compare(name);
    }
}

#[test]
fn pulses_without_a_low_sample_between_them_count_once() {
    for (name, case) in [
        ("as long as the dead time", Case { pulse_width_ps: 14e3, ..TABLE_I }),
        ("half a sample less", Case { pulse_width_ps: 13.6e3, ..TABLE_I }),
        ("longer", Case { pulse_width_ps: 16.3e3, ..TABLE_I }),
        ("much longer", Case { pulse_width_ps: 39.7e3, rate_cps: 20e6, ..TABLE_I }),
        (
            "a short dead time",
            Case { pulse_width_ps: 3e3, dead_time_ps: 2.9e3, jitter_ps: 0.0, ..TABLE_I },
        ),
        (
            "a dead time within a sample",
            Case {
                pulse_width_ps: 1.3e3,
                dead_time_ps: 0.7e3,
                rate_cps: 20e6,
                jitter_ps: 0.0,
                ..TABLE_I
            },
        ),
        (
            "fast afterpulses",
            Case { pulse_width_ps: 5.2e3, dead_time_ps: 5.3e3, time_constant_ps: 400.0, ..TABLE_I },
        ),
        (
            "no afterpulses",
            Case { pulse_width_ps: 14e3, rate_cps: 150e6, time_constant_ps: 0.0, ..TABLE_I },
        ),
        ("one sample", Case { samples_per_chip: 1, ..TABLE_I }),
        ("two samples", Case { samples_per_chip: 2, pulse_width_ps: 13e3, ..TABLE_I }),
        ("16 samples", Case { samples_per_chip: 16, pulse_width_ps: 14e3, ..TABLE_I }),
        (
            "no dead time",
            Case { dead_time_ps: 0.0, pulse_width_ps: 2.3e3, time_constant_ps: 0.0, ..TABLE_I },
        ),
        (
            "no dead time, short pulses",
            Case {
                dead_time_ps: 0.0,
                pulse_width_ps: 700.0,
                rate_cps: 150e6,
                time_constant_ps: 0.0,
                ..TABLE_I
            },
        ),
        ("jitter", Case { pulse_width_ps: 14e3, jitter_ps: 240.0, ..TABLE_I }),
    ] {
        case.compare(name);
    }
}

/// A second pin that is late by 0.3 of a sample, and bins of a delay line.
const SECOND_PIN: &[f64] = &[0.7, 1.3, 0.7, 1.3, 0.7, 1.3, 0.7, 1.3];
const DELAY_LINE: &[f64] = &[1.9, 0.4, 1.1, 0.6, 1.45, 0.25, 1.3, 1.0];
const DELAY_LINE_OF_16: &[f64] =
    &[1.9, 0.4, 1.1, 0.6, 1.45, 0.25, 1.3, 1.0, 0.8, 1.2, 0.5, 1.5, 1.0, 1.6, 0.3, 1.1];

#[test]
fn samples_that_are_not_equally_far_apart_count_as_expected() {
    let delay_line = Case { widths: DELAY_LINE, ..TABLE_I };
    for (name, case) in [
        ("a second pin", Case { widths: SECOND_PIN, ..TABLE_I }),
        ("a delay line", Case { ..delay_line }),
        ("16 samples", Case { samples_per_chip: 16, widths: DELAY_LINE_OF_16, ..TABLE_I }),
        ("pulses of half a sample", Case { pulse_width_ps: 500.0, ..delay_line }),
        ("pulses of a sample and a half", Case { pulse_width_ps: 1_500.0, ..delay_line }),
        ("merging", Case { pulse_width_ps: 14e3, ..delay_line }),
        ("merging for long", Case { pulse_width_ps: 17.3e3, ..delay_line }),
        (
            "merging after a short dead time",
            Case { pulse_width_ps: 3e3, dead_time_ps: 2.9e3, jitter_ps: 0.0, ..delay_line },
        ),
        (
            "no dead time, short pulses",
            Case {
                dead_time_ps: 0.0,
                pulse_width_ps: 700.0,
                rate_cps: 150e6,
                time_constant_ps: 0.0,
                ..delay_line
            },
        ),
    ] {
        case.compare(name);
    }
}

/// Where merging is not worked out there is no response, and nothing that follows from
/// one; the counter in continuous time has no samples, and no such limits.
#[test]
fn what_is_not_worked_out_is_refused_by_name() {
    for (case, words) in [
        (Case { pulse_width_ps: 14e3, jitter_ps: 300.0, ..TABLE_I }, "jitter of more than"),
        (
            Case { pulse_width_ps: 500.0, dead_time_ps: 800.0, ..TABLE_I },
            "both shorter than a sample",
        ),
        (Case { pulse_width_ps: 90e3, ..TABLE_I }, "more than 60 samples longer"),
    ] {
        let mut scene = case.scene();
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let refused = MeanResponse::new(&model).expect_err(words);
        assert!(matches!(refused, MeanResponseError::PulsesMerge { .. }), "{refused}");
        assert!(refused.to_string().contains(words), "{refused}");
        assert!(MeanResponse::of_tier(&model, CountingTier::Events).is_ok());
        assert!(bound(&Sensor::new(&scene), DetectorIndex(0), CountingTier::Sampled).is_err());
        for tier in [Tier::Expected, Tier::Counts] {
            assert!(Sensor::new(&scene).simulate(tier.scans(2)).is_err(), "{tier}");
        }
        for estimator in [EstimatorKind::Fft, EstimatorKind::Model] {
            scene.estimator = estimator;
            scene.scan.integration_chips = 310;
            let of_path =
                &Sensor::new(&scene).simulate(Tier::Sampled.scans(2)).expect("photons").estimates
                    [0];
            assert_eq!(of_path.expected_bias_m, None);
            assert_eq!(of_path.expected_std_m, None);
            assert_eq!(of_path.bound_m, None);
            let remark = of_path.remark.as_deref().unwrap_or_default();
            assert!(remark.contains("no expectation") && remark.contains(words), "{remark}");
        }
    }
}

/// Errors of many scans, phase and fit, beside what is expected of them.
fn assert_errors_are_as_expected(name: &str, scene: &Scene) {
    let sensor = Sensor::new(scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    let tier = CountingTier::Sampled;
    let fitter = Fitter::new(&sensor, DetectorIndex(0), tier, OtherLight::Given);
    let offset_ps = calibration_offset_ps(&sensor, DetectorIndex(0), tier);
    let true_distance_m = distance_m(scene.paths[0].delay_ps);
    let predicted =
        predict(&sensor, DetectorIndex(0), PathIndex(0), tier).expect("it can be predicted");
    let fitted = Estimator::new(&sensor, DetectorIndex(0), tier).expected_fit().expect("it fits");
    let bound_m = bound(&sensor, DetectorIndex(0), tier).expect("a bound").paths[0].bound_m;
    let fit_bias_m = fitted.distance_m - true_distance_m;
    assert!(fit_bias_m.abs() < 1e-4 && fitted.std_m > 0.9 * bound_m, "{name}: {fitted:?}");
    let [mut phases, mut fits] = [(); 2].map(|()| Scatter::new(1.35, 0.6, 0.05));
    let mut seed = 0;
    while phases.is_open() || fits.is_open() {
        seed += 1;
        let counts = painted_counts(scene, &model, 1_000 + seed, &mut [0.0]);
        let signed: Vec<i64> = counts.iter().map(|count| count[0] as i64).collect();
        let phase = estimate(&scene.timing(), &signed, offset_ps).expect("a peak");
        let error_m = phase.distance_m - true_distance_m;
        phases.take((error_m - predicted.bias_m) / predicted.std_m);
        let counts: Vec<StepCount> = counts
            .iter()
            .map(|count| StepCount { signed: count[0] as i64, total: count[1] as u64 })
            .collect();
        let error_m = fitter.fit(&counts).expect("it fits").distance_m - true_distance_m;
        fits.take((error_m - fit_bias_m) / fitted.std_m);
    }
    phases.assert_holds(&format!("{name}, phase"));
    fits.assert_holds(&format!("{name}, fit"));
}

#[test]
fn estimates_err_and_scatter_as_expected_of_the_sampled_hardware() {
    for (name, case) in [
        ("half a sample", Case { pulse_width_ps: 500.0, jitter_ps: 300.0, ..TABLE_I }),
        ("merging", Case { pulse_width_ps: 14e3, ..TABLE_I }),
        ("merging for long", Case { pulse_width_ps: 18e3, ..TABLE_I }),
        ("a delay line", Case { widths: DELAY_LINE, ..TABLE_I }),
    ] {
        assert_errors_are_as_expected(name, &case.scene());
    }
}

/// Light that comes between two samples: its delay hardly changes the counts.
#[test]
fn there_is_no_bound_between_two_samples() {
    let mut scene = Case { pulse_width_ps: 400.0, jitter_ps: 20.0, ..TABLE_I }.scene();
    let spad_ps = scene.detectors[0].delay_ps;
    // Pulses are seen from 0.6 to 1 ns after a sample.
    scene.paths[0].delay_ps = 21_300.0 - spad_ps;
    let refused = bound(&Sensor::new(&scene), DetectorIndex(0), CountingTier::Sampled)
        .map(|bound| bound.paths[0].bound_m);
    assert!(refused.is_err(), "{refused:?}");
    let sensor = Sensor::new(&scene);
    let estimator = Estimator::new(&sensor, DetectorIndex(0), CountingTier::Sampled);
    assert!(estimator.expected_fit().is_err());
    scene.paths[0].delay_ps = 21_800.0 - spad_ps;
    bound(&Sensor::new(&scene), DetectorIndex(0), CountingTier::Sampled)
        .expect("within what is seen there is one");
}

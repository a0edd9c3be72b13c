//! Samples that are not equally far apart: both photon engines against a level that is looked at
//! instant by instant, expected counts against another simulator and a detector stepped through time,
//! and what a second pin's error costs against its closed form.

use std::sync::Arc;

use goldtof::estimate::fit::{OtherLight, fit_means};
use goldtof::estimate::{calibration_offset_ps, distance_m, estimate};
use goldtof::photons::fast::Recorder;
use goldtof::photons::{Detection, DetectorModel, Level, Pulse, PulseStream};
use goldtof::response::{CountingTier, MeanResponse};
use goldtof::scan::{Group, Sample, Sampler};
use goldtof::scene::{DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use optics_support::stepped::Stepped;
use optics_support::{
    Moments, assert_within_standard_errors, gold_5, ideal_scene, naive, table_i_scene,
};
use rand::SeedableRng as _;
use rand::rngs::StdRng;

const TIER: CountingTier = CountingTier::Sampled;
const SPAD: DetectorIndex = DetectorIndex(0);
/// Bins of a chip in sample periods, and the instants that follow from them, in chips.
const WIDTHS: [f64; 8] = [1.75, 0.5, 1.0, 0.625, 1.5, 0.25, 1.375, 1.0];
const INSTANTS: [f64; 8] =
    [0.0, 0.0625, 0.1875, 0.265_625, 0.453_125, 0.484_375, 0.656_25, 0.781_25];

fn uneven(mut scene: Scene) -> Scene {
    scene.detectors[0].sampler = Sampler::of_widths(&WIDTHS);
    scene
}

fn rising_edges(pulses: &[Pulse]) -> Vec<u64> {
    let mut level = Level::default();
    pulses.iter().filter(|pulse| level.rises(pulse)).map(|pulse| pulse.first.0).collect()
}

/// Pulses that fall between samples, those that do not, and those that merge.
#[test]
fn both_engines_see_what_a_level_shows_that_is_looked_at_instant_by_instant() {
    for (width_ps, jitter_ps) in [(375.0, 0.0), (7e3, 60.0), (13.75e3, 900.0)] {
        let mut scene = uneven(table_i_scene(gold_5(), 60e6, 31 * 40));
        scene.scan.steps = 1;
        scene.detectors[0].pulse_width_ps = width_ps;
        scene.detectors[0].jitter_ps = vec![jitter_ps];
        let chips = scene.scan.integration_chips;
        let model = DetectorModel::new(&Sensor::new(&scene), SPAD);
        let looked_at = |detections: Vec<Detection>| {
            let times = detections.iter().map(|time| time.chip as f64 + time.fraction);
            let mut times: Vec<f64> = times.collect();
            times.sort_by(f64::total_cmp);
            naive::rising_edges(&times, width_ps / 8e3, &INSTANTS, chips)
        };
        let sampled = |mut stream: PulseStream| {
            let mut pulses = Vec::new();
            stream.advance(Sample(8 * chips), &mut pulses);
            rising_edges(&pulses)
        };
        let recorder = Arc::new(Recorder::new(&model));
        for scan in 0..20 {
            let plain = sampled(PulseStream::of_plain_loop(&model, 7, scan));
            let expected = looked_at(model.step(7, scan, Group(0)).collect());
            assert_eq!(plain, expected, "{width_ps} {scan}");
            let last = Some(Group(1));
            let lanes = PulseStream::of_groups(&recorder, 7, scan, Group(0), last);
            let recorded = recorder.record(7, &[(scan, Group(0))]).into_iter().flatten();
            let expected = looked_at(recorded.map(|time| time.detection()).collect());
            assert_eq!(sampled(lanes), expected, "lanes: {width_ps} {scan}");
            assert!(expected.len() > 20);
        }
    }
}

/// Photons, afterpulses and samples by other constructions than the product's.
#[test]
fn another_simulator_hits_each_sample_as_often_as_expected() {
    let mut scene = uneven(table_i_scene(gold_5(), 30e6, 31));
    scene.detectors[0].jitter_ps.clear();
    let model = DetectorModel::new(&Sensor::new(&scene), SPAD);
    let expected = MeanResponse::new(&model).expect("it can be solved").hits_per_sample();
    let (runs, periods) = (60, 500);
    let chips = 31 * periods;
    let mut hits = vec![0.0; 31 * 8];
    let mut rng = StdRng::seed_from_u64(11);
    for _ in 0..runs {
        let registered = naive::detections(&scene, 0, &mut rng, chips as f64, 310.0);
        for rise in naive::rising_edges(&registered, 7.0 / 8.0, &INSTANTS, chips) {
            hits[rise as usize % (31 * 8)] += 1.0;
        }
    }
    let mut squares = Vec::new();
    for (sample, (found, expected)) in hits.iter().zip(&expected).enumerate() {
        let mean = expected * (runs * periods) as f64;
        let z = (found - mean) / mean.sqrt();
        assert_within_standard_errors(z, 5.0, &format!("sample {sample}"));
        squares.push(z * z);
    }
    let chi_square = Moments::of(squares);
    // Squares of normal numbers have the variance 2.
    let z = (chi_square.mean - 1.0) / (2.0 / chi_square.count).sqrt();
    assert_within_standard_errors(z, 4.0, "chi-square");
    assert!(hits.iter().sum::<f64>() > 1e5);
}

#[test]
fn expected_hits_are_those_of_a_detector_stepped_through_time() {
    let mut scene = uneven(table_i_scene(gold_5(), 40e6, 310));
    scene.paths[0].delay_ps = 21_350.0;
    let times_ps: Vec<f64> = (-8..31 * 8)
        .skip(7)
        .map(|sample: i64| {
            let chip = sample.div_euclid(8) as f64;
            8e3 * (chip + INSTANTS[sample.rem_euclid(8) as usize])
        })
        .collect();
    let stepped = Stepped::new(&scene, 25.0).hits_between(&times_ps);
    let model = DetectorModel::new(&Sensor::new(&scene), SPAD);
    let response = MeanResponse::new(&model).expect("it can be solved");
    let found = response.hits_per_sample();
    let largest = stepped.iter().copied().fold(0.0, f64::max);
    for (sample, (found, stepped)) in found.iter().zip(&stepped).enumerate() {
        assert!((found - stepped).abs() < 2e-4 * largest, "{sample}: {found} {stepped}");
    }
    // Every phase step counts these with the sign of its sample.
    let chips = &scene.sources[0].code.chips;
    let means = response.mean_counts();
    let peak = means.iter().map(|mean| mean.signed).fold(0.0, f64::max);
    for (k, mean) in means.iter().enumerate() {
        let signed = stepped.iter().enumerate().map(|(sample, hits)| {
            let chip = chips[(sample + 31 * 8 - k) % (31 * 8) / 8];
            10.0 * hits * (2.0 * f64::from(chip) - 1.0)
        });
        let error = mean.signed - signed.sum::<f64>();
        assert!(error.abs() < 5e-4 * peak, "{k}: {error} of {peak}");
    }
}

/// Errors in millimetres of the phase and of the fit to what `true_scene` lets one expect, by a
/// sensor that takes it for `assumed`.
fn errors_mm(true_scene: &Scene, assumed: &Scene) -> [f64; 2] {
    let model = DetectorModel::new(&Sensor::new(true_scene), SPAD);
    let means = MeanResponse::new(&model).expect("it can be solved").mean_counts();
    let sensor = Sensor::new(assumed);
    let offset_ps = calibration_offset_ps(&sensor, SPAD, TIER);
    // Whole counts, so many that rounding does not matter.
    let counts: Vec<i64> = means.iter().map(|mean| (1e6 * mean.signed).round() as i64).collect();
    let phase = estimate(&assumed.timing(), &counts, offset_ps).expect("a peak");
    let fit = fit_means(&sensor, SPAD, TIER, &means, OtherLight::Given).expect("a fit");
    let truth_m = distance_m(true_scene.paths[0].delay_ps);
    [phase.distance_m, fit.distance_m].map(|distance_m| 1e3 * (distance_m - truth_m))
}

/// Light of a chip comes by each sample once, so that the odd ones, late by d, take d / 2 off the
/// mean arrival: c d / 4 are 0.075 mm for each picosecond, on average over the places between two
/// samples of one pin. The phase, which is not quite the mean, is within 6 % of that at each.
#[test]
fn a_second_pin_costs_0_075_mm_a_picosecond_unless_the_scene_has_it() {
    for skew_ps in [-200.0, 10.0, 100.0_f64] {
        let expected_mm = -0.25 * 0.299_792_458 * skew_ps;
        let skew = skew_ps / 1000.0;
        let mut costs_mm = Vec::new();
        for place in 0..8 {
            let mut scene = ideal_scene(gold_5(), 2e6, 31 * 1000);
            scene.paths[0].delay_ps = 21_100.0 + 250.0 * f64::from(place);
            scene.detectors[0].jitter_ps = vec![60.0];
            let mut skewed = scene.clone();
            skewed.detectors[0].sampler = Sampler::of_widths(&[1.0 - skew, 1.0 + skew].repeat(4));
            let [phase, fit] = errors_mm(&skewed, &scene);
            let [even_phase, even_fit] = errors_mm(&scene, &scene);
            println!(
                "{skew_ps} ps, place {place}: {:.3} mm, fit {:.3} mm, for {expected_mm:.3} mm",
                phase - even_phase,
                fit - even_fit
            );
            costs_mm.push(phase - even_phase);
            let off = (phase - even_phase) / expected_mm - 1.0;
            assert!(off.abs() < 0.06, "{skew_ps} {place}: {off:.3}");
            // Of the scene that has it: the fit has settled to a hundredth of its deviation.
            let [phase, fit] = errors_mm(&skewed, &skewed);
            assert!(fit.abs() < 0.02, "{skew_ps} {place}: {fit}");
            let left = (phase - even_phase) / expected_mm;
            assert!(left.abs() < 0.06, "{skew_ps} {place}: {left:.3}");
        }
        let mean = Moments::of(costs_mm).mean;
        assert!((mean / expected_mm - 1.0).abs() < 0.01, "{skew_ps}: {mean} {expected_mm}");
    }
}

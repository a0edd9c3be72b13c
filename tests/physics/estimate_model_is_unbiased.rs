//! The model estimator on expected counts of a detector stepped through time,
//! which shares nothing with the fit: what is left is bias.

use std::sync::Arc;

use goldtof::code::{Code, CodeSpec, Family};
use goldtof::estimate::fit::{Fitter, ModelEstimate, OtherLight, fit_means};
use goldtof::estimate::{
    CountingTier, calibration_offset_ps, delay_error_ps, distance_m, estimate,
};
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::response::MeanCount;
use goldtof::scan::Step;
use goldtof::scene::{DetectorIndex, Path, Scene, Source, SourceIndex};
use goldtof::sensor::Sensor;
use optics_support::stepped::Stepped;
use optics_support::{gold_11, table_i_scene};

const TIER: CountingTier = CountingTier::Events;
const STEP_PS: f64 = 25.0;

fn scan_around(scene: &mut Scene, halfwidth: u64) {
    let peak_ps = scene.paths[0].delay_ps
        + calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), TIER);
    let all = scene.scan.steps_per_period;
    scene.scan.first_step = ((peak_ps / 1000.0).round() as u64 + all - halfwidth) % all;
    scene.scan.steps = 2 * halfwidth;
}

fn error_mm(scene: &Scene, delay_ps: f64) -> f64 {
    let period_ps = scene.scan.steps_per_period as f64 * 1000.0;
    1e3 * distance_m(delay_error_ps(delay_ps, scene.paths[0].delay_ps, period_ps))
}

fn phase_error_mm(scene: &Scene, counts: &[MeanCount]) -> f64 {
    let signed: Vec<i64> = counts.iter().map(|c| c.signed.round() as i64).collect();
    let offset_ps = calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), TIER);
    let found = estimate(&scene.timing(), &signed, offset_ps).expect("a peak");
    error_mm(scene, found.delay_ps)
}

fn fitted(scene: &Scene, counts: &[MeanCount], other: OtherLight) -> ModelEstimate {
    fit_means(&Sensor::new(scene), DetectorIndex(0), TIER, counts, other).expect("it fits")
}

#[test]
fn no_light_level_moves_the_distance() {
    let mut levels = Vec::new();
    // From 1 to 45 million detections per second.
    for rate in [0.8e6, 8e6, 31e6, 170e6] {
        let mut scene = table_i_scene(gold_11(), rate, 2047 * 100_000);
        scene.paths[0].delay_ps = 21_350.0;
        scan_around(&mut scene, 14);
        let stepped = Stepped::new(&scene, STEP_PS);
        levels.push(stepped.detection_rate_hz() / 1e6);
        let counts = stepped.counts();
        let error = error_mm(&scene, fitted(&scene, &counts, OtherLight::None).delay_ps);
        assert!(error.abs() < 0.01, "{rate}: {error} mm");
        let phase = phase_error_mm(&scene, &counts);
        // Dead time makes light look early, the more of it the earlier.
        let per_mcps = phase / levels[levels.len() - 1];
        assert!((-8.0..-1.5).contains(&per_mcps), "{rate}: {phase} mm");
    }
    assert!(levels[0] < 1.05 && levels[3] > 45.0, "{levels:?}");
}

/// Code `index` of the default Gold set of degree 7.
fn gold_7(index: i64) -> Arc<Code> {
    let spec = CodeSpec { degree: Some(7), index: Some(index), ..CodeSpec::new(Family::Gold) };
    Arc::new(spec.build().expect("a code of the set"))
}

#[test]
fn no_part_of_a_phase_step_shows_in_the_distance() {
    for eighth in 0..8 {
        let mut scene = table_i_scene(gold_7(0), 12e6, 127 * 1_000_000);
        scene.paths[0].delay_ps = 64_000.0 + 125.0 * f64::from(eighth);
        scan_around(&mut scene, 14);
        let counts = Stepped::new(&scene, STEP_PS).counts();
        let error = error_mm(&scene, fitted(&scene, &counts, OtherLight::None).delay_ps);
        assert!(error.abs() < 0.01, "{eighth}/8: {error} mm");
    }
}

#[test]
fn an_interferer_at_any_delay_moves_nothing_whether_its_code_is_given_or_found() {
    let mut worst_phase: f64 = 0.0;
    for relative_ps in
        [-30_000.0, -8_000.0, -4_000.0, -25.0, 0.0, 3_000.0, 8_000.0, 12_500.0, 400_075.0]
    {
        let mut scene = table_i_scene(gold_7(0), 6e6, 127 * 2_000);
        scene.paths[0].delay_ps = 200_350.0;
        scene.sources.push(Source {
            name: "other".to_owned(),
            code: gold_7(41),
            ..scene.sources[0].clone()
        });
        scene.paths.push(Path {
            source: SourceIndex(1),
            delay_ps: scene.paths[0].delay_ps + relative_ps,
            ..scene.paths[0].clone()
        });
        let counts = Stepped::new(&scene, STEP_PS).counts();
        for other in [OtherLight::Given, OtherLight::Search] {
            let found = fitted(&scene, &counts, other);
            assert_eq!(found.paths[1].code.chips, scene.sources[1].code.chips);
            let error = error_mm(&scene, found.delay_ps);
            assert!(error.abs() < 0.01, "{other:?} {relative_ps}: {error} mm");
            // The interferer is measured as well.
            let apart_ps = found.paths[1].delay_ps - scene.paths[1].delay_ps;
            assert!(apart_ps.abs() < 0.1, "{relative_ps}: {apart_ps} ps");
        }
        worst_phase = worst_phase.max(phase_error_mm(&scene, &counts).abs());
    }
    assert!(worst_phase > 30.0, "{worst_phase}");
}

fn photons(scene: &Scene, repetition: u64) -> Vec<StepCount> {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    (0..scene.scan.steps).map(|step| count_step(&model, 11, repetition, Step(step))).collect()
}

/// At low light the largest of 1,016 counts is often not the target's; the shape of
/// the peak has the light of 16 counts.
#[test]
fn the_shape_of_the_peak_is_found_where_its_largest_count_is_not() {
    let scene = table_i_scene(gold_7(0), 1.6e6, 127 * 6);
    let sensor = Sensor::new(&scene);
    let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, OtherLight::None);
    let is_off = |delay_ps: f64| error_mm(&scene, delay_ps).abs() > 1e3 * distance_m(8_000.0);
    let offset_ps = calibration_offset_ps(&sensor, DetectorIndex(0), TIER);
    let (mut by_phase, mut by_model) = (0, 0);
    for repetition in 0..100 {
        let counts = photons(&scene, repetition);
        let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
        let phase = estimate(&scene.timing(), &signed, offset_ps);
        by_phase += u32::from(phase.map_or(true, |found| is_off(found.delay_ps)));
        let model = fitter.fit(&counts);
        by_model += u32::from(model.map_or(true, |found| is_off(found.delay_ps)));
    }
    assert!((15..=80).contains(&by_phase), "{by_phase} of 100");
    assert!(2 * by_model < by_phase, "{by_model} against {by_phase}");
}

#[test]
fn what_a_scan_gives_does_not_depend_on_the_scans_before_it() {
    let mut scene = table_i_scene(gold_7(0), 12e6, 127 * 200);
    scan_around(&mut scene, 14);
    let scans: Vec<Vec<StepCount>> = (0..6).map(|number| photons(&scene, number)).collect();
    let sensor = Sensor::new(&scene);
    let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, OtherLight::None);
    let in_order: Vec<f64> =
        scans.iter().map(|counts| fitter.fit(counts).expect("it fits").delay_ps).collect();
    for (counts, delay_ps) in scans.iter().zip(in_order).rev() {
        let alone = Fitter::new(&sensor, DetectorIndex(0), TIER, OtherLight::None);
        assert_eq!(alone.fit(counts).expect("it fits").delay_ps, delay_ps);
    }
}

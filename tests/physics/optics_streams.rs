//! Streams depend on their numbers alone; pulses and counts follow from them.

use goldtof::photons::fast::Recorder;
use goldtof::photons::{Detection, DetectorModel, Pulse, PulseStream, count_step};
use goldtof::scan::{Chip, Group, Sample, Step};
use goldtof::scene::{
    CounterTiming, DetectorIndex, LaserResponse, Path, Scene, Source, SourceClock, SourceIndex,
};
use goldtof::sensor::Sensor;
use optics_support::{
    Moments, assert_within_standard_errors, code, gold_5, ideal_scene, power_w, table_i_scene,
};
use proptest::prelude::*;

fn detections(scene: &Scene, seed: u64, repetition: u64, step: u64) -> Vec<Detection> {
    DetectorModel::new(&Sensor::new(scene), DetectorIndex(0))
        .step(seed, repetition, Group(step))
        .collect()
}

#[test]
fn the_same_numbers_give_the_same_detections_and_others_do_not() {
    let scene = table_i_scene(gold_5(), 20e6, 5_000);
    let first = detections(&scene, 1, 0, 3);
    assert!(first.len() > 300);
    assert_eq!(first, detections(&scene, 1, 0, 3));
    for other in
        [detections(&scene, 2, 0, 3), detections(&scene, 1, 1, 3), detections(&scene, 1, 0, 4)]
    {
        assert_ne!(first, other);
    }
}

#[test]
fn the_order_of_steps_does_not_matter() {
    let scene = table_i_scene(gold_5(), 20e6, 500);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let forwards: Vec<Vec<Detection>> =
        (0..20).map(|j| model.step(1, 0, Group(j)).collect()).collect();
    // Interleaved, one detection of each step at a time.
    let mut side_by_side: Vec<_> = (0..20).rev().map(|j| model.step(1, 0, Group(j))).collect();
    let mut found = vec![Vec::new(); 20];
    loop {
        let mut any = false;
        for (back, step) in side_by_side.iter_mut().enumerate() {
            if let Some(detection) = step.next() {
                found[19 - back].push(detection);
                any = true;
            }
        }
        if !any {
            break;
        }
    }
    assert_eq!(found, forwards);
}

#[test]
fn neutral_parts_change_nothing() {
    let mut plain = table_i_scene(gold_5(), 20e6, 2_000);
    let spad = &mut plain.detectors[0];
    spad.jitter_ps.clear();
    spad.afterpulsing_probability = 0.0;
    spad.afterpulsing_time_constant_ps = 0.0;
    let expected = detections(&plain, 1, 0, 0);

    let mut neutral = plain.clone();
    neutral.detectors[0].jitter_ps = vec![0.0, 0.0];
    neutral.detectors[0].afterpulsing_time_constant_ps = 5e3;
    neutral.sources.push(Source {
        name: "dark".to_owned(),
        code: code(&[1, 0]),
        wavelength_nm: 905.0,
        mean_power_w: 0.0,
        extinction_ratio: 10.0,
        response: LaserResponse::Ideal,
        clock: SourceClock::default(),
    });
    for (source, transmission) in [(1, 1.0), (0, 0.0)] {
        neutral.paths.push(Path {
            source: SourceIndex(source),
            detector: DetectorIndex(0),
            delay_ps: 5e3,
            transmission,
            movement: None,
        });
    }
    assert_eq!(detections(&neutral, 1, 0, 0), expected);
}

#[test]
fn leaving_jitter_out_does_not_move_the_avalanches() {
    let scene = table_i_scene(gold_5(), 20e6, 2_000);
    let mut still = scene.clone();
    still.detectors[0].jitter_ps.clear();
    let (jittered, still) = (detections(&scene, 1, 0, 0), detections(&still, 1, 0, 0));
    assert_eq!(jittered.len(), still.len());
    for (a, b) in jittered.iter().zip(&still) {
        let shift = (a.chip as f64 - b.chip as f64) + a.fraction - b.fraction;
        assert!(shift.abs() * 8000.0 < 10.0 * 54.0 && shift != 0.0);
    }
}

/// Pulses of the same detections by the definition, looking at every sample of every step.
fn naive_pulses(scene: &Scene, model: &DetectorModel, steps: &[(u64, u64)]) -> Vec<Pulse> {
    let sample_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
    let width_ps = scene.detectors[0].pulse_width_ps;
    let samples_per_step = scene.scan.integration_chips * u64::from(scene.samples_per_chip);
    let mut pulses = Vec::new();
    for (number, &(repetition, step)) in steps.iter().enumerate() {
        let step_start = Sample(number as u64 * samples_per_step);
        let recorded = &Recorder::new(model).record(1, &[(repetition, Group(step))])[0];
        for detection in recorded.iter().map(|time| time.detection()) {
            let time_ps = (detection.chip as f64 + detection.fraction) * scene.chip_period_ps;
            let high: Vec<u64> = (0..samples_per_step + 64)
                .filter(|&s| {
                    let level_at_ps = s as f64 * sample_ps;
                    time_ps <= level_at_ps && level_at_ps < time_ps + width_ps
                })
                .collect();
            if let (Some(first), Some(last)) = (high.first(), high.last()) {
                pulses.push(Pulse { first: step_start + *first, end: step_start + (last + 1) });
            }
        }
    }
    pulses
}

#[test]
fn pulses_follow_the_definition_and_run_on_into_the_next_scan() {
    let mut scene = table_i_scene(code(&[1, 1, 0]), 60e6, 40);
    for width_ps in [7e3, 300.0] {
        scene.detectors[0].pulse_width_ps = width_ps;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let steps: Vec<(u64, u64)> = (0..2).flat_map(|r| (0..24).map(move |j| (r, j))).collect();
        let mut pulses = Vec::new();
        PulseStream::new(&model, 1, 0).advance(Sample(48 * 40 * 8), &mut pulses);
        let expected = naive_pulses(&scene, &model, &steps);
        assert!(expected.len() > 100);
        // The very last detection may be seen in the scan that follows.
        let until = Sample(48 * 40 * 8);
        let expected: Vec<Pulse> = expected.into_iter().filter(|p| p.first < until).collect();
        assert_eq!(pulses, expected);
    }
}

#[test]
fn a_window_scan_ends_after_its_last_step() {
    let mut scene = table_i_scene(gold_5(), 60e6, 50);
    scene.scan.first_step = 10;
    scene.scan.steps = 5;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let mut pulses = Vec::new();
    PulseStream::new(&model, 1, 0).advance(Sample(u64::MAX), &mut pulses);
    let steps: Vec<(u64, u64)> = (0..5).map(|j| (0, j)).collect();
    assert_eq!(pulses, naive_pulses(&scene, &model, &steps));
    // 250 chips, realigned to the ninth period of 31 chips.
    assert_eq!(model.timing().first_chip(0, Group(4)), Chip(200));
    assert_eq!(model.timing().first_chip(1, Group(0)), Chip(279));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn pulses_do_not_depend_on_the_size_of_blocks(
        seed: u64,
        blocks in prop::collection::vec(1_u64..3_000, 1..40),
    ) {
        let scene = table_i_scene(gold_5(), 30e6, 100);
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let end: u64 = blocks.iter().sum();
        let mut whole = Vec::new();
        PulseStream::new(&model, seed, 0).advance(Sample(end), &mut whole);

        let mut stream = PulseStream::new(&model, seed, 0);
        let (mut parts, mut until) = (Vec::new(), Sample(0));
        for block in blocks {
            let before = parts.len();
            stream.advance(until + block, &mut parts);
            prop_assert!(parts[before..].iter().all(|p| (until..until + block).contains(&p.first)));
            until += block;
        }
        prop_assert!(parts.is_sorted_by_key(|pulse| pulse.first));
        prop_assert_eq!(parts, whole);
    }
}

/// Mean signed count per detection of light with an infinite extinction ratio,
/// by following light and reference over the code period in small steps. Edges
/// may be less than a chip apart.
fn naive_correlation(chips: &[u8], delay: f64, reference_delay: f64, edges: [f64; 2]) -> f64 {
    let points_per_chip = 4_000;
    let at = |time: f64| chips[time.rem_euclid(chips.len() as f64) as usize] == 1;
    let (mut sum, mut on) = (0.0, 0.0);
    for point in 0..points_per_chip * chips.len() {
        let time = (point as f64 + 0.5) / points_per_chip as f64;
        let copies = edges.map(|edge| at(time - reference_delay - edge));
        let [rising, falling] = edges;
        let level = if rising > falling { copies[0] && copies[1] } else { copies[0] || copies[1] };
        if at(time - delay) {
            on += 1.0;
            sum += if level { 1.0 } else { -1.0 };
        }
    }
    sum / on
}

#[test]
fn the_counter_correlates_with_the_delayed_reference_and_its_late_edges() {
    let chips = [1, 1, 1, 0, 1, 0, 0];
    for (rising_ps, falling_ps) in [(0.0, 0.0), (340.0, 1390.0), (1340.0, 390.0)] {
        let mut scene = ideal_scene(code(&chips), 40e6, 7 * 3_000);
        scene.paths[0].delay_ps = 2.3 * 8000.0;
        scene.detectors[0].counter = CounterTiming {
            rising_delay_ps: rising_ps,
            falling_delay_ps: falling_ps,
            transition_ps: 1.5,
        };
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        for k in [0, 5, 17, 18, 19, 30, 44] {
            let count = count_step(&model, 51, 0, Step(k));
            let timing = [rising_ps / 8000.0, falling_ps / 8000.0];
            let mean = naive_correlation(&chips, 2.3, k as f64 / 8.0, timing);
            let n = count.total as f64;
            let error = ((1.0 - mean * mean) / n + 1e-7).sqrt();
            assert_within_standard_errors(
                (count.signed as f64 / n - mean) / error,
                5.0,
                &format!("k = {k}, edges {rising_ps} and {falling_ps} ps"),
            );
        }
    }
}

#[test]
fn near_an_edge_either_sign_is_equally_likely() {
    let mut scene = ideal_scene(code(&[1, 0]), 40e6, 20_000);
    scene.detectors[0].counter.transition_ps = 2000.0;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let shares = Moments::of((0..16).map(|j| {
        // A quarter chip on either side of every edge is drawn at random, which
        // cuts the triangle 1 - 2 |lag| off at a half.
        let count = count_step(&model, 61, 0, Step(j));
        let lag = (j as f64 / 8.0 + 1.0) % 2.0 - 1.0;
        let certain = (1.0 - 2.0 * lag.abs()).clamp(-0.5, 0.5);
        count.signed as f64 / count.total as f64 - certain
    }));
    // 3,200 detections a step, of which up to half are drawn at random.
    assert!(shares.standard_error() < 3.0 / 3_200_f64.sqrt());
    assert_within_standard_errors(shares.z(0.0), 5.0, "mean excess of the signed share");
}

#[test]
fn no_light_at_all_ends_without_a_detection() {
    let mut scene = ideal_scene(gold_5(), 0.0, 1 << 40);
    assert_eq!(detections(&scene, 1, 0, 0), []);
    // About one photon in a step of 4.9 hours: no time is spent between.
    scene.sources[0].mean_power_w = power_w(1e-4);
    let found: usize = (0..100).map(|j| detections(&scene, 1, 0, j).len()).sum();
    let mean: f64 = 1e-4 * 8e-9 * (1_u64 << 40) as f64 * 100.0;
    assert_within_standard_errors((found as f64 - mean) / mean.sqrt(), 5.0, "count");
}

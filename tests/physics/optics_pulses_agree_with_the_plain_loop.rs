//! The pulses of the vector lanes against those of the plain loop: rates, gaps, places in a
//! sample and a code period, and lengths, by chi-square over a million pulses each.

use std::sync::Arc;

use goldtof::photons::fast::Recorder;
use goldtof::photons::{Detection, DetectorModel, Pulse, PulseStream};
use goldtof::scan::{Group, Sample};
use goldtof::scene::{DetectorIndex, JitterTail, LaserResponse, Recharge, Scene};
use goldtof::sensor::Sensor;
use optics_support::{Moments, assert_within_standard_errors, gold_5, gold_11, table_i_scene};

const STEPS: u64 = 24;

/// What is counted of pulses and detections, as histograms.
#[derive(Default)]
struct Counted {
    /// Pulses of each step.
    numbers: Vec<f64>,
    gaps: Vec<f64>,
    samples: Vec<f64>,
    lengths: Vec<f64>,
    /// Places of detections within a sample.
    phases: Vec<f64>,
}

impl Counted {
    fn new(period: u64) -> Counted {
        Counted {
            gaps: vec![0.0; 600],
            samples: vec![0.0; period as usize],
            lengths: vec![0.0; 64],
            phases: vec![0.0; 64],
            ..Counted::default()
        }
    }

    /// Takes a scan's pulses, of steps of some samples.
    fn take(&mut self, pulses: &[Pulse], step_samples: u64) {
        let mut numbers = vec![0.0; STEPS as usize];
        let mut last: Option<u64> = None;
        for Pulse { first: Sample(first), end: Sample(end) } in pulses {
            numbers[(first / step_samples) as usize] += 1.0;
            if let Some(last) = last {
                let gap = self.gaps.get_mut((first - last) as usize);
                gap.into_iter().for_each(|gap| *gap += 1.0);
            }
            last = Some(*first);
            let period = self.samples.len() as u64;
            self.samples[(first % period) as usize] += 1.0;
            self.lengths[(end - first).min(63) as usize] += 1.0;
        }
        self.numbers.extend(numbers);
    }

    fn take_detections(&mut self, detections: impl Iterator<Item = Detection>) {
        for detection in detections {
            self.phases[(detection.fraction * 512.0) as usize % 64] += 1.0;
        }
    }
}

/// Two samples of one distribution, whatever it is: chi-square of their difference as a
/// normal number (Wilson and Hilferty).
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let [all_a, all_b] = [a, b].map(|counts| counts.iter().sum::<f64>());
    let filled = || a.iter().zip(b).filter(|(a, b)| *a + *b > 20.0);
    let [ratio_a, ratio_b] = [(all_b / all_a).sqrt(), (all_a / all_b).sqrt()];
    let chi_square: f64 =
        filled().map(|(a, b)| (ratio_a * a - ratio_b * b).powi(2) / (a + b)).sum();
    let freedom = (filled().count() as f64 - 1.0).max(1.0);
    let ninth = 2.0 / (9.0 * freedom);
    ((chi_square / freedom).cbrt() - (1.0 - ninth)) / ninth.sqrt()
}

fn assert_same_pulses(what: &str, scene: &Scene, scans: u64) {
    let mut scene = scene.clone();
    scene.scan.steps = STEPS;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let recorder = Arc::new(Recorder::new(&model));
    assert!(recorder.groups_at_once().is_some(), "{what}: the lanes must be used");
    let period = 8 * scene.sources[0].code.len();
    let step_samples = 8 * scene.scan.integration_chips;
    let [mut lanes, mut plain] = [Counted::new(period), Counted::new(period)];
    for scan in 0..scans {
        let group = Group(0);
        let streams = [
            PulseStream::of_groups(&recorder, 1, scan, group, None),
            PulseStream::of_plain_loop(&model, 2, scan),
        ];
        for (mut stream, counted) in streams.into_iter().zip([&mut lanes, &mut plain]) {
            let mut pulses = Vec::new();
            stream.advance(Sample(STEPS * step_samples), &mut pulses);
            counted.take(&pulses, step_samples);
        }
        let recorded = recorder.record(1, &[(scan, group)]).into_iter().flatten();
        lanes.take_detections(recorded.map(|time| time.detection()));
        plain.take_detections(model.step(2, scan, group));
    }
    assert!(lanes.numbers.iter().sum::<f64>() > 2e5, "{what}");
    let squared = |values: &[f64]| {
        let mean = Moments::of(values.iter().copied()).mean;
        values.iter().map(|value| (value - mean).powi(2)).collect::<Vec<_>>()
    };
    let z = |a: &[f64], b: &[f64]| {
        let [a, b] = [a, b].map(|values| Moments::of(values.iter().copied()));
        (b.mean - a.mean) / a.standard_error().hypot(b.standard_error())
    };
    for (name, z) in [
        ("rate", z(&lanes.numbers, &plain.numbers)),
        ("variance", z(&squared(&lanes.numbers), &squared(&plain.numbers))),
        ("gaps", difference(&lanes.gaps, &plain.gaps)),
        ("samples", difference(&lanes.samples, &plain.samples)),
        ("lengths", difference(&lanes.lengths, &plain.lengths)),
        ("phases", difference(&lanes.phases, &plain.phases)),
    ] {
        assert_within_standard_errors(z, 4.2, &format!("{what}: {name}"));
    }
}

#[test]
fn pulses_of_table_i_agree() {
    for (rate, scans) in [(5e6, 100), (60e6, 20)] {
        let scene = table_i_scene(gold_11(), rate, 13_100);
        assert_same_pulses(&format!("{rate:.0e}"), &scene, scans);
    }
}

#[test]
fn pulses_agree_with_edges_tails_and_passive_recharge() {
    let mut scene = table_i_scene(gold_5(), 20e6, 1_000);
    scene.sources[0].response = LaserResponse::Edges { rise_time_ps: 1e3, fall_time_ps: 3e3 };
    assert_same_pulses("edges", &scene, 150);
    let spad = &mut scene.detectors[0];
    spad.pulse_width_ps = 600.0;
    spad.jitter_tail = JitterTail::Exponential { share: 0.2, time_constant_ps: 2e3 };
    assert_same_pulses("tail", &scene, 150);
    scene.detectors[0].recharge = Recharge::Passive;
    assert_same_pulses("passive", &scene, 150);
}

/// In release mode half a minute.
#[test]
#[ignore = "a hundred million pulses; run with --release"]
fn a_hundred_million_pulses_of_table_i_agree() {
    assert_same_pulses("10^8", &table_i_scene(gold_11(), 12e6, 13_100), 4_000);
}

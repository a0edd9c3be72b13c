//! Counts that an estimate is made of are those that the Verilog sent, not those
//! that the reference model expects.

use std::collections::HashMap;

use crate::hdl_support::models;
use goldtof::cosim::Verdict;
use goldtof::cosim::engine::Engine;
use goldtof::cosim::sent::SentReader;
use goldtof::cosim::source::{SourceFile, Verilog, sources_of};
use goldtof::cosim::{CosimOptions, Cosimulation, cosimulate};
use goldtof::deliver::emit;
use goldtof::photons::StepCount;
use goldtof::reference::adversarial::Adversarial;
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::predictor::ReferenceModel;
use goldtof::scene::{self, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::sensor::interface::Interface;
use goldtof::sensor::layout::Layout;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::scans;

const SEED: u64 = 3;

/// 28 phase steps of 56 chips: a scan is over before the first comparison.
fn small_scene(estimator: &str, hardware: &str) -> Scene {
    let text = format!(
        r#"
        [clock]
        chip_period = "8 ns"
        samples_per_chip = 4
        [[source]]
        name = "laser"
        code = {{ family = "gold", degree = 3 }}
        wavelength = "783 nm"
        mean_power = "4 pW"
        [[detector]]
        name = "spad"
        reference = "laser"
        dead_time = "14 ns"
        [[path]]
        source = "laser"
        detector = "spad"
        distance = "1.2 m"
        [scan]
        integration = "448 ns"
        [estimate]
        estimator = "{estimator}"
        [hardware]
        {hardware}
        "#
    );
    scene::parse("test.toml", &text).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Co-simulates a scene with its own Verilog, in which `edits` are made.
fn cosimulated(scene: &Scene, edits: &[(&str, &str, &str)]) -> Cosimulation {
    let emission = emit(&Sensor::new(scene), "goldtof emit test.toml").expect("it can be emitted");
    let mut sources: Vec<SourceFile> = sources_of(&emission.files);
    for (name, from, to) in edits {
        let source = sources.iter_mut().find(|source| source.name == *name);
        let text = &mut source.expect("there is such a file").text;
        assert_eq!(text.matches(from).count(), 1, "{name}: {from}");
        *text = text.replace(from, to);
    }
    let top = goldtof::cosim::TOP.to_owned();
    let verilog = Verilog { top, sources, registers: None, cache: models() };
    let options = CosimOptions { seed: SEED, engine: Engine::Lockstep, ..Default::default() };
    cosimulate(&Sensor::new(scene), &verilog, &options, |_, _| ()).expect("the tools are there")
}

/// The reference model's counts of the first scans.
fn reference_counts(scene: &Scene, tier: Tier, repetitions: u64) -> Vec<StepCount> {
    let mut counts = Vec::new();
    let gather = |scan: &[StepCount]| counts.extend_from_slice(scan);
    scans(&Sensor::new(scene), DetectorIndex(0), tier, SEED, repetitions, gather)
        .expect("the tier can do the scene");
    counts
}

/// Signed counts and totals of the only detector.
fn sent(cosimulation: &Cosimulation) -> (Vec<i64>, Vec<Option<u64>>) {
    let counts = &cosimulation.counts[0];
    assert!(counts.iter().zip(0..).all(|(count, step)| count.step == step));
    counts.iter().map(|c| (c.signed, c.total)).unzip()
}

#[test]
fn sound_verilog_sends_what_the_reference_model_counts() {
    for (estimator, hardware, has_totals) in [
        ("model", "", true),
        ("fft", "", false),
        ("fft", "total_counts = true\nparallel = 5", true),
    ] {
        let scene = small_scene(estimator, hardware);
        let cosimulation = cosimulated(&scene, &[]);
        assert_eq!(cosimulation.report.verdict, Verdict::Match);
        let expected = reference_counts(&scene, Tier::Sampled, 1);
        let (signed, totals) = sent(&cosimulation);
        assert!(expected.iter().any(|count| count.signed != 0));
        assert_eq!(signed, Vec::from_iter(expected.iter().map(|c| c.signed)));
        let of_model = |count: &StepCount| has_totals.then_some(count.total);
        assert_eq!(totals, Vec::from_iter(expected.iter().map(of_model)));
    }
}

#[test]
fn counts_that_the_verilog_has_wrong_are_counted_wrong() {
    let scene = small_scene("model", "");
    let expected = reference_counts(&scene, Tier::Sampled, 1);
    let wrong = [
        ("result_stream.v", "count_r <= i_count;", "count_r <= ~i_count;"),
        ("result_stream.v", "total_r <= i_total;", "total_r <= i_total ^ 1'b1;"),
    ];
    let cosimulation = cosimulated(&scene, &wrong);
    assert_eq!(cosimulation.report.verdict, Verdict::Mismatch);
    let (signed, totals) = sent(&cosimulation);
    assert_eq!(signed, Vec::from_iter(expected.iter().map(|c| !c.signed)));
    assert_eq!(totals, Vec::from_iter(expected.iter().map(|c| Some(c.total ^ 1))));
}

#[test]
fn results_without_a_known_place_are_not_counted() {
    let scene = small_scene("fft", "");
    // Every result says that it is a scan's last, or none does.
    for (last, counted) in [("1'b1", 0), ("1'b0", 27)] {
        let edit = format!("o_last <= {last};");
        let edits = [("result_stream.v", "o_last <= i_last;", edit.as_str())];
        let cosimulation = cosimulated(&scene, &edits);
        assert_eq!(cosimulation.report.verdict, Verdict::Mismatch);
        assert_eq!(cosimulation.counts[0].len(), counted, "{last}");
    }
}

#[test]
fn the_tier_rtl_has_the_counts_of_the_tier_sampled() {
    for estimator in ["fft", "model"] {
        let scene = small_scene(estimator, "parallel = 3");
        let sampled = reference_counts(&scene, Tier::Sampled, 3);
        assert_eq!(sampled.len(), 3 * 28);
        assert_eq!(reference_counts(&scene, Tier::Rtl, 3), sampled, "{estimator}");
    }
}

#[test]
fn what_a_receiver_that_stalls_takes_stands_in_its_place() {
    for hardware in ["total_counts = true", "parallel = 5\ntotal_counts = true"] {
        let scene = small_scene("fft", hardware);
        let interface = Interface::of(&scene);
        let layout = Layout::of(&interface);
        let (mut taken, mut lost) = (0, 0);
        for seed in 0..20 {
            let mut reference = ReferenceModel::new(interface.clone()).expect("it can be modelled");
            let mut adversary = Adversarial::new(&interface, seed);
            let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, 20_000);
            let mut reader = SentReader::new(&interface, &layout);
            let mut block = Block::default();
            // Of the run up to the second reset: scans are numbered anew after it.
            let mut finished = HashMap::new();
            let mut sent = Vec::new();
            while maker.make(&mut block) {
                for step in maker.take_finished() {
                    let place = (step.scan, step.detector, step.step);
                    finished.entry(place).or_insert((step.count, Some(step.total)));
                }
                block.records.got.values.clone_from(&block.records.expected);
                reader.read(&block.records, &mut |count| sent.push(count));
            }
            for count in &sent {
                let place = (count.scan, count.detector, count.step);
                assert_eq!(finished[&place], (count.signed, count.total), "{place:?}");
            }
            taken += sent.len();
            lost += finished.len() - sent.len();
        }
        assert!(taken > 100 && lost > 100, "{taken} taken, {lost} lost");
    }
}

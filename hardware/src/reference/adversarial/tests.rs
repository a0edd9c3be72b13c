use std::collections::BTreeSet;
use std::path::Path;

use super::*;
use crate::reference::blocks::{Block, BlockMaker};
use crate::reference::predictor::StepResult;
use crate::scene;
use crate::sensor::layout::Layout;

#[test]
fn peaks_are_only_just_the_largest() {
    for file in ["../tests/scenes/peak.toml", "../tests/scenes/every-part.toml"] {
        let mut by_one = BTreeSet::new();
        let results = results(file, 1);
        let detectors: BTreeSet<usize> = results.iter().map(|r| r.detector.0).collect();
        for scan in results.chunk_by(|a, b| a.scan == b.scan && a.clock <= b.clock) {
            for &detector in &detectors {
                let counts = scan.iter().filter(|r| r.detector.0 == detector);
                let counts: Vec<i64> = counts.map(|result| result.count).collect();
                let Some(most) = counts.iter().max() else {
                    continue;
                };
                let at = counts.iter().position(|count| count == most).unwrap_or(0);
                if counts[..at].iter().max() == Some(&(most - 1)) {
                    by_one.insert((detector, *most));
                }
            }
        }
        for detector in detectors {
            for count in 1..16 {
                assert!(by_one.contains(&(detector, count)), "{file}: {detector} {count}");
            }
        }
    }
}

/// The carries of a total's difference depend on its bits and on where it stood before.
#[test]
fn totals_come_round_each_bit_beyond_what_is_sent() {
    let results = results("../tests/scenes/every-part.toml", 1);
    for detector in 0..2 {
        for bit in 6..10 {
            for total in (1 << bit) - 2..=(1 << bit) + 3 {
                let times = results
                    .iter()
                    .filter(|result| result.detector.0 == detector && result.exact_total == total);
                let times = times.count();
                assert!(times >= 3, "detector {detector}: {total} {times} times");
            }
        }
    }
}

/// Of so short a code a host still writes settings when the scan begins of which a reset is to cut the
/// first group.
#[test]
fn a_group_that_is_to_be_cut_waits_for_the_hosts_last_word() {
    let text = r#"
        clock = { chip_period = "8 ns", samples_per_chip = 4 }
        source = [{ name = "laser", code = { family = "chips", chips = "101101010" }, mean_power = "40 pW" }]
        detector = [{ name = "spad", reference = "laser", dead_time = "14 ns" }]
        path = [{ source = "laser", detector = "spad", distance = "3.2 m" }]
        scan = { integration = "4800 ns" }
        hardware = { parallel = 3, registers = "axi4-lite" }
    "#;
    let scene = scene::parse("short.toml", text).unwrap_or_else(|error| panic!("{error}"));
    let means = Means {
        skips: true,
        most_clocks_of_recipe: 24_000,
        most_clocks_of_talk: 24_000,
        calm_clocks: 2_000,
        clocks_of_large_counts: 40_000,
        clocks_of_close_counts: 0,
    };
    for seed in 1..4 {
        let adversary = Adversarial::with_means(&Interface::of(&scene), seed, means).unwrap();
        assert!(adversary.clocks_to_cover(100_000) > 10_000);
    }
}

/// A run that ends itself is as long as one that was asked for as many clocks, and drives the same.
#[test]
fn a_run_that_ends_itself_is_the_start_of_a_longer_one() {
    let scene = scene::load(Path::new("../tests/scenes/peak.toml")).expect("a sound scene");
    let interface = Interface::of(&scene);
    let layout = Layout::of(&interface);
    let adversary = Adversarial::with_means(&interface, 1, Means::cosim(true)).unwrap();
    let all = adversary.clone().clocks_to_cover(LONGEST_DEFAULT);
    let inputs = |mut adversary: Adversarial, clocks| {
        let mut reference = ReferenceModel::new(interface.clone()).unwrap();
        let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, clocks);
        let (mut block, mut inputs) = (Block::default(), Vec::new());
        while maker.make(&mut block) {
            inputs.extend_from_slice(&block.records.inputs);
        }
        assert_eq!(maker.clocks_made(), clocks.min(all));
        inputs
    };
    assert!(all < LONGEST_DEFAULT - 1);
    let ended = inputs(adversary.clone().ending_there(), LONGEST_DEFAULT);
    assert!(ended == inputs(adversary, all));
}

/// Of samples that are inverted, of hosts, of cells, and of histograms, whose run ends where it is cut off.
#[test]
fn a_run_that_writes_itself_is_what_another_model_predicts() {
    for name in ["every-part", "odd-cells", "peak", "registers", "rows"] {
        let file = format!("../tests/scenes/{name}.toml");
        let scene = scene::load(Path::new(&file)).unwrap_or_else(|error| panic!("{error}"));
        let interface = Interface::of(&scene);
        let layout = Layout::of(&interface);
        let adversary = Adversarial::with_means(&interface, 2, Means::cosim(true)).unwrap();
        let adversary = adversary.ending_there();
        const CLOCKS: u64 = 100_003;

        let mut reference = ReferenceModel::new(interface).unwrap();
        let mut driven = adversary.clone();
        let mut maker = BlockMaker::new(&mut reference, &mut driven, &layout, CLOCKS);
        let (mut block, mut all, mut results) = (Block::default(), Block::default(), Vec::new());
        while maker.make(&mut block) {
            append(&mut all, &block);
            results.extend(maker.take_finished());
        }

        let mut run = WrittenRun::new(adversary, CLOCKS);
        let (mut written, mut written_results) = (Block::default(), Vec::new());
        while run.make(&mut block) {
            assert_eq!(block.records.first_clock, written.clocks.end);
            append(&mut written, &block);
            written_results.extend(run.take_finished());
        }
        assert_eq!(written.clocks, all.clocks, "{name}");
        assert_eq!(run.clocks_made(), all.clocks.end, "{name}");
        assert!(written.records.inputs == all.records.inputs, "{name}");
        assert!(written.records.expected == all.records.expected, "{name}");
        assert_eq!(written.skips, all.skips, "{name}");
        assert_eq!(written.exercise, all.exercise, "{name}");
        assert_eq!(written_results, results, "{name}");
    }
}

/// Appends a block to those before it.
fn append(all: &mut Block, block: &Block) {
    all.clocks.end = block.clocks.end;
    all.records.inputs.extend_from_slice(&block.records.inputs);
    all.records.expected.extend_from_slice(&block.records.expected);
    all.skips.extend_from_slice(&block.skips);
    all.exercise.clone_from(&block.exercise);
}

/// The results of all steps that an adversary drives.
fn results(file: &str, seed: u64) -> Vec<StepResult> {
    let scene = scene::load(Path::new(file)).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::of(&scene);
    let layout = Layout::of(&interface);
    let adversary = Adversarial::with_means(&interface, seed, Means::cosim(true)).unwrap();
    let mut adversary = adversary.ending_there();
    let mut reference = ReferenceModel::new(interface).unwrap();
    let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, LONGEST_DEFAULT);
    let (mut block, mut results) = (Block::default(), Vec::new());
    while maker.make(&mut block) {
        results.extend(maker.take_finished());
    }
    assert!(results.len() > 1000, "{file}: {}", results.len());
    results
}

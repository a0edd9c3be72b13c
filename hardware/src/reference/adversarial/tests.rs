use std::collections::BTreeSet;
use std::path::Path;

use super::*;
use crate::reference::blocks::{Block, BlockMaker};
use crate::reference::predictor::StepResult;
use crate::scene;
use crate::sensor::layout::Layout;

const SCENES: [&str; 13] = [
    "../scenes/quick.toml",
    "../scenes/paper-single.toml",
    "../scenes/paper-square.toml",
    "../scenes/paper-interleaved.toml",
    "../scenes/dual-view.toml",
    "../scenes/multipath.toml",
    "../scenes/moving.toml",
    "../tests/scenes/window.toml",
    "../tests/scenes/window-in-step.toml",
    "../tests/scenes/peak.toml",
    "../tests/scenes/totals.toml",
    "../tests/scenes/histogram.toml",
    "../tests/scenes/histogram-one-memory.toml",
];

/// The points that an adversary leaves out, and its clocks.
fn left_out(file: &str, means: Means, seed: u64) -> (Vec<CoverPoint>, u64) {
    let scene = scene::load(Path::new(file)).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::of(&scene);
    let mut adversary = Adversarial::with_means(&interface, seed, means).unwrap();
    let clocks = adversary.clone().clocks_to_cover(LONGEST_DEFAULT);
    while adversary.decided < clocks {
        adversary.decide();
    }
    let points = adversary.scout.cover_table().points();
    let covered = &adversary.scout.exercise().covered;
    let missed = (0..points.len()).filter(|&number| !covered.contains(number));
    (missed.map(|number| points[number]).collect(), clocks)
}

#[test]
fn every_cover_point_is_reached_where_steps_and_scans_can_be_shortened() {
    for file in SCENES {
        let (missed, clocks) = left_out(file, Means::cosim(true), 1);
        assert!(missed.is_empty(), "{file}: {missed:?}");
        assert!(clocks < 2_000_000, "{file}: {clocks}");
    }
}

#[test]
fn without_that_what_is_not_reached_is_said_to_be_too_far_away() {
    for file in [
        "../scenes/paper-single.toml",
        "../tests/scenes/window.toml",
        "../tests/scenes/totals.toml",
    ] {
        let means = Means::cosim(false);
        let scene = scene::load(Path::new(file)).unwrap_or_else(|error| panic!("{error}"));
        let interface = Interface::of(&scene);
        let (missed, _) = left_out(file, means, 1);
        for point in missed {
            let hindrance = Adversarial::hindrance(&interface, means, point);
            assert!(hindrance.is_some(), "{file}: {point:?}");
        }
    }
}

/// A comparison that overlooks its lowest bits passes every peak that stands out. So scans
/// end with a largest count by one more than all before it, at each count up to 16.
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

/// The results of all steps that an adversary drives.
fn results(file: &str, seed: u64) -> Vec<StepResult> {
    let scene = scene::load(Path::new(file)).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::of(&scene);
    let layout = Layout::of(&interface);
    let mut adversary = Adversarial::with_means(&interface, seed, Means::cosim(true)).unwrap();
    let clocks = adversary.clone().clocks_to_cover(LONGEST_DEFAULT);
    let mut reference = Reference::new(interface).unwrap();
    let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, clocks);
    let (mut block, mut results) = (Block::default(), Vec::new());
    while maker.make(&mut block) {
        results.extend(maker.take_finished());
    }
    assert!(results.len() > 1000, "{file}: {}", results.len());
    results
}

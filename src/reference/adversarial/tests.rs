use std::path::Path;

use super::*;
use crate::scene;

const SCENES: [&str; 13] = [
    "scenes/quick.toml",
    "scenes/paper-single.toml",
    "scenes/paper-square.toml",
    "scenes/paper-interleaved.toml",
    "scenes/dual-view.toml",
    "scenes/multipath.toml",
    "scenes/moving.toml",
    "tests/scenes/window.toml",
    "tests/scenes/window-in-step.toml",
    "tests/scenes/peak.toml",
    "tests/scenes/totals.toml",
    "tests/scenes/histogram.toml",
    "tests/scenes/histogram-one-memory.toml",
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
        "scenes/paper-single.toml",
        "tests/scenes/window.toml",
        "tests/scenes/totals.toml",
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

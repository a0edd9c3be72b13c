//! Emitted Verilog is clean under three tools that know nothing of each other.

use std::collections::HashSet;
use std::mem::discriminant;

use crate::flow_lint_matrix::lint;
use crate::hdl_support::{Family, code, scene};
use goldtof::deliver::emit;
use goldtof::scene::{Registers, Scene};
use goldtof::sensor::Sensor;
use optics_support::repeated;
use rayon::prelude::*;

/// Every family, depth, number of samples, kind of scan and width at least
/// once, most of them together with several of the others.
fn scenes() -> Vec<Scene> {
    let families = [
        Family::Gold(3),
        Family::Gold(5),
        Family::Gold(11),
        Family::Gold(15),
        Family::MSequence(3),
        Family::MSequence(16),
        Family::Square,
        Family::Chips(1),
        Family::Chips(64),
        Family::Chips(130),
    ];
    let mut scenes = Vec::new();
    for (number, family) in families.into_iter().enumerate() {
        for scan in 0..4 {
            let interleave = (number as u32 + scan) % 5;
            let lanes = 1 << ((number as u32 + 2 * scan) % 5);
            let mut codes = vec![code(family, interleave, 3)];
            if scan % 2 == 1 {
                codes.push(code(Family::Gold(5), 1, 9));
                codes.push(codes[0].clone());
            }
            let (first, steps, integration, width) = match scan {
                0 => (0, None, 13_100, None),
                1 => (1, Some(1), 1, None),
                2 => (u64::from(lanes), Some(2), 128, Some(2)),
                _ => (0, None, 129, Some(5)),
            };
            let last = codes.len() - 1;
            scenes.push(scene(&codes, last, lanes, first, steps, integration, width));
        }
    }
    scenes
}

/// Every number of samples, with a host that sets scans, and every other time a target that is followed.
fn hosted_scenes() -> Vec<Scene> {
    let families = [Family::Gold(3), Family::Gold(11), Family::MSequence(5), Family::Chips(64)];
    let mut scenes = Vec::new();
    for (number, lanes) in [1, 2, 4, 8, 16].into_iter().enumerate() {
        for track in [false, true] {
            let family = families[(number + usize::from(track)) % families.len()];
            let codes = [code(family, (number % 2) as u32, 3)];
            let width = (number == 3).then_some(8);
            let mut hosted = scene(&codes, 0, lanes, 1, Some(5), 1_310, width);
            hosted.hardware.registers = Registers::Axi4Lite;
            hosted.hardware.peak_detector = true;
            hosted.hardware.track = track;
            scenes.push(hosted);
        }
    }
    scenes
}

#[test]
fn scenes_are_clean_under_verilator_icarus_and_yosys() {
    let scenes = [scenes(), hosted_scenes()].concat();
    // Each family, kind of scan and number of samples is among every third, too.
    let kinds = |scenes: &[Scene]| {
        let kinds = |scene: &Scene| {
            let family = discriminant(&scene.sources[0].code.generator);
            let is_whole = scene.scan.steps == scene.scan.steps_per_period;
            let samples = scene.samples_per_chip;
            [format!("{family:?}"), format!("whole: {is_whole}"), format!("{samples} samples")]
        };
        scenes.iter().flat_map(kinds).collect::<HashSet<_>>()
    };
    let all = kinds(&scenes);
    let scenes: Vec<Scene> = scenes.into_iter().step_by(repeated(3, 1) as usize).collect();
    assert_eq!(kinds(&scenes), all);
    scenes.par_iter().for_each(|scene| {
        let made_by = "goldtof emit test.toml --out build";
        let emission = emit(&Sensor::new(scene), made_by).expect("the scene is fine");
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert_eq!(
            lint(&emission, folder.path(), &["sensor_top"]),
            "",
            "{:?}",
            emission.parameters
        );
    });
}

#[test]
fn emitting_twice_gives_the_same_bytes() {
    for scene in scenes() {
        let first =
            emit(&Sensor::new(&scene), "goldtof emit a.toml --out b").expect("the scene is fine");
        let second =
            emit(&Sensor::new(&scene), "goldtof emit a.toml --out b").expect("the scene is fine");
        assert_eq!(first, second);
    }
}

//! Emitted Verilog against a naive model, every port at every clock.

use crate::hdl_support::{Family, code, icarus, naive_sensor, random_scene, scene, stimulus};
use goldtof::deliver::emit;
use goldtof::scene::Scene;
use goldtof::sensor::Sensor;
use goldtof::sensor::interface::Interface;
use optics_support::repeated;
use rayon::prelude::*;

fn agrees_with_the_definition(scene: &Scene, cycles: usize, seed: u64) {
    let interface = Interface::of(scene);
    let emission =
        emit(&Sensor::new(scene), "goldtof emit test.toml --out build").expect("the scene is fine");
    let inputs = stimulus::inputs(interface.lanes() * interface.inputs() as u32, cycles, seed);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let got = icarus::simulate(&emission, &interface, &inputs, folder.path());
    let expected = naive_sensor::outputs(&interface, &inputs, &[]);
    assert_eq!(got.len(), expected.len());
    let results = expected.iter().filter(|o| o.valid).count();
    assert!(results > 0, "the run is too short to show a result");
    for (cycle, (got, expected)) in got.iter().zip(&expected).enumerate() {
        assert_eq!(got, expected, "cycle {cycle}, seed {seed}, {:?}", emission.parameters);
    }
}

#[test]
fn a_full_gold_scan_agrees_at_every_clock() {
    for (degree, cycles) in [(5, 6000), (11, 4000)] {
        let codes = [code(Family::Gold(degree), 0, 3)];
        agrees_with_the_definition(&scene(&codes, 0, 8, 0, None, 13, None), cycles, 1);
    }
}

#[test]
fn any_scene_agrees_at_every_clock() {
    let mut noise = stimulus::Noise::new(2023);
    let scenes: Vec<_> =
        (0..repeated(20, 60) as u32).map(|case| (case, random_scene(&mut noise, case))).collect();
    scenes.par_iter().for_each(|(case, scene)| {
        agrees_with_the_definition(scene, 3000, u64::from(*case));
    });
}

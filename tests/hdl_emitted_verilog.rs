//! Emitted Verilog against a naive model, every port at every clock.

mod hdl_support;

use goldtof::hdl::emit;
use goldtof::model::contract::Contract;
use goldtof::scene::Scene;
use hdl_support::{Family, code, icarus, naive_sensor, scene, stimulus};

fn agrees_with_the_definition(scene: &Scene, cycles: usize, seed: u64) {
    let contract = Contract::of(scene);
    let emission = emit(scene, "goldtof emit test.toml --out build").expect("the scene is fine");
    let inputs = stimulus::inputs(contract.lanes, cycles, seed);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let got = icarus::simulate(&emission, &contract, &inputs, folder.path());
    let expected = naive_sensor::outputs(&contract, &inputs);
    assert_eq!(got.len(), expected.len());
    let results = expected.iter().filter(|o| o.valid).count();
    assert!(results > 0, "the run is too short to show a result");
    for (cycle, (got, expected)) in got.iter().zip(&expected).enumerate() {
        assert_eq!(
            got, expected,
            "cycle {cycle}, seed {seed}, {:?}",
            emission.parameters
        );
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
    for case in 0..60 {
        let family = match noise.below(6) {
            0 => Family::Square,
            1 => Family::Chips(1 + noise.below(70) as usize),
            2 => Family::MSequence(3 + noise.below(4) as u32),
            _ => Family::Gold(3 + noise.below(4) as u32),
        };
        let interleave = noise.below(5) as u32;
        let lanes = 1 << noise.below(5);
        let mut codes = vec![code(family, interleave, case)];
        for other in 0..noise.below(3) as u32 {
            let same = noise.below(3) == 0;
            codes.push(if same {
                codes[0].clone()
            } else {
                code(Family::Gold(3 + other), other, case + 7)
            });
        }
        let reference = noise.below(codes.len() as u64) as usize;
        let period = codes[reference].len() * lanes;
        let is_full = period < 300 && noise.below(3) == 0;
        let steps = (!is_full).then(|| 1 + noise.below(period.min(40)));
        let first = noise.below(period);
        let dwell = 1 + noise.below(20);
        let width = (noise.below(3) == 0).then(|| 2 + noise.below(4) as u32);
        let scene = scene(&codes, reference, lanes as u32, first, steps, dwell, width);
        agrees_with_the_definition(&scene, 3000, u64::from(case));
    }
}

//! Scenes drawn at random from the interface, emitted and co-simulated under
//! hostile inputs: Verilog and reference model agree on every port at every
//! clock.

use crate::hdl_support::draw::{self, Extent};
use crate::hdl_support::models;
use goldtof::cosim::engine::Engine;
use goldtof::cosim::source::{Verilog, sources_of};
use goldtof::cosim::{CosimOptions, StimulusKind, Verdict, cosimulate};
use goldtof::scene::Registers;
use goldtof::sensor::Sensor;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// Longest run; a scan of most scenes is shorter.
const MOST_CLOCKS: u64 = 400_000;

fn match_under_hostile_inputs(scenes: u64, seed: u64, registers: Registers) {
    let shown = (0..scenes).into_par_iter().map(|number| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64((seed << 32) + number);
        let (scene, emission) = draw::emitted_with(&mut rng, Extent::SHORT, registers, |_| ());
        let verilog = Verilog {
            top: goldtof::cosim::TOP.to_owned(),
            sources: sources_of(&emission.files),
            // Shortened steps and scans, and whole ones.
            registers: (number % 2 == 0 && emission.parameters.histogram.is_none())
                .then(|| emission.scan_registers.clone()),
            cache: models(),
        };
        let options = CosimOptions {
            stimulus: StimulusKind::Adversarial,
            clocks: Some(MOST_CLOCKS),
            seed: number,
            engine: Engine::Lockstep,
            ..Default::default()
        };
        let report = cosimulate(&Sensor::new(&scene), &verilog, &options, |_, _| ())
            .expect("the tools are there")
            .report;
        let parameters = &emission.parameters;
        assert_eq!(
            report.verdict,
            Verdict::Match,
            "scene {number}, {parameters:?}, {:?}, {:?}",
            report.first_mismatch,
            report.missing
        );
        assert_eq!(report.clocks, MOST_CLOCKS, "scene {number}");
        let has = |is: bool| u64::from(is);
        [
            has(report.phase_steps > 0),
            has(scene.hardware.peak_detector),
            has(scene.sends_total_counts()),
            has(scene.hardware.track),
        ]
    });
    let [with_results, with_peak, with_totals, with_track] =
        shown.reduce(|| [0; 4], |a, b| std::array::from_fn(|i| a[i] + b[i]));
    assert_eq!(with_results, scenes, "every run shows results");
    assert_eq!(with_track > 0, registers == Registers::Axi4Lite, "{with_track} follow a target");
    if scenes < 10 {
        return;
    }
    assert!(with_peak * 5 > scenes, "{with_peak} have a peak detector");
    assert!(with_totals * 5 > scenes, "{with_totals} send totals");
}

#[test]
fn twelve_random_scenes_match() {
    match_under_hostile_inputs(12, 1, Registers::None);
}

#[test]
#[ignore = "a hundred models to build: ten minutes"]
fn a_hundred_random_scenes_match() {
    match_under_hostile_inputs(100, 2, Registers::None);
}

#[test]
fn four_random_scenes_with_registers_match() {
    match_under_hostile_inputs(4, 3, Registers::Axi4Lite);
}

#[test]
#[ignore = "forty models to build: four minutes"]
fn forty_random_scenes_with_registers_match() {
    match_under_hostile_inputs(40, 4, Registers::Axi4Lite);
}

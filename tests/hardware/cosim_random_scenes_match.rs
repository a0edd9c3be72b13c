//! Scenes drawn at random from the interface, emitted and co-simulated under
//! hostile inputs: Verilog and reference model agree on every port at every
//! clock.

use crate::hdl_support::draw::{self, Extent};
use goldtof::cosim::build::sources_of;
use goldtof::cosim::{Request, StimulusKind, Verdict, cosimulate};
use goldtof::sensor::Sensor;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Longest run; a scan of most scenes is shorter.
const MOST_CLOCKS: u64 = 400_000;

fn match_under_hostile_inputs(scenes: u64, seed: u64) {
    let cache = tempfile::tempdir().expect("a temporary folder");
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut with_results, mut with_peak, mut with_totals) = (0, 0, 0);
    for number in 0..scenes {
        let (scene, emission) = draw::emitted(&mut rng, Extent::SHORT, |_| ());
        let request = Request {
            top: goldtof::cosim::TOP.to_owned(),
            sources: sources_of(&emission),
            // Shortened steps and scans, and whole ones.
            registers: (number % 2 == 0).then(|| emission.scan_registers.clone()),
            cache: cache.path().to_owned(),
            stimulus: StimulusKind::Adversarial,
            clocks: Some(MOST_CLOCKS),
            seed: number,
        };
        let report = cosimulate(&Sensor::new(&scene), &request, |_, _| ())
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
        assert_eq!(report.cycles, MOST_CLOCKS, "scene {number}");
        with_results += u64::from(report.phase_steps > 0);
        with_peak += u64::from(scene.hardware.peak_detector);
        with_totals += u64::from(scene.sends_total_counts());
    }
    assert_eq!(with_results, scenes, "every run shows results");
    assert!(with_peak * 5 > scenes, "{with_peak} have a peak detector");
    assert!(with_totals * 5 > scenes, "{with_totals} send totals");
}

#[test]
fn twelve_random_scenes_match() {
    match_under_hostile_inputs(12, 1);
}

#[test]
#[ignore = "a hundred models to build: ten minutes"]
fn a_hundred_random_scenes_match() {
    match_under_hostile_inputs(100, 2);
}

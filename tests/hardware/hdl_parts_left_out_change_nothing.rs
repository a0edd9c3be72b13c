//! A part of the hardware that a scene does without changes no count: the emitted
//! Verilog with and without it, driven by the same samples.

use std::sync::Arc;

use crate::hdl_support::naive_sensor::{Inputs, Outputs};
use crate::hdl_support::stimulus::{self, Noise};
use crate::hdl_support::{Family, code, icarus, scene, with_peak_if_possible};
use goldtof::code::{Code, Generator};
use goldtof::deliver::emit;
use goldtof::scan::Step;
use goldtof::scene::{FpgaTarget, Scene, SourceIndex};
use goldtof::sensor::Sensor;
use goldtof::sensor::interface::Interface;

/// A sensor with one detector whose steps follow one another.
fn plain_scene(noise: &mut Noise, case: u32) -> Scene {
    let family = match noise.below(5) {
        0 => Family::Square,
        1 => Family::Chips(2 + noise.below(40) as usize),
        2 => Family::MSequence(3 + noise.below(3) as u32),
        _ => Family::Gold(3 + noise.below(3) as u32),
    };
    let codes = [code(family, noise.below(3) as u32, case)];
    let lanes = 1 << noise.below(5);
    let period = lanes * codes[0].len();
    let steps = 1 + noise.below(period.min(12));
    let integration = 4 + noise.below(40);
    let first = noise.below(period);
    scene(&codes, 0, lanes as u32, first, Some(steps), integration, None)
}

/// Outputs of a scene's Verilog, clock by clock.
fn outputs(scene: &Scene, inputs: &[Inputs]) -> Vec<Outputs> {
    let emission = emit(&Sensor::new(scene), "goldtof emit test.toml").expect("the scene is fine");
    let folder = tempfile::tempdir().expect("a temporary folder");
    icarus::simulate(&emission, &Interface::of(scene), inputs, folder.path())
}

/// Hits, levels and noise on so many lanes, without a second reset, and with a
/// receiver that takes at once.
fn endless(lanes: u32, clocks: u64, seed: u64) -> Vec<Inputs> {
    let mut inputs = stimulus::inputs(lanes, clocks as usize, seed);
    for (clock, input) in inputs.iter_mut().enumerate() {
        input.reset = clock < 3;
        input.ready = true;
    }
    inputs
}

/// The counts that a receiver takes that is always ready.
fn counts(scene: &Scene, inputs: &[Inputs]) -> Vec<i64> {
    let unused = 128 - Interface::of(scene).tdata_bits;
    let outputs = outputs(scene, inputs);
    assert!(outputs.iter().all(|o| !o.overrun && !o.saturated));
    let taken = outputs.iter().filter(|output| output.valid);
    taken.map(|output| ((output.data << unused) as i128 >> unused) as i64).collect()
}

/// Clocks in which a scene sends its first group.
fn clocks_to_first_group(scene: &Scene) -> u64 {
    scene.scan.integration_chips + 120
}

/// The same chips from a table, in place of a generator made for them.
fn by_table(code: &Code) -> Arc<Code> {
    Arc::new(Code {
        generator: Generator::Chips(code.chips.clone()),
        interleave: 0,
        chips: code.chips.clone(),
    })
}

#[test]
fn second_lfsr_interleaver_and_shared_generators() {
    let mut noise = Noise::new(1);
    for case in 0..10 {
        let mut made = plain_scene(&mut noise, case);
        if case % 2 == 0 {
            let mut twin = made.sources[0].clone();
            twin.name = "twin".to_owned();
            made.sources.push(twin);
        }
        let mut from_tables = made.clone();
        for source in &mut from_tables.sources {
            source.code = by_table(&source.code);
        }
        let inputs = stimulus::inputs(made.samples_per_chip, 1_500, u64::from(case));
        assert_eq!(outputs(&made, &inputs), outputs(&from_tables, &inputs), "case {case}");
    }
}

#[test]
fn the_peak_detector() {
    let mut noise = Noise::new(2);
    let mut compared = 0;
    for case in 0..10 {
        let without = plain_scene(&mut noise, case);
        let mut with = without.clone();
        with_peak_if_possible(&mut with, true);
        if !with.hardware.peak_detector {
            continue;
        }
        let inputs = stimulus::inputs(without.samples_per_chip, 1_500, u64::from(case));
        let seen = outputs(&with, &inputs);
        assert!(seen.iter().any(|output| output.peak_valid));
        let but_its_ports: Vec<Outputs> = seen
            .into_iter()
            .map(|output| Outputs { peak_step: 0, peak_count: 0, peak_valid: false, ..output })
            .collect();
        assert_eq!(but_its_ports, outputs(&without, &inputs), "case {case}");
        compared += 1;
    }
    assert!(compared >= 6, "{compared} scenes have room for one");
}

#[test]
fn the_total_counts() {
    let mut noise = Noise::new(5);
    for case in 0..10 {
        let mut without = plain_scene(&mut noise, case);
        without.hardware.total_counts = Some(false);
        let mut with = without.clone();
        with.hardware.total_counts = Some(true);
        let inputs = stimulus::inputs(without.samples_per_chip, 1_500, u64::from(case));
        let seen = outputs(&with, &inputs);
        let signed_bits = Interface::of(&without).tdata_bits;
        assert!(Interface::of(&with).tdata_bits > signed_bits);
        assert!(seen.iter().any(|output| output.data >> signed_bits != 0));
        let but_totals: Vec<Outputs> = seen
            .into_iter()
            .map(|output| Outputs { data: output.data & ((1 << signed_bits) - 1), ..output })
            .collect();
        assert_eq!(but_totals, outputs(&without, &inputs), "case {case}");
    }
}

#[test]
fn the_saturation_clamp() {
    let mut noise = Noise::new(3);
    let mut compared = 0;
    for case in 0..10 {
        let exact = plain_scene(&mut noise, case);
        let bits = Interface::of(&exact).exact_count_bits();
        if bits < 5 {
            continue;
        }
        let mut narrow = exact.clone();
        narrow.hardware.counter_width = Some(bits - 1);
        assert!(Interface::of(&narrow).saturates());
        // A hit in four words at most: far from what the narrow counts hold.
        let mut inputs = endless(exact.samples_per_chip, 1_500, u64::from(case));
        for (clock, input) in inputs.iter_mut().enumerate() {
            if clock % 4 != 0 {
                input.samples = 0;
            } else if input.samples != 0 {
                input.samples = input.samples & input.samples.wrapping_neg();
            }
        }
        let expected = counts(&exact, &inputs);
        assert!(expected.iter().any(|&count| count != 0));
        let found = counts(&narrow, &inputs);
        // The clamp is a stage more, so its last result may come too late.
        assert!(expected.len() - found.len() <= 1);
        assert_eq!(found, expected[..found.len()], "case {case}");
        compared += 1;
    }
    assert!(compared >= 6, "{compared} scenes have counts that can be narrower");
}

#[test]
fn parallel_correlators() {
    let mut noise = Noise::new(4);
    for case in 0..6 {
        let mut together = plain_scene(&mut noise, case);
        let parallel = (2 + noise.below(3)).min(together.scan.steps_per_period);
        together.scan.steps = parallel;
        together.hardware.parallel = parallel as u32;
        let lanes = together.samples_per_chip;
        let clocks = clocks_to_first_group(&together);
        let inputs = endless(lanes, clocks, u64::from(case));
        let expected = counts(&together, &inputs);
        assert!(expected.len() >= parallel as usize, "case {case}");
        for step in 0..parallel {
            let mut alone = together.clone();
            alone.hardware.parallel = 1;
            alone.scan.steps = 1;
            alone.scan.first_step = together.scan.phase_step(Step(step));
            let found = counts(&alone, &inputs);
            assert_eq!(found[0], expected[step as usize], "case {case}, step {step}");
        }
    }
}

#[test]
fn several_detectors() {
    let mut noise = Noise::new(5);
    for case in 0..6 {
        let mut together = plain_scene(&mut noise, case);
        let (lanes, length) = (together.samples_per_chip, together.sources[0].code.len());
        let mut other = together.sources[0].clone();
        other.name = "other".to_owned();
        other.code = code(Family::Chips(length as usize), 0, case + 31);
        together.sources.push(other);
        let mut spad = together.detectors[0].clone();
        spad.name = "other".to_owned();
        spad.reference = SourceIndex(1);
        together.detectors.push(spad);

        let inputs = endless(2 * lanes, 1_500, u64::from(case));
        let expected = counts(&together, &inputs);
        assert!(expected.len() > 10, "case {case}");
        for detector in 0..2 {
            let mut alone = together.clone();
            alone.detectors = vec![together.detectors[detector].clone()];
            let own = u128::MAX >> (128 - lanes);
            let of_detector: Vec<Inputs> = inputs
                .iter()
                .map(|&input| Inputs {
                    samples: input.samples >> (detector as u32 * lanes) & own,
                    ..input
                })
                .collect();
            let found = counts(&alone, &of_detector);
            let pairs = expected.chunks_exact(2).zip(&found);
            assert!(found.len() >= expected.len() / 2);
            for (step, (pair, found)) in pairs.enumerate() {
                assert_eq!(pair[detector], *found, "case {case}, step {step}");
            }
        }
    }
}

#[test]
fn realignment_after_a_window() {
    let mut noise = Noise::new(6);
    for case in 0..6 {
        let mut full = plain_scene(&mut noise, case);
        let code = code(Family::MSequence(3), case % 2, case);
        full.samples_per_chip = 1 << noise.below(3);
        full.scan.steps_per_period = u64::from(full.samples_per_chip) * code.len();
        full.sources[0].code = code;
        full.scan.first_step = 0;
        full.scan.steps = full.scan.steps_per_period;
        full.scan.integration_chips = 4 + noise.below(12);
        assert!(!Interface::of(&full).realigns());
        let mut window = full.clone();
        window.scan.steps -= 1;
        assert!(Interface::of(&window).realigns());
        let clocks = full.scan.steps * full.scan.integration_chips + 100;
        let inputs = endless(full.samples_per_chip, clocks, u64::from(case));
        let in_window = window.scan.steps as usize;
        assert_eq!(
            counts(&full, &inputs)[..in_window],
            counts(&window, &inputs)[..in_window],
            "case {case}"
        );
    }
}

#[test]
fn the_choice_of_lanes() {
    let mut noise = Noise::new(7);
    for case in 0..6 {
        let mut whole_chips = plain_scene(&mut noise, case);
        let length = whole_chips.sources[0].code.len();
        let (parallel, first) = (1 + noise.below(3), noise.below(length));
        let parallel = parallel.min(length);
        let fine = 1 << (1 + noise.below(3));
        let mut sensor = |samples_per_chip: u64| {
            let scene = &mut whole_chips;
            scene.samples_per_chip = samples_per_chip as u32;
            scene.scan.steps_per_period = samples_per_chip * length;
            scene.scan.first_step = samples_per_chip * first;
            scene.scan.steps = samples_per_chip * parallel;
            scene.scan.integration_chips = scene.scan.integration_chips.max(26);
            scene.hardware.parallel = (samples_per_chip * parallel) as u32;
            scene.clone()
        };
        let (coarse, finer) = (sensor(1), sensor(fine));
        let inputs = endless(1, clocks_to_first_group(&coarse) + 30, u64::from(case));
        // The same level all through a chip.
        let held: Vec<Inputs> = inputs
            .iter()
            .map(|&input| Inputs { samples: input.samples * ((1 << fine) - 1), ..input })
            .collect();
        let (expected, found) = (counts(&coarse, &inputs), counts(&finer, &held));
        for step in 0..parallel as usize {
            assert_eq!(found[step * fine as usize], expected[step], "case {case}");
        }
    }
}

#[test]
fn count_segments() {
    let codes = [code(Family::Gold(5), 0, 1)];
    // Beyond 20 bits, which is one carry chain in the one target and two in the other.
    let whole = scene(&codes, 0, 8, 3, Some(1), 131_073, None);
    let mut in_segments = whole.clone();
    in_segments.hardware.target = FpgaTarget::Ice40Hx8k;
    let segments = |scene: &Scene| {
        Interface::of(scene).correlator().expect("it counts up and down").count_segments.count
    };
    assert_eq!((segments(&whole), segments(&in_segments)), (1, 2));
    let inputs = endless(8, clocks_to_first_group(&whole), 1);
    let expected = counts(&whole, &inputs);
    assert!(expected[0].unsigned_abs() > 1 << 11, "{expected:?}");
    assert_eq!(counts(&in_segments, &inputs), expected);
}

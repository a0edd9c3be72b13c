//! The event-driven reference model against the sensor's definition, which looks at every
//! sample of every clock.

use std::ops::Range;

use goldtof::reference::adversarial::{Adversarial, Means};
use goldtof::reference::levels::Levels;
use goldtof::reference::predictor::{ReferenceModel, Skip};
use goldtof::reference::stimulus::{Drive, Stimulus};
use goldtof::scene::{self, Scene, SourceIndex};
use goldtof::sensor::interface::{Correlator, Counting, Interface, TotalCount};
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;
use optics_support::repeated;

use crate::hdl_support::give_cells;
use crate::hdl_support::naive_sensor::{self, Inputs, Outputs};

/// A run of the event-driven model: its inputs, where steps and scans are cut short, its outputs.
struct Run {
    inputs: Vec<Inputs>,
    skips: Vec<Skip>,
    outputs: Vec<Outputs>,
}

fn event_driven(interface: &Interface, seed: u64, clocks: u64, block: u64, means: Means) -> Run {
    let layout = Layout::of(interface);
    let lanes = interface.lanes() as usize;
    let mut adversary = Adversarial::with_means(interface, seed, means).unwrap();
    let mut reference = ReferenceModel::new(interface.clone()).unwrap();
    let detectors = interface.reference_codes.len();
    let mut levels = Levels::of(interface);
    let quiet = Inputs { reset: false, ready: true, samples: 0 };
    let mut inputs = vec![quiet; clocks as usize];
    let (mut skips, mut outputs) = (Vec::new(), Vec::new());
    let mut drive = Drive::of(interface);
    let mut start = 0;
    while start < clocks {
        let end = (start + block).min(clocks);
        drive.start(start..end);
        adversary.drive(&mut drive);
        for (input, pulses) in drive.pulses.iter().enumerate() {
            for pulse in pulses {
                let samples = pulse.first.0 as usize..pulse.end.0 as usize;
                for sample in samples.take_while(|sample| sample / lanes < clocks as usize) {
                    let bit = input * lanes + sample % lanes;
                    inputs[sample / lanes].samples |= 1 << bit;
                }
            }
        }
        let of = |range: &Range<u64>| range.start as usize..range.end.min(clocks) as usize;
        for reset in &drive.surroundings.resets {
            inputs[of(reset)].iter_mut().for_each(|input| input.reset = true);
        }
        for stall in &drive.surroundings.stalls {
            inputs[of(stall)].iter_mut().for_each(|input| input.ready = false);
        }
        skips.extend(&drive.surroundings.skips);
        let mut hits = vec![Vec::new(); detectors];
        let Drive { pulses, surroundings } = &mut drive;
        levels.paint(start..end, pulses, |_, _, _| (), &mut hits, &mut surroundings.cells);
        let words = layout.outputs.words;
        let mut expected = vec![0; (end - start) as usize * words];
        reference.predict(&drive.surroundings, &hits, &mut expected);
        outputs.extend(expected.chunks_exact(words).map(|record| shown(&layout, record)));
        start = end;
    }
    Run { inputs, skips, outputs }
}

/// A record's ports; those that the sensor does not have are 0.
fn shown(layout: &Layout, record: &[u64]) -> Outputs {
    let value = |port: PortRole| {
        let field = layout.outputs.fields.iter().find(|field| field.port.role == port);
        let words = field.map_or(Vec::new(), |field| field.read(record));
        words.iter().rev().fold(0, |value, &word| value << 64 | u128::from(word))
    };
    Outputs {
        laser: value(PortRole::Laser) as u64,
        epoch: value(PortRole::Epoch) == 1,
        data: value(PortRole::Data),
        valid: value(PortRole::Valid) == 1,
        last: value(PortRole::Last) == 1,
        overrun: value(PortRole::Overrun) == 1,
        saturated: value(PortRole::Saturated) == 1,
        peak_step: value(PortRole::PeakStep),
        peak_count: value(PortRole::PeakCount),
        peak_valid: value(PortRole::PeakValid) == 1,
    }
}

fn scene(samples_per_chip: u32, code: &str, scan: &str, hardware: &str) -> Scene {
    let text = format!(
        r#"
        [clock]
        chip_period = "8 ns"
        samples_per_chip = {samples_per_chip}
        [[source]]
        name = "other"
        code = {{ family = "m-sequence", degree = 3 }}
        wavelength = "783 nm"
        mean_power = "4 pW"
        [[source]]
        name = "laser"
        code = {code}
        wavelength = "783 nm"
        mean_power = "4 pW"
        [[detector]]
        name = "spad"
        reference = "laser"
        [scan]
        {scan}
        [hardware]
        {hardware}
        "#
    );
    scene::parse("test.toml", &text).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Further detectors, each with another Gold code of the first one's length.
fn with_detectors(mut scene: Scene, count: usize) -> Scene {
    for number in 1..count {
        let code = format!(r#"{{ family = "gold", degree = 5, index = {} }}"#, 7 + number);
        let other = self::scene(8, &code, "integration = \"80 ns\"", "");
        let mut source = other.sources[1].clone();
        source.name = format!("laser-{number}");
        scene.sources.push(source);
        let mut detector = scene.detectors[0].clone();
        detector.name = format!("spad-{number}");
        detector.reference = SourceIndex(scene.sources.len() - 1);
        scene.detectors.push(detector);
    }
    scene
}

/// The interface with counts of 45 bits and totals of 44.
fn with_wide_counts(interface: Interface) -> Interface {
    let correlator = Correlator {
        exact_count_bits: 45,
        count_bits: 45,
        total: Some(TotalCount { exact_bits: 44, bits: 44, first_bit: 48 }),
        ..*interface.correlator().expect("it counts up and down")
    };
    let counting = Counting::Correlator(correlator);
    Interface { counting, tdata_bits: 96, ..interface }
}

#[test]
fn the_two_agree_on_every_port_at_every_clock_under_adversarial_inputs() {
    let gold = r#"{ family = "gold", degree = 5, index = 3 }"#;
    let interleaved = r#"{ family = "gold", degree = 3, interleave = 2 }"#;
    let square = r#"{ family = "square" }"#;
    let scenes = [
        scene(8, gold, "integration = \"320 ns\"", ""),
        scene(4, gold, "integration = \"8 ns\"", "peak_detector = true"),
        scene(1, gold, "integration = \"80 ns\"", ""),
        scene(2, interleaved, "integration = \"104 ns\"", "counter_width = 4"),
        scene(16, square, "integration = \"800 ns\"", "counter_width = 6"),
        scene(
            8,
            gold,
            "integration = \"248 ns\"\nsteps = { first = 241, count = 17 }",
            "peak_detector = true",
        ),
        scene(
            4,
            gold,
            "integration = \"24 ns\"\nsteps = { first = 120, count = 1 }",
            "counter_width = 3",
        ),
        // Groups: whole, partial, longer than the code's samples per chip.
        scene(8, gold, "integration = \"320 ns\"", "parallel = 4"),
        scene(
            4,
            gold,
            "integration = \"160 ns\"",
            "parallel = 3\ncounter_width = 4\npeak_detector = true",
        ),
        scene(
            8,
            gold,
            "integration = \"248 ns\"\nsteps = { first = 13, count = 30 }",
            "parallel = 13",
        ),
        with_detectors(scene(8, gold, "integration = \"320 ns\"", "peak_detector = true"), 9),
        // Total counts: exact, saturated, of several steps and detectors.
        scene(8, gold, "integration = \"320 ns\"", "total_counts = true"),
        scene(1, gold, "integration = \"160 ns\"", "total_counts = true\ncounter_width = 3"),
        with_detectors(
            scene(
                4,
                gold,
                "integration = \"400 ns\"\nsteps = { first = 3, count = 41 }",
                "parallel = 7\ncounter_width = 5\ntotal_counts = true\npeak_detector = true",
            ),
            3,
        ),
        with_detectors(
            scene(
                2,
                gold,
                "integration = \"400 ns\"\nsteps = { first = 3, count = 41 }",
                "parallel = 7\ncounter_width = 4\npeak_detector = true",
            ),
            2,
        ),
    ];
    let mut interfaces: Vec<Interface> = scenes.iter().map(Interface::of).collect();
    // Cells with an input each.
    interfaces.extend(
        [(0, 2, 1), (14, 4, 2), (0, 3, 3), (0, 5, 0), (0, 5, 6), (2, 7, 8), (13, 3, 4)].map(
            |(scene, cells, coincidence)| {
                let mut scene = scenes[scene].clone();
                give_cells(&mut scene, cells, coincidence);
                Interface::of(&scene)
            },
        ),
    );
    // Counts as wide as hours of integration need: results of more than a word.
    interfaces.push(with_wide_counts(Interface::of(&scenes[7])));
    for (i, interface) in interfaces.iter().enumerate() {
        for seed in 0..repeated(2, 4) {
            let means = Means::cosim(seed % 2 == 1);
            let run = event_driven(interface, seed, 40_000, 1 << 12, means);
            let expected = naive_sensor::outputs(interface, &run.inputs, &run.skips);
            let differs = (0..expected.len()).find(|&c| expected[c] != run.outputs[c]);
            if let Some(clock) = differs {
                panic!(
                    "scene {i}, seed {seed}, clock {clock}: expected {:?}, predicted {:?}",
                    expected[clock], run.outputs[clock]
                );
            }
            let seen = |port: fn(&Outputs) -> bool| expected.iter().any(port);
            assert!(seen(|p| p.valid) && seen(|p| p.overrun), "scene {i}");
            assert_eq!(seen(|p| p.saturated), interface.saturates(), "scene {i}");
            assert_eq!(seen(|p| p.peak_valid), interface.peak().is_some(), "scene {i}");
        }
    }
}

#[test]
fn the_size_of_the_blocks_changes_nothing() {
    let scene = scene(8, r#"{ family = "gold", degree = 5 }"#, "integration = \"320 ns\"", "");
    let interface = Interface::of(&scene);
    let means = Means::cosim(true);
    let whole = event_driven(&interface, 7, 20_000, 20_000, means).outputs;
    for block in [1, 2, 3, 97, 4096] {
        assert!(
            event_driven(&interface, 7, 20_000, block, means).outputs == whole,
            "blocks of {block}"
        );
    }
}

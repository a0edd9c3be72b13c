//! The hardware simulated by rust-hdl, against a naive model, every port at
//! every clock.

use crate::hdl_support::naive_sensor::{Inputs, Outputs};
use crate::hdl_support::{Family, code, naive_sensor, random_scene, scene, stimulus};
use goldtof::rtl::blocks::{CodeSource, SensorTop};
use goldtof::rtl::front::{Word, tick};
use goldtof::scene::Scene;
use goldtof::sensor::interface::{Correlator, CountSegments, Counting, Interface, TotalCount};
use rust_hdl_core::block::Block;
use rust_hdl_core::simulate::simulate;

const MOST_PASSES: usize = 50;

fn settle<B: Block>(block: &mut B) {
    assert!(simulate(block, MOST_PASSES), "the circuit does not settle");
}

fn clock(sensor: &mut SensorTop, input: &Inputs) -> Outputs {
    sensor.io.m_axis_tready.next = input.ready;
    sensor.io.i_samples.next = Word::new(input.samples, 128);
    settle(sensor);
    tick(sensor, input.reset);
    settle(sensor);
    let saturates = sensor.io.o_saturated.is_present();
    let has_peak = sensor.io.o_peak_valid.is_present();
    Outputs {
        laser: sensor.io.o_laser.val().value() as u64,
        epoch: sensor.io.o_epoch.val(),
        data: sensor.io.m_axis_tdata.val().value(),
        valid: sensor.io.m_axis_tvalid.val(),
        last: sensor.io.m_axis_tlast.val(),
        overrun: sensor.io.o_overrun.val(),
        saturated: saturates && sensor.io.o_saturated.val(),
        peak_step: if has_peak { sensor.io.o_peak_step.val().value() } else { 0 },
        peak_count: if has_peak { sensor.io.o_peak_count.val().value() } else { 0 },
        peak_valid: has_peak && sensor.io.o_peak_valid.val(),
    }
}

fn agrees_with_the_definition(scene: &Scene, cycles: usize, seed: u64) {
    keeps(&Interface::of(scene), cycles, seed);
}

fn keeps(interface: &Interface, cycles: usize, seed: u64) {
    let inputs = stimulus::inputs(interface.lanes() * interface.inputs() as u32, cycles, seed);
    let expected = naive_sensor::outputs(interface, &inputs, &[]);
    assert!(expected.iter().any(|o| o.valid), "the run is too short");
    let correlator = *interface.correlator().expect("it counts up and down");
    let mut sensor = SensorTop::new(interface.clone(), correlator);
    for (cycle, (input, expected)) in inputs.iter().zip(&expected).enumerate() {
        let got = clock(&mut sensor, input);
        assert_eq!(got, *expected, "cycle {cycle}, seed {seed}");
    }
}

#[test]
fn the_sensor_agrees_at_every_clock() {
    let families = [Family::Gold(5), Family::MSequence(4), Family::Square, Family::Chips(11)];
    for (number, family) in families.into_iter().enumerate() {
        for interleave in [0, 2] {
            for (lanes, steps, width) in
                [(1, None, None), (4, Some(5), None), (8, Some(9), Some(3))]
            {
                let seed = number as u64 * 10 + u64::from(interleave);
                let codes = [code(Family::Gold(3), 0, 1), code(family, interleave, 5)];
                let scene = scene(&codes, 1, lanes, 2 * u64::from(lanes) - 1, steps, 7, width);
                agrees_with_the_definition(&scene, 800, seed);
            }
        }
    }
}

#[test]
fn any_sensor_agrees_at_every_clock() {
    let mut noise = stimulus::Noise::new(7);
    for case in 0..24 {
        let scene = random_scene(&mut noise, case);
        agrees_with_the_definition(&scene, 700, u64::from(case));
    }
}

#[test]
fn a_total_in_segments_counts_as_one_in_a_piece() {
    let shapes = [
        (2, 40, 1, false),
        (3, 60, 4, false),
        (4, 200, 8, true),
        (5, 300, 16, true),
        (4, 100, 2, true),
    ];
    for (segment_bits, integration, lanes, totals) in shapes {
        let codes = [code(Family::Gold(5), 0, 2)];
        let mut scene = scene(&codes, 0, lanes, 3, Some(9), integration, None);
        scene.hardware.total_counts = Some(totals);
        let mut interface = Interface::of(&scene);
        let mut correlator = *interface.correlator().expect("it counts up and down");
        let bits = correlator.exact_count_bits;
        let count = bits.div_ceil(segment_bits);
        assert!(count > 1 && correlator.count_segments.count == 1);
        correlator.count_segments = CountSegments {
            count,
            lower_bits: segment_bits,
            top_bits: bits - segment_bits * (count - 1),
        };
        interface.counting = Counting::Correlator(correlator);
        interface.result_latency_clocks += correlator.count_segments.clocks() - 1;
        keeps(&interface, 4000, u64::from(lanes));
    }
}

#[test]
fn counts_and_totals_of_more_than_a_word_agree_at_every_clock() {
    let codes = [code(Family::Gold(4), 0, 2)];
    let mut scene = scene(&codes, 0, 8, 3, Some(9), 30, None);
    scene.hardware.total_counts = Some(true);
    scene.hardware.parallel = 2;
    let mut interface = Interface::of(&scene);
    let correlator = Correlator {
        exact_count_bits: 45,
        count_bits: 45,
        count_segments: CountSegments { count: 4, lower_bits: 12, top_bits: 9 },
        total: Some(TotalCount { exact_bits: 44, bits: 44, first_bit: 48 }),
        ..*interface.correlator().expect("it counts up and down")
    };
    interface.counting = Counting::Correlator(correlator);
    interface.tdata_bits = 96;
    interface.result_latency_clocks += correlator.count_segments.clocks() - 1;
    keeps(&interface, 1000, 5);
}

#[test]
fn a_code_source_gives_its_table_from_any_start_and_waits_without_advance() {
    let mut noise = stimulus::Noise::new(5);
    for family in [Family::Gold(6), Family::MSequence(5), Family::Square, Family::Chips(13)] {
        for interleave in 0..=4 {
            let code = code(family, interleave, 9);
            let start = noise.below(code.len());
            let mut source = CodeSource::new(&code, start, true);
            let mut position = start;
            for cycle in 0..3 * code.len() {
                let (reset, load) = (cycle == 0, noise.below(50) == 0);
                let advance = noise.below(4) != 0;
                source.i_load.next = load;
                source.i_advance.next = advance;
                settle(&mut source);
                tick(&mut source, reset);
                settle(&mut source);
                position = if reset || load {
                    start
                } else {
                    (position + u64::from(advance)) % code.len()
                };
                let chip = code.chips[position as usize] == 1;
                assert_eq!(source.o_chip.val(), chip, "{family:?}, cycle {cycle}");
                assert_eq!(source.o_epoch.val(), position == start);
            }
        }
    }
}

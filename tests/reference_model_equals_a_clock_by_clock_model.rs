//! The event-driven reference model against a model of the same hardware that
//! looks at every sample of every clock: levels become hits by comparing
//! neighbouring samples, counts are dot products, the stream is a register.

use goldtof::cosim::adversarial::Adversarial;
use goldtof::cosim::stimulus::{Drive, Stimulus};
use goldtof::model::contract::Contract;
use goldtof::model::layout::Layout;
use goldtof::model::level::Level;
use goldtof::model::reference::Reference;
use goldtof::scene::{self, Scene};

/// Outputs of one clock, by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Ports {
    laser: u64,
    epoch: u64,
    tdata: u64,
    tvalid: u64,
    tlast: u64,
    overrun: u64,
    saturated: u64,
}

/// Everything that is known of the inputs, sample by sample and clock by clock.
struct Inputs {
    level: Vec<bool>,
    reset: Vec<bool>,
    ready: Vec<bool>,
}

/// The hardware, clock by clock.
fn clock_by_clock(contract: &Contract, inputs: &Inputs) -> Vec<Ports> {
    let clocks = inputs.reset.len();
    let lanes = contract.lanes as usize;
    let code = &contract.reference_codes[0].chips;
    let scan = contract.scan;
    let dwell = scan.integration_chips as usize;
    let period = code.len();
    let steps_per_period = period * lanes;
    let mut out = vec![Ports::default(); clocks];
    // Results by the clock at which they arrive.
    let mut arrivals: Vec<Option<(i64, bool)>> = vec![None; clocks];
    let mut t = 0;
    while t < clocks {
        if inputs.reset[t] {
            t += 1;
            continue;
        }
        let released = t;
        let end = (t..clocks).find(|&c| inputs.reset[c]).unwrap_or(clocks);
        arrivals.fill(None);
        let mut start = 0;
        'scans: loop {
            for j in 0..scan.steps as usize {
                let k = (scan.first_step as usize + j) % steps_per_period;
                let mut count = 0i64;
                for cycle in start + j * dwell..start + (j + 1) * dwell {
                    let word = released + 1 + cycle;
                    if word >= end {
                        break 'scans;
                    }
                    for lane in 0..lanes {
                        let sample = word * lanes + lane;
                        if inputs.level[sample] && !inputs.level[sample - 1] {
                            let delayed = (cycle * lanes + lane + steps_per_period * (1 + k) - k)
                                % steps_per_period;
                            count += 2 * i64::from(code[delayed / lanes]) - 1;
                        }
                    }
                }
                let last_word = released + start + (j + 1) * dwell;
                let arrival = last_word + contract.result_latency_clocks as usize;
                if arrival < end {
                    arrivals[arrival] = Some((count, j as u64 + 1 == scan.steps));
                }
            }
            let over = start + scan.steps as usize * dwell;
            start = if scan.is_full() {
                over
            } else {
                (over..).find(|n| n % period == 0).unwrap()
            };
        }
        let mut axis = Ports::default();
        for c in released..end {
            let ready = inputs.ready[c];
            if let Some((count, last)) = arrivals[c] {
                let bits = contract.count_bits;
                let (low, high) = (-(1i64 << (bits - 1)), (1i64 << (bits - 1)) - 1);
                axis.saturated |= u64::from(count < low || count > high);
                if axis.tvalid == 1 && !ready {
                    axis.overrun = 1;
                } else {
                    let mask = u64::MAX >> (64 - contract.tdata_bits);
                    axis.tdata = count.clamp(low, high) as u64 & mask;
                    axis.tlast = u64::from(last);
                    axis.tvalid = 1;
                }
            } else if ready {
                axis.tvalid = 0;
            }
            let cycle = c - released;
            out[c] = axis.clone();
            out[c].epoch = u64::from(cycle % period == 0);
            out[c].laser = contract
                .source_codes
                .iter()
                .enumerate()
                .map(|(m, code)| u64::from(code.chips[cycle % code.chips.len()]) << m)
                .sum();
        }
        t = end;
    }
    out
}

fn event_driven(contract: &Contract, seed: u64, clocks: u64, block: u64) -> (Inputs, Vec<Ports>) {
    let layout = Layout::of(contract);
    let lanes = contract.lanes as usize;
    let mut adversary = Adversarial::new(contract, seed);
    let mut reference = Reference::new(contract.clone()).unwrap();
    let mut level = Level::new(contract.lanes);
    let mut inputs = Inputs {
        level: vec![false; clocks as usize * lanes],
        reset: vec![false; clocks as usize],
        ready: vec![true; clocks as usize],
    };
    let mut ports = Vec::new();
    let mut drive = Drive::default();
    let mut start = 0;
    while start < clocks {
        let end = (start + block).min(clocks);
        drive.start(start..end);
        adversary.drive(&mut drive);
        for pulse in &drive.pulses {
            let to = (pulse.end as usize).min(inputs.level.len());
            inputs.level[pulse.first as usize..to].fill(true);
        }
        for reset in &drive.surroundings.resets {
            inputs.reset[reset.start as usize..reset.end.min(clocks) as usize].fill(true);
        }
        for stall in &drive.surroundings.stalls {
            inputs.ready[stall.start as usize..stall.end.min(clocks) as usize].fill(false);
        }
        let mut hits = Vec::new();
        level.paint(start..end, &drive.pulses, |_, _| (), &mut hits);
        let words = layout.outputs.words;
        let mut expected = vec![0; (end - start) as usize * words];
        reference.predict(&drive.surroundings, &hits, &mut expected);
        for record in expected.chunks_exact(words) {
            let read = |name| layout.outputs.field(name).read(record)[0];
            ports.push(Ports {
                laser: read("o_laser"),
                epoch: read("o_epoch"),
                tdata: read("m_axis_tdata"),
                tvalid: read("m_axis_tvalid"),
                tlast: read("m_axis_tlast"),
                overrun: read("o_overrun"),
                saturated: if contract.saturates() {
                    read("o_saturated")
                } else {
                    0
                },
            });
        }
        start = end;
    }
    (inputs, ports)
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

#[test]
fn the_two_agree_on_every_port_at_every_clock_under_adversarial_inputs() {
    let gold = r#"{ family = "gold", degree = 5, index = 3 }"#;
    let interleaved = r#"{ family = "gold", degree = 3, interleave = 2 }"#;
    let square = r#"{ family = "square" }"#;
    let scenes = [
        scene(8, gold, "integration = \"320 ns\"", ""),
        scene(4, gold, "integration = \"8 ns\"", ""),
        scene(1, gold, "integration = \"80 ns\"", ""),
        scene(
            2,
            interleaved,
            "integration = \"104 ns\"",
            "counter_width = 4",
        ),
        scene(16, square, "integration = \"800 ns\"", "counter_width = 6"),
        scene(
            8,
            gold,
            "integration = \"248 ns\"\nsteps = { first = 13, count = 9 }",
            "",
        ),
        scene(
            4,
            gold,
            "integration = \"24 ns\"\nsteps = { first = 120, count = 1 }",
            "counter_width = 3",
        ),
    ];
    for (i, scene) in scenes.iter().enumerate() {
        let contract = Contract::of(scene);
        for seed in 0..4 {
            let (inputs, predicted) = event_driven(&contract, seed, 40_000, 1 << 12);
            let expected = clock_by_clock(&contract, &inputs);
            let differs = (0..expected.len()).find(|&c| expected[c] != predicted[c]);
            if let Some(clock) = differs {
                panic!(
                    "scene {i}, seed {seed}, clock {clock}: expected {:?}, predicted {:?}",
                    expected[clock], predicted[clock]
                );
            }
            let seen = |port: fn(&Ports) -> u64| expected.iter().any(|p| port(p) == 1);
            assert!(seen(|p| p.tvalid) && seen(|p| p.overrun), "scene {i}");
            assert_eq!(seen(|p| p.saturated), contract.saturates(), "scene {i}");
        }
    }
}

#[test]
fn the_size_of_the_blocks_changes_nothing() {
    let scene = scene(
        8,
        r#"{ family = "gold", degree = 5 }"#,
        "integration = \"320 ns\"",
        "",
    );
    let contract = Contract::of(&scene);
    let (_, whole) = event_driven(&contract, 7, 20_000, 20_000);
    for block in [1, 2, 3, 97, 4096] {
        assert!(
            event_driven(&contract, 7, 20_000, block).1 == whole,
            "blocks of {block}"
        );
    }
}

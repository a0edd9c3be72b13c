//! The event-driven reference model against a model of the same hardware that
//! looks at every sample of every clock: levels become hits by comparing
//! neighbouring samples, counts are dot products, the stream is a register.

use goldtof::reference::adversarial::{Adversarial, Means};
use goldtof::reference::level::Level;
use goldtof::reference::predictor::{Reference, Skip};
use goldtof::reference::stimulus::{Drive, Stimulus};
use goldtof::scene::{self, Scene, SourceIndex};
use goldtof::sensor::interface::{Interface, TotalCount};
use goldtof::sensor::layout::Layout;

/// Outputs of one clock, by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Ports {
    laser: u64,
    epoch: u64,
    tdata: u128,
    tvalid: u64,
    tlast: u64,
    overrun: u64,
    saturated: u64,
    peak_valid: u64,
    /// Step and count bits of each detector.
    peaks: Vec<(u64, u64)>,
}

/// Everything that is known of the inputs, sample by sample and clock by clock.
struct Inputs {
    /// For each detector.
    level: Vec<Vec<bool>>,
    reset: Vec<bool>,
    ready: Vec<bool>,
    /// Where steps and scans are cut short.
    skips: Vec<Skip>,
}

/// Signed counts and all hits of a group's steps, and whether they end a scan.
type Results = (Vec<(i64, u64)>, bool);

/// The hardware, clock by clock.
fn clock_by_clock(interface: &Interface, inputs: &Inputs) -> Vec<Ports> {
    let clocks = inputs.reset.len();
    let lanes = interface.lanes() as usize;
    let scan = interface.timing.scan;
    let integration = scan.integration_chips as usize;
    let parallel = interface.parallel() as usize;
    let steps = scan.steps as usize;
    let period = interface.reference_codes[0].chips.len();
    let steps_per_period = period * lanes;
    let bits = interface.count_bits;
    let (low, high) = (-(1i64 << (bits - 1)), (1i64 << (bits - 1)) - 1);
    // Hits are sent in as many bits, without a sign.
    let most_hits = interface.total.map_or(u64::MAX, |_| (1 << bits) - 1);
    // In reset all outputs are 0.
    let at_rest = Ports {
        peaks: interface.peak.map_or(Vec::new(), |_| vec![(0, 0); inputs.level.len()]),
        ..Ports::default()
    };
    let mut out = vec![at_rest.clone(); clocks];
    // A group's results by the clock at which they arrive.
    let mut arrivals: Vec<Option<Results>> = vec![None; clocks];
    let mut t = 0;
    while t < clocks {
        if inputs.reset[t] {
            t += 1;
            continue;
        }
        let released = t;
        let end = (t..clocks).find(|&c| inputs.reset[c]).unwrap_or(clocks);
        arrivals.fill(None);
        let mut peaks = vec![None; clocks];
        let mut scan_counts: Vec<Vec<(u64, i64)>> = vec![Vec::new(); inputs.level.len()];
        let mut start = 0;
        // Steps that the delay lags behind.
        let mut lag = 0;
        'scans: loop {
            let groups = steps.div_ceil(parallel);
            let (mut group, mut first) = (0, start);
            let mut left_out = 0;
            while group < groups {
                let mut chips = integration;
                let within = released as u64..end as u64;
                let skips = inputs.skips.iter();
                for skip in skips.filter(|skip| within.contains(&skip.clock)) {
                    let chip = skip.clock.wrapping_sub((released + 1 + first) as u64);
                    if chip < chips as u64 {
                        assert_eq!((skip.chip, skip.group.0), (chip, group as u64));
                        chips -= skip.chips as usize;
                        group += skip.groups as usize;
                        left_out += skip.groups as usize * parallel;
                        lag += skip.groups as usize * parallel;
                    }
                }
                let word = released + first + chips;
                if word >= end {
                    break 'scans;
                }
                let mut counts = Vec::new();
                let detectors = interface.reference_codes.iter().zip(&inputs.level);
                for ((code, level), scan_counts) in detectors.zip(&mut scan_counts) {
                    for j in group * parallel..((group + 1) * parallel).min(steps) {
                        let first_step = scan.first_step as usize;
                        let k = (first_step + j + steps_per_period - lag % steps_per_period)
                            % steps_per_period;
                        let (mut count, mut hits) = (0i64, 0u64);
                        for cycle in first..first + chips {
                            for lane in 0..lanes {
                                let sample = (released + 1 + cycle) * lanes + lane;
                                if level[sample] && !level[sample - 1] {
                                    let delayed =
                                        (cycle * lanes + lane + steps_per_period * (1 + k) - k)
                                            % steps_per_period;
                                    hits += 1;
                                    count += 2 * i64::from(code.chips[delayed / lanes]) - 1;
                                }
                            }
                        }
                        counts.push((count, hits));
                        let told = (first_step + j - left_out) % steps_per_period;
                        scan_counts.push((told as u64, count.clamp(low, high)));
                    }
                }
                if let Some(peak) = interface.peak.filter(|_| group + 1 == groups) {
                    let found: Vec<_> = scan_counts.iter_mut().map(largest).collect();
                    let clock = word + peak.latency_clocks as usize;
                    if clock < end {
                        peaks[clock] = Some(found);
                    }
                }
                let arrival = word + interface.result_latency_clocks as usize;
                if arrival < end {
                    arrivals[arrival] = Some((counts, group + 1 == groups));
                }
                first += chips;
                group += 1;
            }
            start = if scan.is_full() && steps.is_multiple_of(parallel) {
                first
            } else {
                lag = 0;
                (first..).find(|n| n % period == 0).unwrap()
            };
        }
        let mut axis = at_rest.clone();
        // What is still to be sent, the next count last, and whether it ends a
        // scan.
        let mut unsent: Results = Default::default();
        for c in released..end {
            if axis.tvalid == 1 && inputs.ready[c] {
                unsent.0.pop();
            }
            if let Some((counts, last)) = arrivals[c].take() {
                let is_clamped = |&(n, hits): &(i64, u64)| n < low || n > high || hits > most_hits;
                axis.saturated |= u64::from(counts.iter().any(is_clamped));
                if unsent.0.is_empty() {
                    unsent = (counts.into_iter().rev().collect(), last);
                } else {
                    axis.overrun = 1;
                }
            }
            axis.tvalid = u64::from(!unsent.0.is_empty());
            if let Some(&(count, hits)) = unsent.0.last() {
                let bytes = bits.div_ceil(8);
                axis.tdata = count.clamp(low, high) as u128 & ((1 << (8 * bytes)) - 1);
                if interface.total.is_some() {
                    axis.tdata |= u128::from(hits.min(most_hits)) << (8 * bytes);
                }
                axis.tlast = u64::from(unsent.1 && unsent.0.len() == 1);
            }
            axis.peak_valid = u64::from(peaks[c].is_some());
            if let Some(peaks) = peaks[c].take() {
                axis.peaks = peaks
                    .into_iter()
                    .map(|(k, count): (u64, i64)| (k, count as u64 & (u64::MAX >> (64 - bits))))
                    .collect();
            }
            let cycle = c - released;
            out[c] = axis.clone();
            out[c].epoch = u64::from(cycle % period == 0);
            out[c].laser = interface
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

/// Step and value of the first of the largest counts of a scan, which it empties.
fn largest(counts: &mut Vec<(u64, i64)>) -> (u64, i64) {
    let mut found = counts[0];
    for &(step, count) in &counts[1..] {
        if count > found.1 {
            found = (step, count);
        }
    }
    counts.clear();
    found
}

fn event_driven(
    interface: &Interface,
    seed: u64,
    clocks: u64,
    block: u64,
    means: Means,
) -> (Inputs, Vec<Ports>) {
    let layout = Layout::of(interface);
    let lanes = interface.lanes() as usize;
    let mut adversary = Adversarial::with_means(interface, seed, means).unwrap();
    let mut reference = Reference::new(interface.clone()).unwrap();
    let detectors = interface.reference_codes.len();
    let mut levels = vec![Level::new(interface.lanes()); detectors];
    let mut inputs = Inputs {
        level: vec![vec![false; clocks as usize * lanes]; detectors],
        reset: vec![false; clocks as usize],
        ready: vec![true; clocks as usize],
        skips: Vec::new(),
    };
    let mut ports = Vec::new();
    let mut drive = Drive::new(detectors);
    let mut start = 0;
    while start < clocks {
        let end = (start + block).min(clocks);
        drive.start(start..end);
        adversary.drive(&mut drive);
        for (level, pulses) in inputs.level.iter_mut().zip(&drive.pulses) {
            for pulse in pulses {
                let to = (pulse.end.0 as usize).min(level.len());
                level[pulse.first.0 as usize..to].fill(true);
            }
        }
        for reset in &drive.surroundings.resets {
            inputs.reset[reset.start as usize..reset.end.min(clocks) as usize].fill(true);
        }
        inputs.skips.extend(&drive.surroundings.skips);
        for stall in &drive.surroundings.stalls {
            inputs.ready[stall.start as usize..stall.end.min(clocks) as usize].fill(false);
        }
        let mut hits = vec![Vec::new(); detectors];
        for ((level, pulses), hits) in levels.iter_mut().zip(&drive.pulses).zip(&mut hits) {
            level.paint(start..end, pulses, |_, _| (), hits);
        }
        let words = layout.outputs.words;
        let mut expected = vec![0; (end - start) as usize * words];
        reference.predict(&drive.surroundings, &hits, &mut expected);
        for record in expected.chunks_exact(words) {
            let read = |name| layout.outputs.field(name).read(record)[0];
            ports.push(Ports {
                laser: read("o_laser"),
                epoch: read("o_epoch"),
                tdata: {
                    let words = layout.outputs.field("m_axis_tdata").read(record);
                    words.iter().rev().fold(0, |data, &word| data << 64 | u128::from(word))
                },
                tvalid: read("m_axis_tvalid"),
                tlast: read("m_axis_tlast"),
                overrun: read("o_overrun"),
                saturated: if interface.saturates() { read("o_saturated") } else { 0 },
                ..peak_ports(interface, &layout, record)
            });
        }
        start = end;
    }
    (inputs, ports)
}

/// What the peak detector's ports show; no peaks until the first.
fn peak_ports(interface: &Interface, layout: &Layout, record: &[u64]) -> Ports {
    let Some(plan) = interface.peak else {
        return Ports::default();
    };
    let part = |name: &str, detector: u32, bits: u32| {
        let field = layout.outputs.field(name);
        let words = field.read(record);
        (0..bits).fold(0, |value, bit| {
            let at = (detector * bits + bit) as usize;
            value | (words[at / 64] >> (at % 64) & 1) << bit
        })
    };
    let detectors = interface.reference_codes.len() as u32;
    Ports {
        peak_valid: part("o_peak_valid", 0, 1),
        peaks: (0..detectors)
            .map(|d| {
                let step = part("o_peak_step", d, plan.step_bits);
                (step, part("o_peak_count", d, plan.count_bits))
            })
            .collect(),
        ..Ports::default()
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
    Interface {
        exact_count_bits: 45,
        count_bits: 45,
        total: Some(TotalCount { exact_bits: 44, bits: 44, first_bit: 48 }),
        tdata_bits: 96,
        ..interface
    }
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
    // Counts as wide as hours of integration need: results of more than a word.
    interfaces.push(with_wide_counts(Interface::of(&scenes[7])));
    for (i, interface) in interfaces.iter().enumerate() {
        for seed in 0..4 {
            let means = Means::cosim(seed % 2 == 1);
            let (inputs, predicted) = event_driven(interface, seed, 40_000, 1 << 12, means);
            let expected = clock_by_clock(interface, &inputs);
            let differs = (0..expected.len()).find(|&c| expected[c] != predicted[c]);
            if let Some(clock) = differs {
                panic!(
                    "scene {i}, seed {seed}, clock {clock}: expected {:?}, predicted {:?}",
                    expected[clock], predicted[clock]
                );
            }
            let seen = |port: fn(&Ports) -> u64| expected.iter().any(|p| port(p) == 1);
            assert!(seen(|p| p.tvalid) && seen(|p| p.overrun), "scene {i}");
            assert_eq!(seen(|p| p.saturated), interface.saturates(), "scene {i}");
            assert_eq!(seen(|p| p.peak_valid), interface.peak.is_some(), "scene {i}");
        }
    }
}

#[test]
fn the_size_of_the_blocks_changes_nothing() {
    let scene = scene(8, r#"{ family = "gold", degree = 5 }"#, "integration = \"320 ns\"", "");
    let interface = Interface::of(&scene);
    let means = Means::cosim(true);
    let (_, whole) = event_driven(&interface, 7, 20_000, 20_000, means);
    for block in [1, 2, 3, 97, 4096] {
        assert!(event_driven(&interface, 7, 20_000, block, means).1 == whole, "blocks of {block}");
    }
}

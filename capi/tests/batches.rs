//! The model in batches, which has hits from sample words, against the model of
//! co-simulation, which has them from pulses and never sees a word.

use std::ops::Range;
use std::path::{Path, PathBuf};

use goldtof::batch::{BatchInputs, HostInputs, Model};
use goldtof::photons::Pulse;
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::host_ports::HostClocks;
use goldtof::reference::predictor::ReferenceModel;
use goldtof::reference::stimulus::{Drive, Stimulus};
use goldtof::scan::{Sample, Sampling};
use goldtof::scene;
use goldtof::sensor::Sensor;
use goldtof::sensor::interface::Interface;
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;

const CLOCKS: u64 = 40_000;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Pulses, stalls and resets without an aim; of all kinds, also over many clocks.
struct Noise {
    pulses: Vec<Vec<Pulse>>,
    resets: Vec<Range<u64>>,
    stalls: Vec<Range<u64>>,
    /// Of a sensor with registers.
    host: HostClocks,
    sampling: Sampling,
}

impl Noise {
    fn of(interface: &Interface) -> Noise {
        let sampling = interface.timing.sampling();
        let lanes = sampling.samples_of(1);
        let mut state = 7u64;
        let mut below = |bound: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % bound
        };
        let detectors = 0..interface.reference_codes.len();
        let pulses = detectors.map(|_| {
            let (mut at, mut pulses) = (0, Vec::new());
            while at < CLOCKS * lanes {
                at += below(6 * lanes);
                let end = at + 1 + below(2 * lanes);
                pulses.push(Pulse { first: Sample(at), end: Sample(end) });
                at += 1;
            }
            pulses.retain(|pulse| pulse.first < sampling.first_sample(CLOCKS));
            pulses
        });
        let pulses = pulses.collect();
        // It writes here and there, also what does not fit, and keeps no rule.
        let addresses = [0x18, 0x1c, 0x20, 0x24, 0x400, 0x404, 0x500];
        let mut host = HostClocks::new();
        while interface.registers.is_some() && host.last().is_none_or(|(at, _)| at.end < CLOCKS) {
            let from = host.last().map_or(0, |(at, _)| at.end) + below(40);
            let address = addresses[below(7) as usize];
            let inputs = HostInputs {
                write_address_valid: below(2) == 1,
                write_address: address,
                write_valid: below(2) == 1,
                write_data: below(64) as u32,
                write_strobe: 0xf >> (below(8) / 7),
                write_response_ready: below(2) == 1,
                read_address_valid: below(2) == 1,
                read_address: address,
                read_ready: below(2) == 1,
            };
            host.push((from..from + 1 + below(4), inputs));
        }
        Noise {
            host,
            pulses,
            resets: vec![0..4, 4_095..4_097, 13_000..13_001, 20_000..21_111],
            stalls: vec![0..9, 6_000..7_500, 14_335..14_336, 25_000..31_000],
            sampling,
        }
    }
}

impl Stimulus for Noise {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        drive.surroundings.resets.clone_from(&self.resets);
        drive.surroundings.stalls.clone_from(&self.stalls);
        let is_here =
            |(at, _): &&(Range<u64>, HostInputs)| at.start < clocks.end && at.end > clocks.start;
        drive.surroundings.host = self.host.iter().filter(is_here).cloned().collect();
        for (to, pulses) in drive.pulses.iter_mut().zip(&self.pulses) {
            let here = |pulse: &&Pulse| clocks.contains(&self.sampling.clock_of(pulse.first));
            to.extend(pulses.iter().filter(here));
        }
    }
}

/// Words, and what the model of co-simulation, which has hits from pulses and never
/// sees a word, expects of them.
fn driven(sensor: &Sensor) -> (Vec<u64>, Vec<u64>) {
    let layout = Layout::of(sensor.interface());
    let mut reference = ReferenceModel::new(sensor.interface().clone()).unwrap();
    let mut noise = Noise::of(sensor.interface());
    let mut maker = BlockMaker::new(&mut reference, &mut noise, &layout, CLOCKS);
    let (mut inputs, mut expected) = (Vec::new(), Vec::new());
    let mut block = Block::default();
    while maker.make(&mut block) {
        inputs.extend_from_slice(&block.records.inputs);
        expected.extend_from_slice(&block.records.expected);
    }
    (inputs, expected)
}

/// What a record has at the ports that a host drives.
fn host_of(layout: &Layout, record: &[u64]) -> HostInputs {
    let mut host = HostInputs::default();
    for field in &layout.inputs.fields {
        host.set(field.port.role, field.low_word(record));
    }
    host
}

#[test]
fn batches_of_any_size_give_what_cosimulation_expects() {
    for scene in [
        "scenes/quick.toml",
        "tests/scenes/peak.toml",
        "scenes/dual-view.toml",
        "tests/scenes/registers.toml",
    ] {
        let scene = scene::load(&root().join(scene)).unwrap();
        let sensor = Sensor::new(&scene);
        let (records, expected) = driven(&sensor);
        let layout = Layout::of(sensor.interface());
        let detectors = sensor.interface().reference_codes.len();
        let lanes = sensor.interface().lanes();
        let records: Vec<_> = records.chunks_exact(layout.inputs.words).collect();
        let level = |name| {
            let field = layout.inputs.field(name);
            records.iter().map(|r| field.low_word(r) as u8).collect()
        };
        let (reset, ready): (Vec<u8>, Vec<u8>) = (level(PortRole::Reset), level(PortRole::Ready));
        assert_eq!(reset.iter().map(|&r| u64::from(r)).sum::<u64>(), 4 + 2 + 1 + 1111);
        let samples: Vec<u64> = records
            .iter()
            .flat_map(|record| {
                let field = layout.inputs.field(PortRole::Samples);
                (0..detectors as u32).map(|d| field.bits(record, d * lanes, lanes))
            })
            .collect();
        let host: Vec<HostInputs> = match sensor.interface().registers {
            None => Vec::new(),
            Some(_) => records.iter().map(|record| host_of(&layout, record)).collect(),
        };
        for size in [1, 7, 4096, 40_000] {
            let mut model = Model::new(&sensor).unwrap();
            let (mut all, mut outputs, mut results) = (Vec::new(), Vec::new(), 0);
            for from in (0..records.len()).step_by(size) {
                let to = (from + size).min(records.len());
                let inputs = BatchInputs {
                    samples: &samples[from * detectors..to * detectors],
                    reset: &reset[from..to],
                    ready: &ready[from..to],
                    host: host.get(from..to).unwrap_or(&[]),
                };
                model.clock(&inputs, &mut outputs).unwrap();
                all.extend_from_slice(&outputs);
                results += model.take_results().count();
            }
            assert!(all == expected, "{}: batches of {size}", scene.name);
            assert!(results > 0);
        }
    }
}

//! Light on the board's own core, and what has to come of it.

use goldtof_wire::{MOST_RESULTS_OF_A_FRAME, REQUEST_IDENTITY, REQUEST_WRITE, encode};
use rand::RngExt as _;

use super::maker::Maker;
use super::model::Facts;
use super::script::{BoardScript, ExpectedAnswer, Offer, PinPulse};
use crate::cosim::error::CosimError;
use crate::photons::Pulse;
use crate::reference::level::LevelPainter;
use crate::reference::predictor::{ReferenceModel, Surroundings};
use crate::reference::stimulus::RESET_CLOCKS;
use crate::scan::Sample;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;
use crate::sensor::registers::Access;

/// Light on the board's own core, whose results are the reference model's, and its registers.
pub(super) fn whole(sensor: &Sensor, facts: &Facts, seed: u64) -> Result<BoardScript, CosimError> {
    let mut maker = Maker::new(facts, seed);
    let interface = sensor.interface();
    let lanes = u64::from(interface.lanes());
    let detectors = interface.reference_codes.len();
    // A scan, or those of a sum, and how the next one begins; or as much of one as there is time for: a few results at
    // least.
    let scan = interface.scan_clocks();
    let whole = u64::from(interface.accumulate.max(1)) * scan + scan / 8;
    let least = if facts.sums.is_some() { whole } else { 4 * scan / interface.groups() };
    let clocks = whole.min(1_000_000.max(least));
    let mut pulses: Vec<Vec<Pulse>> = vec![Vec::new(); detectors];
    for pulses in &mut pulses {
        let mut at = maker.rng.random_range(0..lanes);
        while at < clocks * lanes {
            let samples = maker.rng.random_range(1..=2 * lanes);
            pulses.push(Pulse { first: Sample(at), end: Sample(at + samples) });
            at += samples + maker.rng.random_range(1..=8 * lanes);
        }
    }
    maker.script.offers = sent(sensor, &pulses, clocks)?;
    let mut pins: Vec<PinPulse> = Vec::new();
    for (detector, pulses) in (0..).zip(&pulses) {
        pins.extend(pulses.iter().map(|pulse| {
            let samples = (pulse.end.0 - pulse.first.0) as u32;
            PinPulse { first: pulse.first.0, samples, detector }
        }));
    }
    pins.sort_by_key(|pulse| pulse.first);
    maker.script.photons = Some(pins);

    if let Some(plan) = &interface.registers {
        // What it holds at first; and then, with no scan to come that it would change, what is written.
        for register in plan.map(&interface.timing, &interface.source_codes) {
            let resets: Option<Vec<u32>> =
                register.fields.iter().map(|field| Some(field.reset? << field.first_bit)).collect();
            let Some(resets) = resets else { continue };
            let value = resets.into_iter().fold(0, |all, bits| all | bits);
            maker.read_register(register.address as u16, value);
        }
        maker.pause_until(clocks as f64 / facts.chips_per_bit * 1.01 + 100.0);
        for register in plan.map(&interface.timing, &interface.source_codes) {
            let is_setting = register.fields.iter().all(|field| field.access == Access::ReadWrite);
            let [field] = &register.fields[..] else { continue };
            if !is_setting {
                continue;
            }
            let value = field.reset.unwrap_or_default() ^ 0b101 & (u32::MAX >> (32 - field.width));
            let (mut request, _) = maker.request(REQUEST_WRITE, register.address as u16);
            request.address = register.address as u16;
            maker.say(&encode::request(request, value));
            maker.era().answers.push(ExpectedAnswer::Written(request, 0));
            maker.await_answer(request, MOST_RESULTS_OF_A_FRAME);
            maker.read_register(register.address as u16, value);
        }
    }
    let asked = maker.request(REQUEST_IDENTITY, 0);
    maker.ask(asked, MOST_RESULTS_OF_A_FRAME);
    // The last results are on their way: a few, or a whole scan that came at once.
    let at_once = facts.sums.is_some() || facts.packing.waits;
    let late = if at_once { facts.results_of_scan } else { 0 };
    let drain = facts.chips_of_results(late + MOST_RESULTS_OF_A_FRAME);
    maker.script.chips = clocks + (drain + 1000.0 * facts.chips_per_bit) as u64;
    Ok(maker.script)
}

/// What the reference model says that the core sends, with this light from its first chip on.
fn sent(sensor: &Sensor, pulses: &[Vec<Pulse>], clocks: u64) -> Result<Vec<Offer>, CosimError> {
    const BLOCK: u64 = 1 << 12;
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let mut reference = ReferenceModel::new(interface.clone())?;
    let sampling = interface.timing.sampling();
    let behind_reset = sampling.first_sample(RESET_CLOCKS + 1);
    let mut levels = vec![LevelPainter::new(interface.lanes()); pulses.len()];
    let mut next = vec![0; pulses.len()];
    let words = reference.words();
    let mut expected = vec![0; words * BLOCK as usize];
    let [valid, last, data] = [PortRole::Valid, PortRole::Last, PortRole::Data]
        .map(|role| layout.outputs.field(role).clone());
    let mut offers = Vec::new();
    let reset = 0..RESET_CLOCKS;
    for start in (0..clocks + RESET_CLOCKS).step_by(BLOCK as usize) {
        let block = Surroundings {
            clocks: start..start + BLOCK,
            resets: vec![reset.clone()],
            ..Surroundings::default()
        };
        let samples = sampling.samples(&block.clocks);
        let mut hits = vec![Vec::new(); pulses.len()];
        for detector in DetectorIndex::of(pulses) {
            let d = detector.0;
            let shifted = pulses[d][next[d]..].iter().map(|pulse| Pulse {
                first: pulse.first + behind_reset.0,
                end: pulse.end + behind_reset.0,
            });
            let now: Vec<Pulse> = shifted.take_while(|pulse| pulse.first < samples.end).collect();
            next[d] += now.len();
            levels[d].paint(block.clocks.clone(), &now, |_, _| (), &mut hits[d]);
        }
        reference.predict(&block, &hits, &mut expected);
        for record in expected.chunks_exact(words) {
            if valid.low_word(record) == 1 {
                let words = data.read(record).into_iter();
                let tdata = words.flat_map(|word| [word as u32, (word >> 32) as u32]).collect();
                offers.push(Offer { wait: 0, tdata, last: last.low_word(record) == 1 });
            }
        }
    }
    Ok(offers)
}

//! What is done to a board: results at every rate, requests whole and torn, resets, light.

use std::collections::BTreeMap;

use goldtof_wire::{
    Answer, BLOCK_BYTES, Frame, REQUEST_BYTES, REQUEST_HITS, REQUEST_IDENTITY, REQUEST_READ,
    REQUEST_TEXT, REQUEST_WRITE, Request, encode,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::line::Cover;
use super::model::Facts;
use super::script::{Expected, Offer, PinPulse, Script};
use crate::cosim::error::CosimError;
use crate::photons::Pulse;
use crate::reference::level::Level;
use crate::reference::predictor::{Reference, Surroundings};
use crate::reference::stimulus::RESET_CLOCKS;
use crate::scan::Sample;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;
use crate::sensor::port::Role;
use crate::sensor::registers::Access;

/// A run of the board.
pub(super) struct Run {
    pub name: &'static str,
    /// Whether it says anything of the board.
    pub is_meant: fn(&Facts) -> bool,
    pub script: fn(&Sensor, &Facts, u64) -> Result<Script, CosimError>,
}

/// All of them, those of the board's own core last.
pub(super) const RUNS: [Run; 8] = [
    Run {
        name: "requests, whole and torn, of a host that sends 2 % faster and reads slower",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(requests(facts, seed, (0.98, 1.02), &[0, 1])),
    },
    Run {
        name: "requests, whole and broken, of a host that sends 2 % slower and reads faster",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(requests(facts, seed.wrapping_add(1), (1.02, 0.98), &[2])),
    },
    Run {
        name: "results at 94 % of the line's rate",
        is_meant: |facts| facts.sums.is_none(),
        script: |_, facts, seed| Ok(sustained(facts, seed)),
    },
    Run {
        name: "results faster than the line",
        is_meant: |facts| !facts.packing.waits && facts.sums.is_none(),
        script: |_, facts, seed| Ok(too_fast(facts, seed)),
    },
    Run {
        name: "results of a core that waits for the line",
        is_meant: |facts| facts.packing.waits,
        script: |_, facts, seed| Ok(waiting(facts, seed)),
    },
    Run {
        name: "resets by the PLL's lock",
        is_meant: |_| true,
        script: |_, facts, seed| Ok(resets(facts, seed)),
    },
    Run {
        name: "hits by sample",
        is_meant: |facts| facts.identity.counts_samples,
        script: |_, facts, seed| Ok(hits(facts, seed)),
    },
    Run { name: "the board's own core", is_meant: |_| true, script: whole },
];

/// Bits of silence that end a torn request, and some more.
const SILENCE: u32 = 300;

/// What a script is made with.
struct Maker<'a> {
    facts: &'a Facts,
    rng: Xoshiro256PlusPlus,
    script: Script,
    /// What the host has written.
    words: BTreeMap<u16, u32>,
}

impl<'a> Maker<'a> {
    fn new(facts: &'a Facts, seed: u64) -> Maker<'a> {
        let script = Script { rates: (1.0, 1.0), ..Script::default() };
        let rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut maker = Maker { facts, rng, script, words: BTreeMap::new() };
        // The first request shall not fall into the board's reset.
        maker.pause(SILENCE);
        maker
    }

    fn command(&mut self, command: &str) {
        self.script.host.push_str(command);
        self.script.host.push('\n');
    }

    fn pause(&mut self, bits: u32) {
        self.command(&format!("bits {bits}"));
        self.script.bits += f64::from(bits);
    }

    fn say(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.command(&format!("byte {byte:02x}"));
        }
        self.script.bits += 10.0 * bytes.len() as f64;
    }

    /// Until a frame of so many results and the answer behind it are through.
    fn pause_for_answer(&mut self, results: usize) {
        // Sums come at once, and fill their frames.
        let results = if self.facts.sums.is_some() { 255 } else { results };
        let frame = 14 + self.facts.layout.payload_bytes(results);
        // A register may take 300 bits.
        let late = if self.facts.has_registers { 320 } else { 0 };
        self.pause((10.4 * (frame + 44) as f64) as u32 + 60 + late);
    }

    fn request(&mut self, kind: u8, address: u16) -> (Request, u32) {
        (Request { kind, tag: self.rng.random(), address }, self.rng.random())
    }

    /// A request of any kind.
    fn any_request(&mut self) -> (Request, u32) {
        let kinds = [
            REQUEST_IDENTITY,
            REQUEST_READ,
            REQUEST_READ,
            REQUEST_WRITE,
            REQUEST_WRITE,
            REQUEST_TEXT,
        ];
        let kind = kinds[self.rng.random_range(0..kinds.len())];
        let address = match kind {
            REQUEST_TEXT => BLOCK_BYTES as u16 * self.rng.random_range(0..self.blocks()),
            // Now and then an address that was written to before.
            REQUEST_READ if !self.words.is_empty() && self.rng.random() => {
                let number = self.rng.random_range(0..self.words.len());
                self.words.keys().nth(number).copied().unwrap_or_default()
            }
            _ => 4 * self.rng.random_range(0..0x400),
        };
        self.request(kind, address)
    }

    /// Blocks of text to be asked for.
    fn blocks(&self) -> u16 {
        self.facts.text.len().div_ceil(BLOCK_BYTES).max(1) as u16
    }

    /// Asks, and expects the answer.
    fn ask(&mut self, (request, data): (Request, u32)) {
        self.say(&encode::request(request, data));
        self.expect(request, data);
    }

    /// Expects the answer of a request that has been said.
    fn expect(&mut self, request: Request, data: u32) {
        let facts = self.facts;
        let address = request.address;
        let status = if address >= 0xc00 {
            3
        } else if address >= 0x800 {
            2
        } else {
            0
        };
        let name = ["OKAY", "", "SLVERR", "DECERR"][usize::from(status)];
        let expected = match request.kind {
            REQUEST_WRITE if facts.has_registers => {
                self.script.transfers.push(format!("W {address:x} {data:x} {status:x}"));
                if status == 0 {
                    self.words.insert(address, data);
                }
                self.script.points.push(format!("a write that is answered with {name}"));
                Expected::Written(request, status)
            }
            REQUEST_READ if facts.has_registers => {
                let written = self.words.get(&address).copied().filter(|_| status == 0);
                let data = written.unwrap_or(0xdead_0000 + u32::from(address));
                self.script.transfers.push(format!("R {address:x} {data:x} {status:x}"));
                self.script.points.push(format!("a read that is answered with {name}"));
                Expected::Frame(Frame::Answer(Answer { request, status, data }))
            }
            REQUEST_TEXT | REQUEST_HITS => {
                let mut block = facts.identity.to_bytes();
                if request.kind == REQUEST_TEXT && !facts.text.is_empty() {
                    block = [0; BLOCK_BYTES];
                    let bytes = facts.text.bytes().skip(address.into());
                    block.iter_mut().zip(bytes).for_each(|(place, byte)| *place = byte);
                    self.script.points.push("a block of the scene's text".to_owned());
                }
                Expected::Frame(Frame::Block(request, block))
            }
            _ => Expected::Frame(Frame::Identity(request, Ok(facts.identity))),
        };
        self.script.answers.push(expected);
    }

    /// Offers results of scans with so many each; `wait` gives the clocks before each.
    fn offer(&mut self, scan: usize, mut wait: impl FnMut(&mut Xoshiro256PlusPlus, usize) -> u64) {
        let words = self.facts.packing.tdata_bits.div_ceil(32) as usize;
        let unused = 32 * words as u32 - self.facts.packing.tdata_bits;
        for number in 0..scan {
            // Now and then bytes that look like a frame's beginning, all ones, or one bit.
            let mut tdata: Vec<u32> = match self.rng.random_range(0..8) {
                0 => vec![0xa543_a543; words],
                1 => vec![u32::MAX; words],
                2 => vec![0; words],
                _ => (0..words).map(|_| self.rng.random()).collect(),
            };
            tdata[words - 1] &= u32::MAX >> unused;
            let wait = wait(&mut self.rng, number);
            self.script.offers.push(Offer { wait, tdata, last: number + 1 == scan });
        }
    }

    /// Results of a scan: the scene's where scans are added up, else any number up to `most`.
    fn scan(&mut self, most: usize) -> usize {
        match &self.facts.sums {
            Some(sums) => sums.results as usize,
            None => self.rng.random_range(1..=most),
        }
    }

    /// Spreads some hundred results, or sums, over the bits of the script.
    fn offer_over_script(&mut self, results: usize) {
        let facts = self.facts;
        let scans = facts.sums.map_or(1, |sums| sums.scans as usize);
        let frame = facts.results_of_scan as usize * scans;
        let count = match facts.sums {
            Some(_) => results.max(2 * frame),
            // The line takes twice as many.
            None => results.min(
                (self.script.bits / (2.5 * facts.layout.result_bits() as f64 + 50.0)) as usize,
            ),
        };
        let gap = self.script.bits * facts.chips_per_bit / count as f64;
        while self.script.offers.len() < count {
            let scan = self.scan(60);
            self.offer(scan, |rng, _| rng.random_range(0.0..=1.9 * gap) as u64);
        }
    }

    /// Chips that a result takes on a line that is full.
    fn chips_per_result(&self) -> f64 {
        let most = goldtof_wire::MOST_RESULTS_OF_A_FRAME as usize;
        let frame = 14 + self.facts.layout.payload_bytes(most);
        10.0 * frame as f64 / most as f64 * self.facts.chips_per_bit
    }
}

/// Requests of every kind, whole and torn in these ways (0: cut, 1: a wrong bit, 2: a byte without its stop bit), each of
/// the torn ones before one that is answered; results between them, and the core's flags.
fn requests(facts: &Facts, seed: u64, rates: (f64, f64), ways: &[usize]) -> Script {
    let mut maker = Maker::new(facts, seed);
    maker.script.rates = rates;
    let mut torn: Vec<(usize, usize)> = Vec::new();
    for &way in ways {
        torn.extend((usize::from(way != 1)..REQUEST_BYTES).map(|byte| (way, byte)));
    }
    // And whole ones among them.
    torn.extend([(3, 0); 30]);
    // Kinds a bit away from those of registers.
    torn.extend((0..16).map(|bit| (4, bit)));
    let (count, mut flags) = (torn.len(), vec![0, 1, 3, 2, 0].into_iter());
    for number in 0..count {
        if number % (count / 5) == 0
            && let Some(next) = flags.next()
        {
            maker.command(&format!("flags {next}"));
            maker.script.flags.push(next);
        }
        let (way, byte) = torn.swap_remove(maker.rng.random_range(0..torn.len()));
        let asked = maker.any_request();
        let mut bytes = encode::request(asked.0, asked.1);
        match way {
            0 => {
                maker.say(&bytes[..byte]);
                maker
                    .script
                    .points
                    .push(format!("a request that is torn behind byte {}", byte - 1));
            }
            1 => {
                bytes[byte] ^= 1 << maker.rng.random_range(0..8_u32);
                maker.say(&bytes);
                maker.script.points.push(format!("a request with a wrong bit in byte {byte}"));
            }
            2 => {
                maker.say(&bytes[..byte]);
                maker.command("low 12");
                maker.pause(3);
                // The rest is of no request, or of another one that is whole.
                match byte % 2 {
                    0 => maker.say(&bytes[byte..]),
                    // What follows the break may look like a byte.
                    _ => {
                        maker.pause(12);
                        let whole = maker.any_request();
                        maker.ask(whole);
                        maker.pause_for_answer(8);
                    }
                }
                maker.script.points.push(format!("a byte without its stop bit before byte {byte}"));
            }
            4 => {
                let kind = [REQUEST_READ, REQUEST_WRITE][byte / 8] ^ 1 << (byte % 8);
                let other = maker.request(kind, 0x104);
                maker.ask(other);
                maker.script.points.push("a request of an unknown kind".to_owned());
            }
            _ => match maker.rng.random_range(0..5) {
                2 => {
                    maker.ask(asked);
                    // The device does not listen until the answer has been sent, which takes longer.
                    let other = maker.any_request();
                    maker.say(&encode::request(other.0, other.1));
                    maker.script.points.push("a request while one is answered".to_owned());
                }
                0 => {
                    let pause = maker.rng.random_range(1..REQUEST_BYTES);
                    maker.say(&bytes[..pause]);
                    maker.pause(200);
                    maker.say(&bytes[pause..]);
                    maker.expect(asked.0, asked.1);
                    maker.script.points.push("a pause within a request".to_owned());
                }
                _ => maker.ask(asked),
            },
        }
        if way < 3 {
            maker.pause(SILENCE);
            let asked = maker.any_request();
            maker.ask(asked);
        }
        maker.pause_for_answer(8);
    }
    maker.offer_over_script(500);
    maker.made()
}

/// Results that come evenly, a little less fast than the line takes them, and requests among them.
fn sustained(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    let spacing = maker.chips_per_result() / 0.94;
    let mut sent = 0.0_f64;
    let results = 2500;
    let mut offered = 0;
    while offered < results {
        let scan = maker.rng.random_range(1000..2000);
        maker.offer(scan, |_, _| {
            let before = sent;
            sent += spacing;
            // A result has a clock of its own.
            (sent.floor() - before.floor() - 1.0).max(0.0) as u64
        });
        offered += scan;
    }
    // Few requests: an answer takes as long as twenty results.
    for _ in 0..3 {
        let asked = maker.any_request();
        maker.ask(asked);
        maker.pause_for_answer(300);
        maker.pause(4000);
    }
    maker.made()
}

/// Bursts and scans that the line is too slow for: lost scan by scan, and told.
fn too_fast(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    let depth = 1_usize << facts.fifo_address_bits;
    let chips = maker.chips_per_result();
    // As many as there is room for, at once; and time for them.
    let first = depth - 32;
    maker.offer(first, |rng, number| u64::from(number > 0 && rng.random_range(0..8) == 0));
    maker.script.may_lose_behind = Some(first);
    // It goes full; scans are taken again from where it is less than half full.
    maker.pause((20.0 * depth as f64 * maker.facts.layout.result_bits() as f64 / 8.0) as u32);
    maker.offer(depth, |_, _| 0);
    for (drained, comes) in [(0.3, false), (0.3, true)] {
        maker.script.scans.push((maker.script.offers.len(), comes));
        let wait = drained * chips * depth as f64;
        maker.offer(20, |_, number| if number == 0 { wait as u64 } else { 0 });
    }
    // And a scan that is cut is lost to its end, however much room there is by then.
    maker.offer(depth + 100, |_, number| {
        if number < depth { 0 } else { (0.008 * chips * depth as f64) as u64 }
    });
    for number in 0..12 {
        let scan = match number % 4 {
            0 => maker.rng.random_range(1..depth / 2 - 16),
            1 => maker.rng.random_range(1..40),
            2 => maker.rng.random_range(depth / 4..2 * depth),
            // Two of them are more than the number of lost results has bits.
            _ if number % 8 == 3 => 40_000 + depth,
            _ => depth / 2 - 17,
        };
        let pause = maker.rng.random_range(0.0..0.9) * chips * scan.min(2 * depth) as f64;
        // Those that go the number round would take as many chips as all else.
        let is_burst = scan > 2 * depth || maker.rng.random_range(0..3) > 0;
        maker.offer(scan, |rng, number| match number {
            0 => pause as u64,
            _ if is_burst => 0,
            _ => rng.random_range(0.0..chips) as u64,
        });
        let asked = maker.request(REQUEST_IDENTITY, 0);
        maker.ask(asked);
        maker.pause_for_answer(255);
    }
    // A loss is told with the result that comes next: the last scan comes late, and leaves time.
    let late = 1.5 * chips * depth as f64;
    maker.offer(20, |_, number| if number == 0 { late as u64 } else { 0 });
    maker.made()
}

/// A source that waits: nothing is lost, and the line is full.
fn waiting(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    maker.script.keeps_line_full = true;
    let mut offered = 0;
    while offered < 3 << facts.fifo_address_bits {
        let scan = maker.rng.random_range(1500..3000);
        maker.offer(scan, |_, _| 0);
        offered += scan;
    }
    maker.made()
}

/// Resets in the middle of whatever goes on, behind which everything begins anew.
fn resets(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    for round in 0..12 {
        maker.command("slow 1");
        let asked = maker.any_request();
        let bytes = encode::request(asked.0, asked.1);
        match round % 3 {
            0 => maker.say(&bytes[..1 + round]),
            1 => {
                maker.say(&bytes);
                let transfer = maker.request(REQUEST_WRITE, 0x100);
                maker.say(&encode::request(transfer.0, transfer.1));
            }
            _ => {
                maker.say(&bytes);
                let behind = maker.rng.random_range(0..300);
                maker.pause(behind);
            }
        }
        if round % 3 == 1 {
            maker.pause_for_answer(40);
        }
        let lasts = maker.rng.random_range(1..30);
        maker.command(&format!("unlock {lasts}"));
        maker.command("slow 0");
        maker.pause(100 + lasts);
        let asked = maker.any_request();
        maker.ask(asked);
        maker.pause_for_answer(60);
        if round < 11 {
            let asked = std::mem::take(&mut maker.script.answers);
            maker.script.answers_before.push(asked);
            maker.script.transfers.clear();
        }
    }
    for _ in 0..4 {
        let asked = maker.any_request();
        maker.ask(asked);
        maker.pause_for_answer(60);
    }
    maker.offer_over_script(400);
    maker.made()
}

/// Hits by sample: what is counted between two dark moments.
fn hits(facts: &Facts, seed: u64) -> Script {
    let mut maker = Maker::new(facts, seed);
    let words =
        usize::from(facts.identity.detectors) * usize::from(facts.identity.samples_per_chip);
    maker.script.host = format!("light 0\n{}", maker.script.host);
    for is_behind in [false, true] {
        for first in (0..words).step_by(BLOCK_BYTES / 4) {
            let (request, data) = maker.request(REQUEST_HITS, 4 * first as u16);
            maker.say(&encode::request(request, data));
            maker.script.answers.push(Expected::Hits(request, first, is_behind));
            maker.pause_for_answer(1);
        }
        if !is_behind {
            maker.command("light 1");
            maker.pause(1500);
            maker.command("light 0");
            maker.pause(100);
        }
    }
    maker.made()
}

/// Light on the board's own core, whose results are the reference model's, and its registers.
fn whole(sensor: &Sensor, facts: &Facts, seed: u64) -> Result<Script, CosimError> {
    let mut maker = Maker::new(facts, seed);
    let interface = sensor.interface();
    let lanes = u64::from(interface.lanes());
    let detectors = interface.reference_codes.len();
    // Two scans, or as much of one as there is time for: a few results at least.
    let scans = u64::from(interface.accumulate) + 1;
    let least = match interface.accumulate {
        0 | 1 => 4 * interface.scan_clocks() / interface.groups(),
        summed => u64::from(summed) * interface.scan_clocks() + interface.scan_clocks() / 8,
    };
    let clocks = (scans * interface.scan_clocks()).min(1_500_000.max(least));
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
        let until = clocks as f64 / facts.chips_per_bit * 1.01;
        maker.pause((until - maker.script.bits).max(0.0) as u32 + 100);
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
            maker.script.answers.push(Expected::Written(request, 0));
            maker.pause_for_answer(255);
            maker.read_register(register.address as u16, value);
        }
    }
    let asked = maker.request(REQUEST_IDENTITY, 0);
    maker.ask(asked);
    maker.pause_for_answer(255);
    // The last results are on their way: a few, or a whole scan that came at once.
    let at_once = facts.sums.is_some() || facts.packing.waits;
    let results = if at_once { facts.results_of_scan + 255 } else { 255 };
    let drain = maker.chips_per_result() / facts.chips_per_bit * results as f64;
    let bits = maker.script.bits.max(clocks as f64 / facts.chips_per_bit) + drain + 2000.0;
    maker.script.chips = (bits * facts.chips_per_bit) as u64;
    Ok(maker.script)
}

impl Maker<'_> {
    /// The script, with a limit for a board whose line never falls silent.
    fn made(mut self) -> Script {
        let waits: f64 = self.script.offers.iter().map(|offer| offer.wait as f64).sum();
        let line = self.script.offers.len() as f64 * 20.0 * self.facts.layout.result_bits() as f64;
        let bits = 2.0 * self.script.bits + line + 10_000.0;
        self.script.chips = (2.0 * waits + bits * self.facts.chips_per_bit) as u64;
        self.script
    }

    fn read_register(&mut self, address: u16, value: u32) {
        let (request, data) = self.request(REQUEST_READ, address);
        self.say(&encode::request(request, data));
        let answer = Answer { request, status: 0, data: value };
        self.script.answers.push(Expected::Frame(Frame::Answer(answer)));
        self.script.points.push("registers of the board's own core".to_owned());
        self.pause_for_answer(255);
    }
}

/// What the reference model says that the core sends, with this light from its first chip on.
fn sent(sensor: &Sensor, pulses: &[Vec<Pulse>], clocks: u64) -> Result<Vec<Offer>, CosimError> {
    const BLOCK: u64 = 1 << 12;
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let mut reference = Reference::new(interface.clone())?;
    let sampling = interface.timing.sampling();
    let behind_reset = sampling.first_sample(RESET_CLOCKS + 1);
    let mut levels = vec![Level::new(interface.lanes()); pulses.len()];
    let mut next = vec![0; pulses.len()];
    let words = reference.words();
    let mut expected = vec![0; words * BLOCK as usize];
    let [valid, last, data] =
        [Role::Valid, Role::Last, Role::Data].map(|role| layout.outputs.field(role).clone());
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

impl Facts {
    /// Situations that the runs are there for.
    pub(super) fn cover_points(&self) -> Cover {
        let mut points: Vec<String> = Vec::new();
        for byte in 0..REQUEST_BYTES {
            let mut add = |text: &str| points.push(format!("{text} byte {byte}"));
            if byte + 1 < REQUEST_BYTES {
                add("a request that is torn behind");
            }
            add("a request with a wrong bit in");
            if byte > 0 {
                add("a byte without its stop bit before");
            }
        }
        let mut add = |text: &str, is_meant: bool| {
            if is_meant {
                points.push(text.to_owned());
            }
        };
        add("a pause within a request", true);
        add("a request of an unknown kind", true);
        add("a request while one is answered", true);
        add("a block of the scene's text", !self.text.is_empty());
        for answer in ["OKAY", "SLVERR", "DECERR"] {
            add(&format!("a write that is answered with {answer}"), self.has_registers);
            add(&format!("a read that is answered with {answer}"), self.has_registers);
        }
        let (loses, waits) = (!self.packing.waits && self.sums.is_none(), self.packing.waits);
        add("an answer between frames of results", true);
        add("a frame of one result", self.sums.is_none());
        add("a frame of 255 results", self.sums.is_none() || self.results_of_scan > 255);
        add("a frame that ends a scan", true);
        add("a frame within a scan", true);
        add("the sequence number goes round", self.sums.is_none());
        add("places beyond 8 bits", self.sums.is_none() || self.results_of_scan > 256);
        add("the FIFO's places go round", loses || waits);
        add("results are lost", loses);
        add("a scan is whole behind a loss", loses);
        add("a scan is lost with the FIFO more than half full", loses);
        add("a scan is taken with the FIFO less than half full", loses);
        add("the number of lost results goes round", loses);
        add("the core waits for the line", waits);
        add("o_overrun is told", true);
        add("o_saturated is told", self.has_saturated);
        add("a reset within a frame", true);
        if self.identity.counts_samples {
            let samples =
                usize::from(self.identity.detectors) * usize::from(self.identity.samples_per_chip);
            (0..samples).for_each(|k| add(&format!("hits of sample {k} are counted"), true));
        }
        add("results of the board's own core", true);
        add("registers of the board's own core", self.has_registers);
        points.into_iter().map(|point| (point, 0)).collect()
    }
}

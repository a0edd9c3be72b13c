//! Makes a script: what the host says, what the core offers, and what has to come of both.

use std::collections::BTreeMap;

use goldtof_wire::{
    Answer, BLOCK_BYTES, Frame, MOST_RESULTS_OF_A_FRAME, REQUEST_BYTES, REQUEST_HITS,
    REQUEST_IDENTITY, REQUEST_READ, REQUEST_TEXT, REQUEST_WRITE, Request, encode, rest_bits,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::model::Facts;
use super::script::{Era, Expected, Offer, Script};

/// Bits of silence that end a torn request, and some more.
pub(super) const SILENCE: u32 = 300;
/// Addresses from here on are answered with an error, and keep nothing.
const REFUSED: u16 = 0x800;

/// What a script is made with.
pub(super) struct Maker<'a> {
    facts: &'a Facts,
    pub rng: Xoshiro256PlusPlus,
    pub script: Script,
    /// What the host has written.
    words: BTreeMap<u16, u32>,
}

impl<'a> Maker<'a> {
    pub(super) fn new(facts: &'a Facts, seed: u64) -> Maker<'a> {
        let eras = vec![Era::default()];
        let script = Script { rates: (1.0, 1.0), eras, ..Script::default() };
        let rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut maker = Maker { facts, rng, script, words: BTreeMap::new() };
        // The first request shall not fall into the board's reset.
        maker.pause(SILENCE);
        maker
    }

    pub(super) fn command(&mut self, command: &str) {
        self.script.host.push_str(command);
        self.script.host.push('\n');
    }

    pub(super) fn pause(&mut self, bits: u32) {
        self.command(&format!("bits {bits}"));
        self.script.bits += f64::from(bits);
    }

    pub(super) fn say(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.command(&format!("byte {byte:02x}"));
        }
        self.script.bits += 10.0 * bytes.len() as f64;
    }

    /// Until a frame of so many results and the answer behind it are through.
    pub(super) fn pause_for_answer(&mut self, results: usize) {
        // Sums come at once, and fill their frames.
        let results = if self.facts.sums.is_some() { 255 } else { results };
        let frame = 14 + self.facts.layout.payload_bytes(results);
        // A register may take 300 bits.
        let late = if self.facts.has_registers { 320 } else { 0 };
        self.pause((10.4 * (frame + 44) as f64) as u32 + 60 + late);
    }

    pub(super) fn request(&mut self, kind: u8, address: u16) -> (Request, u32) {
        (Request { kind, tag: self.rng.random(), address }, self.rng.random())
    }

    /// A request of any kind.
    pub(super) fn any_request(&mut self) -> (Request, u32) {
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
    pub(super) fn ask(&mut self, (request, data): (Request, u32)) {
        self.say(&encode::request(request, data));
        self.expect(request, data);
    }

    /// A request that the next reset may cut, whatever it is doing, and that leaves nothing behind.
    pub(super) fn cut_request(
        &mut self,
        (mut request, data): (Request, u32),
    ) -> [u8; REQUEST_BYTES] {
        if matches!(request.kind, REQUEST_READ | REQUEST_WRITE) {
            request.address |= REFUSED;
        }
        // That it comes up is not sure.
        let points = self.script.points.len();
        self.expect(request, data);
        self.script.points.truncate(points);
        self.era().is_cut = true;
        encode::request(request, data)
    }

    /// What has to come from the last reset on.
    pub(super) fn era(&mut self) -> &mut Era {
        let last = self.script.eras.len() - 1;
        &mut self.script.eras[last]
    }

    /// The PLL loses its lock for so many bits.
    pub(super) fn unlock(&mut self, bits: f64) {
        self.command(&format!("unlock {bits}"));
        self.script.eras.push(Era::default());
    }

    /// Expects the answer of a request that has been said.
    pub(super) fn expect(&mut self, request: Request, data: u32) {
        let facts = self.facts;
        let address = request.address;
        let status = match address {
            0xc00.. => 3,
            REFUSED.. => 2,
            _ => 0,
        };
        let name = ["OKAY", "", "SLVERR", "DECERR"][usize::from(status)];
        let expected = match request.kind {
            REQUEST_WRITE if facts.has_registers => {
                self.era().transfers.push(format!("W {address:x} {data:x} {status:x}"));
                if status == 0 {
                    self.words.insert(address, data);
                }
                self.script.points.push(format!("a write that is answered with {name}"));
                Expected::Written(request, status)
            }
            REQUEST_READ if facts.has_registers => {
                let written = self.words.get(&address).copied().filter(|_| status == 0);
                let data = written.unwrap_or(0xdead_0000 + u32::from(address));
                self.era().transfers.push(format!("R {address:x} {data:x} {status:x}"));
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
        self.era().answers.push(expected);
    }

    /// Offers results of scans with so many each; `wait` gives the clocks before each.
    pub(super) fn offer(
        &mut self,
        scan: usize,
        mut wait: impl FnMut(&mut Xoshiro256PlusPlus, usize) -> u64,
    ) {
        let facts = self.facts;
        let words = facts.packing.tdata_bits.div_ceil(32) as usize;
        let unused = 32 * words as u32 - facts.packing.tdata_bits;
        let least = 1_u128 << (facts.packing.layout.count_bits - 1);
        for number in 0..scan {
            // Now and then bytes that look like a frame's beginning, all ones, or one bit.
            let kind = match number {
                // A sum's greatest and least terms, of every scan.
                0 if facts.sums.is_some() => 1,
                1 if facts.sums.is_some() => 8,
                _ => self.rng.random_range(0..8),
            };
            let mut tdata: Vec<u32> = match kind {
                0 => vec![0xa543_a543; words],
                1 => vec![u32::MAX; words],
                8 => (0..words).map(|k| (least >> (32 * k)) as u32).collect(),
                2 => vec![0; words],
                _ => (0..words).map(|_| self.rng.random()).collect(),
            };
            tdata[words - 1] &= u32::MAX >> unused;
            let wait = wait(&mut self.rng, number);
            self.script.offers.push(Offer { wait, tdata, last: number + 1 == scan });
        }
    }

    /// Results of a scan: the scene's where scans are added up, else any number up to `most`.
    pub(super) fn scan(&mut self, most: usize) -> usize {
        match &self.facts.sums {
            Some(sums) => sums.results as usize,
            None => self.rng.random_range(1..=most),
        }
    }

    /// Spreads some hundred results, or sums, over the bits of the script.
    pub(super) fn offer_over_script(&mut self, results: usize) {
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
    pub(super) fn chips_per_result(&self) -> f64 {
        let most = MOST_RESULTS_OF_A_FRAME;
        let frame = 14 + self.facts.layout.payload_bytes(most as usize);
        let bits = 10.0 * frame as f64 + rest_bits(most, self.facts.clocks_per_bit);
        bits / most as f64 * self.facts.chips_per_bit
    }
}

impl Maker<'_> {
    /// The script, with a limit for a board whose line never falls silent.
    pub(super) fn made(mut self) -> Script {
        let waits: f64 = self.script.offers.iter().map(|offer| offer.wait as f64).sum();
        let line = self.script.offers.len() as f64 * 20.0 * self.facts.layout.result_bits() as f64;
        let bits = 2.0 * self.script.bits + line + 10_000.0;
        self.script.chips = (2.0 * waits + bits * self.facts.chips_per_bit) as u64;
        self.script
    }

    pub(super) fn read_register(&mut self, address: u16, value: u32) {
        let (request, data) = self.request(REQUEST_READ, address);
        self.say(&encode::request(request, data));
        let answer = Answer { request, status: 0, data: value };
        self.era().answers.push(Expected::Frame(Frame::Answer(answer)));
        self.script.points.push("registers of the board's own core".to_owned());
        self.pause_for_answer(255);
    }
}

//! Makes a script: what the host says, what the core offers, and what has to come of both.

use std::collections::BTreeMap;
use std::ops::Range;

use goldtof_wire::{
    ANSWER_BYTES, Answer, BLOCK_BYTES, Frame, IDENTITY_FRAME_BYTES, MOST_RESULTS_OF_A_FRAME,
    REQUEST_BYTES, REQUEST_HITS, REQUEST_IDENTITY, REQUEST_READ, REQUEST_TEXT, REQUEST_WRITE,
    Request, encode,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::model::Facts;
use super::script::{BoardScript, Era, ExpectedAnswer, Offer};
use crate::wire::ScanSums;

/// Bits of silence that end a torn request, 256, and some more: those of a fast host are shorter, and a reset takes some.
pub(super) const SILENCE: u32 = 310;
/// Addresses from here on are answered with an error, and keep nothing.
const REFUSED: u16 = 0x800;
/// And from here on with the one that says that there is no register.
const UNKNOWN: u16 = 0xc00;
/// Bytes from there on.
const SPAN: u16 = 0x400;

/// What a script is made with.
pub(super) struct Maker<'a> {
    pub facts: &'a Facts,
    pub rng: Xoshiro256PlusPlus,
    pub script: BoardScript,
    /// What the host has written.
    words: BTreeMap<u16, u32>,
    /// The tag of the last request.
    tag: u8,
    /// Requests of any kind so far.
    turn: usize,
}

impl<'a> Maker<'a> {
    pub(super) fn new(facts: &'a Facts, seed: u64) -> Maker<'a> {
        let eras = vec![Era::default()];
        let script = BoardScript { rates: (1.0, 1.0), eras, ..BoardScript::default() };
        let rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let words = BTreeMap::new();
        let mut maker = Maker { facts, rng, script, words, tag: seed as u8, turn: 0 };
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
        self.took(bits.into());
    }

    fn took(&mut self, bits: f64) {
        self.script.bits += bits;
        self.script.most_bits += bits;
    }

    /// Up to this bit of the run.
    pub(super) fn pause_until(&mut self, bit: f64) {
        self.command(&format!("until {bit:.0}"));
        self.script.bits = self.script.bits.max(bit);
        self.script.most_bits = self.script.most_bits.max(bit);
    }

    pub(super) fn say(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.command(&format!("byte {byte:02x}"));
        }
        self.took(10.0 * bytes.len() as f64);
    }

    /// Until the answer to a request has come, which may have to let a frame of so many results pass.
    pub(super) fn await_answer(&mut self, request: Request, results: u64) {
        let facts = self.facts;
        // Sums come at once, and fill their frames.
        let results = if facts.sums.is_some() { MOST_RESULTS_OF_A_FRAME } else { results };
        let is_transfer = matches!(request.kind, REQUEST_READ | REQUEST_WRITE);
        // A register may take 300 bits.
        let (answer, late) = match is_transfer && facts.has_registers {
            true => (ANSWER_BYTES, 320.0),
            false => (IDENTITY_FRAME_BYTES, 0.0),
        };
        let bytes = facts.frame_bytes(results) + answer;
        let most = 10.4 * bytes as f64 + 60.0 + late;
        let [_, kind, tag, low, high, ..] = encode::request(request, 0);
        let repeated = u32::from_le_bytes([kind, tag, low, high]);
        self.command(&format!("answer {repeated:08x} {most:.0}"));
        self.script.bits += 10.0 * answer as f64 + 100.0;
        self.script.most_bits += most;
    }

    /// A request, and what it would write. No two in a row have one tag, so that their answers differ.
    pub(super) fn request(&mut self, kind: u8, address: u16) -> (Request, u32) {
        self.tag = self.tag.wrapping_add(101);
        (Request { kind, tag: self.tag, address }, self.rng.random())
    }

    /// A request of each kind in turn, and of registers of each kind.
    pub(super) fn any_request(&mut self) -> (Request, u32) {
        const KINDS: [u8; 6] = [
            REQUEST_IDENTITY,
            REQUEST_READ,
            REQUEST_WRITE,
            REQUEST_READ,
            REQUEST_TEXT,
            REQUEST_WRITE,
        ];
        const FIRSTS: [u16; 4] = [0, SPAN, REFUSED, UNKNOWN];
        let (kind, first) = (KINDS[self.turn % 6], FIRSTS[self.turn / 6 % 4]);
        self.turn += 1;
        let address = match kind {
            REQUEST_TEXT => BLOCK_BYTES as u16 * self.rng.random_range(0..self.blocks()),
            // Now and then an address that was written to before.
            REQUEST_READ if first < REFUSED && !self.words.is_empty() && self.rng.random() => {
                let number = self.rng.random_range(0..self.words.len());
                self.words.keys().nth(number).copied().unwrap_or_default()
            }
            _ => first + 4 * self.rng.random_range(0..SPAN / 4),
        };
        self.request(kind, address)
    }

    /// Blocks of text to be asked for.
    fn blocks(&self) -> u16 {
        self.facts.text.len().div_ceil(BLOCK_BYTES).max(1) as u16
    }

    /// Asks, and expects the answer, which may have to let a frame of so many results pass.
    pub(super) fn ask(&mut self, (request, data): (Request, u32), results: u64) {
        self.say(&encode::request(request, data));
        self.expect(request, data);
        self.await_answer(request, results);
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
            UNKNOWN.. => 3,
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
                ExpectedAnswer::Written(request, status)
            }
            REQUEST_READ if facts.has_registers => {
                let written = self.words.get(&address).copied().filter(|_| status == 0);
                let data = written.unwrap_or(0xdead_0000 + u32::from(address));
                self.era().transfers.push(format!("R {address:x} {data:x} {status:x}"));
                self.script.points.push(format!("a read that is answered with {name}"));
                ExpectedAnswer::Frame(Frame::Answer(Answer { request, status, data }))
            }
            REQUEST_TEXT | REQUEST_HITS => {
                let mut block = facts.identity.to_bytes();
                if request.kind == REQUEST_TEXT && !facts.text.is_empty() {
                    block = [0; BLOCK_BYTES];
                    let bytes = facts.text.bytes().skip(address.into());
                    block.iter_mut().zip(bytes).for_each(|(place, byte)| *place = byte);
                    self.script.points.push("a block of the scene's text".to_owned());
                }
                ExpectedAnswer::Frame(Frame::Block(request, block))
            }
            _ => ExpectedAnswer::Frame(Frame::Identity(request, Ok(facts.identity))),
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
            let last = number + 1 == scan;
            self.script.offers.push(Offer { wait, tdata, last });
        }
    }

    /// Results one by one, so slowly that most have a frame of their own.
    pub(super) fn offer_singly(&mut self, results: usize) {
        let gap = 10.4 * self.facts.frame_bytes(1) as f64 * self.facts.chips_per_bit;
        self.offer_in_scans(results, 0.9 * gap..1.2 * gap);
    }

    /// Spreads some hundred results over the bits of the script.
    pub(super) fn offer_over_script(&mut self, results: usize) {
        // The line takes twice as many.
        let most = self.script.bits / (2.5 * self.facts.layout.result_bits() as f64 + 50.0);
        let results = results.min(most as usize);
        let gap = self.script.bits * self.facts.chips_per_bit / results as f64;
        self.offer_in_scans(results, 0.0..1.9 * gap);
    }

    fn offer_in_scans(&mut self, results: usize, chips: Range<f64>) {
        while self.script.offers.len() < results {
            let scan = self.rng.random_range(1..=60);
            self.offer(scan, |rng, _| rng.random_range(chips.clone()) as u64);
        }
    }

    /// Scans of a sum, the last one no faster than the line takes it, but for some results that follow one another
    /// without a pause, and its first ones: so many come at once.
    pub(super) fn offer_sum(&mut self, sums: &ScanSums, at_once: usize) {
        let most = 2.6 * self.facts.chips_of_results(sums.results) / sums.results as f64;
        for scan in 1..=sums.scans {
            let (most, at_once) = if scan == sums.scans { (most as u64, at_once) } else { (3, 0) };
            self.offer(sums.results as usize, |rng, number| match number % 64 {
                _ if number < at_once => 0,
                0..8 => 0,
                _ => rng.random_range(0..=most),
            });
        }
    }

    /// Scans of sums over the bits of the script, and those of a sum behind them, that never come faster than the line
    /// takes them, whichever scan is the last one of a sum.
    pub(super) fn offer_scans_of_sums(&mut self, sums: &ScanSums) {
        // Where the FIFO takes a whole sum, its scans may come faster.
        let is_held = 2 * sums.results < 1 << self.facts.fifo_address_bits;
        let at_once = if is_held { f64::from(sums.scans) } else { 1.0 };
        let scan_chips = 1.3 * self.facts.chips_of_results(sums.results) / at_once;
        let over_script = self.script.bits * self.facts.chips_per_bit / scan_chips;
        let most = 2.0 * scan_chips / sums.results as f64;
        for _ in 0..=over_script as u64 + u64::from(sums.scans) {
            self.offer(sums.results as usize, |rng, _| rng.random_range(0.0..=most) as u64);
        }
    }

    /// Chips that a result takes on a line that is full.
    pub(super) fn chips_per_result(&self) -> f64 {
        let most = MOST_RESULTS_OF_A_FRAME;
        self.facts.chips_of_results(most) / most as f64
    }
}

impl Maker<'_> {
    /// The script, with a limit for a board whose line never falls silent.
    pub(super) fn made(mut self) -> BoardScript {
        let waits: f64 = self.script.offers.iter().map(|offer| offer.wait as f64).sum();
        let line = self.script.offers.len() as f64 * 20.0 * self.facts.layout.result_bits() as f64;
        let bits = 2.0 * self.script.most_bits + line + 10_000.0;
        self.script.chips = (2.0 * waits + bits * self.facts.chips_per_bit) as u64;
        self.script
    }

    pub(super) fn read_register(&mut self, address: u16, value: u32) {
        let (request, data) = self.request(REQUEST_READ, address);
        self.say(&encode::request(request, data));
        let answer = Answer { request, status: 0, data: value };
        self.era().answers.push(ExpectedAnswer::Frame(Frame::Answer(answer)));
        self.script.points.push("registers of the board's own core".to_owned());
        self.await_answer(request, MOST_RESULTS_OF_A_FRAME);
    }
}

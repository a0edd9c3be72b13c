//! The bins of neighbouring samples of which at most one has a hit, and the adder that they share.
//!
//! Cost: a bank for each sample, an OR of theirs, an adder of a bin's bits. Of eight samples and more
//! the first half has an OR of its own, and the adder joins the two: at most one of them
//! is not 0, and the adder has two inputs anyway.

use super::{BinBank, WordPorts};
use crate::rtl::front::prelude::*;
use crate::sensor::histogram::HistogramPlan;

#[block(bin_adder)]
/// a histogram's bins of neighbouring samples, and the adder that they share
#[when(samples == 2)]
/// A rising edge needs a low sample, so of two neighbours one has a hit at most.
#[when(samples > 2)]
/// The detectors' dead time lets at most one of {samples} neighbouring samples be a hit. Of several,
/// which no such detector makes, the earliest counts.
#[when(saturates)]
/// A full bin stays as it is, and o_clamped says that a hit was lost in it.
///
/// - Latency: 5 clocks from i_hits to the bin with its hit, 7 until it is written
pub struct BinAdder {
    histogram: HistogramPlan,
    #[set(histogram.adder_samples as usize)]
    samples: usize,
    #[set(histogram.bin_bits)]
    bits: u32,
    #[set(histogram.saturates())]
    saturates: bool,
    #[set(histogram.takes_turns())]
    takes_turns: bool,
    #[set(samples.div_ceil(2))]
    pairs: usize,
    /// Groups of samples whose bins have an OR of their own: of four inputs if that will do.
    #[set(1 + usize::from(samples >= 8))]
    halves: usize,
    /// Halves whose bins come out of one of two memories.
    #[set(if takes_turns { halves } else { 0 })]
    halves_in_turns: usize,
    /// Inputs of an adder that joins two halves.
    #[set(if halves > 1 { halves } else { 0 })]
    addends: usize,
    #[set(samples / halves)]
    half: usize,
    #[set(bits as usize)]
    bin_bits: usize,
    /// pairs of samples with a hit
    #[width(pairs)]
    pub i_hits: Input<Word>,
    /// it is the earlier sample of its pair
    #[when(samples > 1)]
    #[width(pairs)]
    pub i_early: Optional<Input<Word>>,
    /// of the word on its way
    #[shown]
    #[is(WordPorts::new(histogram))]
    io: WordPorts,
    /// bins of the row that was read, the first sample's lowest
    #[width(samples * bin_bits)]
    pub o_bins: Output<Word>,
    /// a hit found its bin full
    #[when(saturates)]
    pub o_clamped: Optional<Output<bool>>,
    /// the earliest pair that has a hit
    #[width(pairs)]
    earliest: Local<Word>,
    #[width(samples)]
    place: Local<Word>,
    /// sample with the hit of the words 1 to 5 clocks ago
    #[each(_clocks in 1..6)]
    #[width(samples)]
    hit: Vec<Register<Word>>,
    #[each(_sample in 0..samples)]
    #[is(BinBank::new(histogram.rows, bits, takes_turns))]
    bank: Vec<BinBank>,
    /// bin with the hit, of the samples of a half
    #[each(_half in 0..halves)]
    #[width(bits)]
    choice: Vec<Local<Word>>,
    /// the same, out of memory 1
    #[each(_half in 0..halves_in_turns)]
    #[width(bits)]
    other: Vec<Local<Word>>,
    /// bin with a hit{if halves > 1 { ", if it is in the first half of the samples; then in the second" } else { "" }}
    #[each(_half in 0..halves)]
    #[width(bits)]
    chosen: Vec<Register<Word>>,
    /// bin with a hit
    #[when(saturates)]
    #[width(bits)]
    found: Optional<Local<Word>>,
    /// below either a 1: the carry makes the sum one more
    #[each(_half in 0..addends)]
    #[width(bits + 1)]
    addend: Vec<Local<Word>>,
    /// both, and the 1; below them a 0
    #[when(halves > 1)]
    #[width(bits + 1)]
    both: Optional<Local<Word>>,
    /// the 0 has no use; linters know by the name
    #[when(halves > 1)]
    unused: Optional<Local<bool>>,
    /// the same with the hit
    #[width(bits)]
    sum: Register<Word>,
    /// its bits above the lowest, a clock later
    #[when(bits > 1)]
    #[width(bits - 1)]
    above: Optional<Register<Word>>,
    /// a hit found its bin full
    #[when(saturates)]
    clamped: Optional<Register<bool>>,
}

#[kernel]
impl Logic for BinAdder {
    fn update(&mut self) {
        self.find_hit();
        for c in 1..5 {
            self.hit[c].next = self.hit[c - 1].val();
        }
        self.run_banks();
        self.choose();
        if self.halves > 1 {
            self.add_halves();
        } else {
            self.sum.next = self.chosen[0].val() + 1;
        }
        if self.bits > 1 {
            self.hand_back();
        }
        if self.o_clamped.is_present() {
            self.clamp();
        }
    }

    /// The sample that has the hit: of several the earliest.
    fn find_hit(&mut self) {
        let pairs = self.pairs;
        self.earliest.next = gather(pairs, |p| {
            if p == 0 {
                self.i_hits.val().get_bit(0)
            } else {
                self.i_hits.val().get_bit(p) & !(self.i_hits.val() << (pairs - p)).any()
            }
        });
        self.place.next = gather(self.samples, |s| {
            if self.samples == 1 {
                self.earliest.val().get_bit(0)
            } else if s % 2 == 0 {
                self.earliest.val().get_bit(s / 2) & self.i_early.val().get_bit(s / 2)
            } else {
                self.earliest.val().get_bit(s / 2) & !self.i_early.val().get_bit(s / 2)
            }
        });
        self.hit[0].next = self.place.val();
    }

    /// The bin with the hit: all others are 0. In a first code period it is 0 as well.
    fn choose(&mut self) {
        let half = self.half;
        for h in 0..self.chosen.len() {
            self.choice[h].next = self.bank[half * h].o_bin.val();
            for s in 1..half {
                self.choice[h].next = self.choice[h].val() | self.bank[half * h + s].o_bin.val();
            }
            self.chosen[h].next = self.choice[h].val();
        }
        if self.takes_turns {
            self.choose_from_other();
        }
        for h in 0..self.chosen.len() {
            if self.io.i_held_first.val() {
                self.chosen[h].next = bit_cast(false, self.bin_bits);
            }
        }
    }

    /// One more than both together, in one chain of carries.
    fn add_halves(&mut self) {
        for h in 0..self.addend.len() {
            self.addend[h].next = gather(self.bin_bits + 1, |b| {
                if b == 0 { true } else { self.chosen[h].val().get_bit(b - 1) }
            });
        }
        self.both.next = self.addend[0].val() + self.addend[1].val();
        self.unused.next = self.both.val().get_bit(0);
        self.sum.next = self.both.val().slice(1, self.bin_bits);
    }

    fn choose_from_other(&mut self) {
        let half = self.half;
        for h in 0..self.chosen.len() {
            self.other[h].next = self.bank[half * h].o_other.val();
            for s in 1..half {
                self.other[h].next = self.other[h].val() | self.bank[half * h + s].o_other.val();
            }
            if self.io.i_held_half.val() {
                self.chosen[h].next = self.other[h].val();
            }
        }
    }

    fn run_banks(&mut self) {
        for s in 0..self.samples {
            connect! {
                self.bank[s] from self.io: i_row, i_half, i_read_row, i_go, i_come_first,
                    i_come_half, i_write_row, i_write_half
            }
            self.bank[s].i_come_hit.next = self.hit[1].val().get_bit(s);
            self.bank[s].i_hit.next = self.hit[4].val().get_bit(s);
            self.bank[s].i_first.next = self.io.i_added_first.val();
            self.bank[s].i_lowest.next = self.sum.val().get_bit(0);
        }
        let bits = self.bin_bits;
        self.o_bins.next = gather(self.samples * bits, |b| {
            if self.takes_turns {
                self.bank[b / bits].o_read.val().get_bit(b % bits)
            } else {
                self.bank[b / bits].o_bin.val().get_bit(b % bits)
            }
        });
    }

    /// The bits that all banks have in common. In a first code period they are 0: the bin with
    /// the hit is 1.
    fn hand_back(&mut self) {
        self.above.next = self.sum.val().slice(1, self.bin_bits - 1);
        for s in 0..self.samples {
            self.bank[s].i_above.next = self.above.val();
        }
    }

    fn clamp(&mut self) {
        self.clamped.next = false;
        if self.halves > 1 {
            self.found.next = self.chosen[0].val() | self.chosen[1].val();
        } else {
            self.found.next = self.chosen[0].val();
        }
        if self.found.val().all() {
            self.sum.next = self.found.val();
            self.clamped.next = self.hit[3].val().any();
        }
        self.o_clamped.next = self.clamped.val();
    }
}

//! Where the reference model writes what it expects.

use std::ops::Range;

use super::pattern::ChipPattern;

/// Takes what is expected of the outputs, as bits of their records.
pub(super) trait Canvas {
    /// ORs bits into a word of the records of some clocks.
    fn or(&mut self, clocks: Range<u64>, word: usize, bits: u64);

    /// ORs a code into the records of some clocks, the first of which shows `cycle`.
    fn or_code(&mut self, code: &ChipPattern, clocks: Range<u64>, cycle: u64);
}

/// A record for every clock.
pub(super) struct EveryClock<'a> {
    /// Clock of the first record.
    pub(super) first_clock: u64,
    /// Words of a record.
    pub(super) words: usize,
    /// The records.
    pub(super) records: &'a mut [u64],
}

impl EveryClock<'_> {
    fn part(&mut self, clocks: Range<u64>) -> &mut [u64] {
        let from = (clocks.start - self.first_clock) as usize * self.words;
        let to = (clocks.end - self.first_clock) as usize * self.words;
        &mut self.records[from..to]
    }
}

impl Canvas for EveryClock<'_> {
    #[inline]
    fn or(&mut self, clocks: Range<u64>, word: usize, bits: u64) {
        let words = self.words;
        let part = self.part(clocks);
        if words == 1 {
            part.iter_mut().for_each(|w| *w |= bits);
        } else {
            for record in part.chunks_exact_mut(words) {
                record[word] |= bits;
            }
        }
    }

    fn or_code(&mut self, code: &ChipPattern, clocks: Range<u64>, cycle: u64) {
        let words = self.words;
        code.or_into(self.part(clocks), words, cycle);
    }
}

/// For whoever asks for results alone.
pub(super) struct Unseen;

impl Canvas for Unseen {
    fn or(&mut self, _clocks: Range<u64>, _word: usize, _bits: u64) {}

    fn or_code(&mut self, _code: &ChipPattern, _clocks: Range<u64>, _cycle: u64) {}
}

/// Outputs that change from one clock on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct OutputChange {
    /// First clock after whose rising edge they have changed.
    pub clock: u64,
    /// Word of the record.
    pub word: usize,
    /// Its bits that change.
    pub flips: u64,
}

/// Only where the outputs change, and not those that follow a code.
#[derive(Debug, Clone, Default)]
pub struct Changes {
    list: Vec<OutputChange>,
}

impl Changes {
    /// Takes the changes before a clock, in order, once nothing before it is written
    /// any more. A bit that stays as it is is in none.
    pub fn take_before(&mut self, clock: u64) -> Vec<OutputChange> {
        self.list.sort_unstable();
        let end = self.list.partition_point(|change| change.clock < clock);
        let mut merged: Vec<OutputChange> = Vec::new();
        for change in self.list.drain(..end) {
            match merged.last_mut() {
                Some(last) if (last.clock, last.word) == (change.clock, change.word) => {
                    last.flips ^= change.flips;
                }
                _ => merged.push(change),
            }
        }
        merged.retain(|change| change.flips != 0);
        merged
    }
}

impl Canvas for Changes {
    fn or(&mut self, clocks: Range<u64>, word: usize, bits: u64) {
        if clocks.is_empty() || bits == 0 {
            return;
        }
        for clock in [clocks.start, clocks.end] {
            self.list.push(OutputChange { clock, word, flips: bits });
        }
    }

    fn or_code(&mut self, _code: &ChipPattern, _clocks: Range<u64>, _cycle: u64) {}
}

//! Bits of all lanes of a model: a row for each register, or output, or just one.

use std::ops::BitXorAssign;

/// Rows of a bit for each lane, in words of 64 lanes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Planes {
    /// Words of a row.
    words: usize,
    bits: Vec<u64>,
}

impl Planes {
    /// Rows of zeros.
    pub(super) fn new(lanes: usize, rows: usize) -> Planes {
        let words = lanes / 64;
        Planes { words, bits: vec![0; rows * words] }
    }

    /// Rows of which the words are there.
    pub(super) fn of_words(lanes: usize, bits: Vec<u64>) -> Planes {
        Planes { words: lanes / 64, bits }
    }

    /// One row.
    pub(super) fn row_where(lanes: usize, is_so: impl Iterator<Item = bool>) -> Planes {
        let mut row = Planes::new(lanes, 1);
        is_so.enumerate().for_each(|(lane, is_so)| row.set(0, lane, is_so));
        row
    }

    /// All words, row after row.
    pub(super) fn as_words(&self) -> &[u64] {
        &self.bits
    }

    /// The words of each row.
    pub(super) fn rows(&self) -> impl ExactSizeIterator<Item = &[u64]> {
        self.bits.chunks_exact(self.words)
    }

    /// The words of each row, to be changed.
    fn rows_mut(&mut self) -> impl Iterator<Item = &mut [u64]> {
        self.bits.chunks_exact_mut(self.words)
    }

    /// A lane's bit of a row.
    pub(super) fn get(&self, row: usize, lane: usize) -> bool {
        self.bits[row * self.words + lane / 64] >> (lane % 64) & 1 == 1
    }

    /// Sets a lane's bit of a row.
    pub(super) fn set(&mut self, row: usize, lane: usize, value: bool) {
        let word = &mut self.bits[row * self.words + lane / 64];
        *word = *word & !(1 << (lane % 64)) | u64::from(value) << (lane % 64);
    }

    /// The first lane that any row has.
    pub(super) fn first_lane(&self) -> Option<usize> {
        let lane_of = |row: &[u64]| {
            let word = row.iter().position(|&word| word != 0)?;
            Some(word * 64 + row[word].trailing_zeros() as usize)
        };
        self.rows().filter_map(lane_of).min()
    }

    /// How many bits are set.
    pub(super) fn ones(&self) -> u64 {
        self.bits.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Leaves only those lanes that a single row has.
    pub(super) fn keep(&mut self, lanes: &Planes) {
        for row in self.rows_mut() {
            row.iter_mut().zip(&lanes.bits).for_each(|(word, lanes)| *word &= lanes);
        }
    }

    /// The first 64 lanes.
    pub(super) fn narrowed(&self) -> Planes {
        Planes { words: 1, bits: self.bits.iter().step_by(self.words).copied().collect() }
    }
}

impl BitXorAssign<&Planes> for Planes {
    fn bitxor_assign(&mut self, others: &Planes) {
        self.bits.iter_mut().zip(&others.bits).for_each(|(word, other)| *word ^= other);
    }
}

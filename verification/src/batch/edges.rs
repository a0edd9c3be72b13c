//! Hits of sample words: a high sample after a low one, also across words.

use crate::scan::{Sample, Sampling};
use crate::sensor::cells::{CellChange, Cells};
use crate::sensor::interface::Interface;

/// One detector's last sample, which tells whether a word that begins high begins with a
/// hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct LastSample {
    /// Samples of a word.
    samples: u32,
    is_high: bool,
}

impl LastSample {
    /// Before the first word, of which nobody can tell whether it begins with an edge.
    pub(super) fn before_all(samples: u32) -> LastSample {
        LastSample { samples, is_high: true }
    }

    /// Adds the first samples of all runs of high samples that begin in the word of
    /// `clock`.
    #[inline]
    pub(super) fn hits(&mut self, clock: u64, word: u64, hits: &mut Vec<Sample>) {
        let mut rising = word & !(word << 1 | u64::from(self.is_high));
        self.is_high = word >> (self.samples - 1) & 1 == 1;
        let first = Sampling::new(self.samples).first_sample(clock);
        while rising != 0 {
            hits.push(first + u64::from(rising.trailing_zeros()));
            rising &= rising - 1;
        }
    }
}

/// The last samples of one detector's cells, which have an input each.
#[derive(Debug, Clone, Copy)]
pub(super) struct LastCells {
    cells: Cells,
    sampling: Sampling,
    /// Bit c: that of cell c is high.
    high: u64,
}

impl LastCells {
    /// Before the first word.
    pub(super) fn before_all(interface: &Interface) -> LastCells {
        LastCells { cells: interface.input_cells, sampling: interface.timing.sampling(), high: 0 }
    }

    /// Adds what the cells' words of `clock` change, and the hits that come of it.
    pub(super) fn changes(
        &mut self,
        clock: u64,
        words: impl Iterator<Item = u64> + Clone,
        changes: &mut Vec<CellChange>,
        hits: &mut Vec<Sample>,
    ) {
        let samples = self.sampling.samples(&(clock..clock + 1));
        for sample in (samples.start.0..samples.end.0).map(Sample) {
            let lane = self.sampling.lane_of(sample);
            let bits = words.clone().enumerate();
            let after = bits.fold(0, |high, (cell, word)| high | (word >> lane & 1) << cell);
            let before = std::mem::replace(&mut self.high, after);
            if after != before {
                let change = CellChange { sample, before, after };
                hits.extend(std::iter::repeat_n(sample, change.hits(&self.cells) as usize));
                changes.push(change);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sample by sample, by the definition.
    fn by_definition(samples: u32, words: &[u64]) -> Vec<Sample> {
        let levels: Vec<bool> = words
            .iter()
            .flat_map(|word| (0..samples).map(move |sample| word >> sample & 1 == 1))
            .collect();
        let rises = |&at: &usize| levels[at] && !levels[at - 1];
        (1..levels.len()).filter(rises).map(|at| Sample(at as u64)).collect()
    }

    #[test]
    fn hits_are_rising_edges_also_across_words() {
        for samples in [1u32, 2, 4, 8, 16] {
            let mask = (1u64 << samples) - 1;
            let words: Vec<u64> = (0..500u64)
                .map(|n| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 23) & mask)
                .chain([mask, mask, 0, 1, mask, 1 << (samples - 1), 1])
                .collect();
            let mut last = LastSample::before_all(samples);
            let mut hits = Vec::new();
            for (clock, &word) in words.iter().enumerate() {
                last.hits(clock as u64, word, &mut hits);
            }
            assert_eq!(hits, by_definition(samples, &words), "{samples} samples");
            assert!(hits.len() > 50);
        }
    }
}

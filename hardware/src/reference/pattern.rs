//! Output bits that follow the codes alone: lasers and epoch.

use crate::sensor::interface::Interface;

/// Output bits that repeat with a code's period.
#[derive(Debug, Clone)]
pub(super) struct ChipPattern {
    word: usize,
    /// Bits to OR into that word, one entry per chip, whole code periods.
    bits: Vec<u64>,
}

impl ChipPattern {
    /// ORs the pattern into records of `words` words, the first of which shows
    /// cycle `cycle`.
    pub(super) fn or_into(&self, expected: &mut [u64], words: usize, cycle: u64) {
        let phase = (cycle % self.bits.len() as u64) as usize;
        or_periodic(expected, words, self.word, &self.bits, phase);
    }
}

/// One pattern per period and word: lasers, and the epoch of the reference.
pub(super) fn chip_patterns(
    interface: &Interface,
    laser: (usize, u32),
    epoch: (usize, u32),
) -> Vec<ChipPattern> {
    let mut patterns: Vec<ChipPattern> = Vec::new();
    let mut or = |word: usize, period: Vec<u64>| {
        // Long enough that copying it is not dominated by the loop's ends.
        let periods = 512usize.div_ceil(period.len());
        let bits = period.repeat(periods);
        let same = patterns.iter_mut().find(|p| p.word == word && p.bits.len() == bits.len());
        match same {
            Some(pattern) => pattern.bits.iter_mut().zip(bits).for_each(|(all, more)| *all |= more),
            None => patterns.push(ChipPattern { word, bits }),
        }
    };
    for (source, code) in interface.source_codes.iter().enumerate() {
        let bit = laser.1 as usize + source;
        let chips = code.chips.iter();
        or(laser.0 + bit / 64, chips.map(|&chip| u64::from(chip) << (bit % 64)).collect());
    }
    let mut strobe = vec![0; interface.reference_codes[0].chips.len()];
    strobe[0] = 1 << epoch.1;
    or(epoch.0, strobe);
    patterns
}

/// ORs a periodic pattern into word `word` of every record, from `phase` on.
fn or_periodic(expected: &mut [u64], words: usize, word: usize, pattern: &[u64], phase: usize) {
    let mut rest = &mut expected[..];
    let mut phase = phase;
    while !rest.is_empty() {
        let count = (pattern.len() - phase).min(rest.len() / words);
        let (head, tail) = rest.split_at_mut(count * words);
        let bits = &pattern[phase..phase + count];
        if words == 1 {
            head.iter_mut().zip(bits).for_each(|(w, b)| *w |= b);
        } else {
            head.chunks_exact_mut(words).zip(bits).for_each(|(record, b)| record[word] |= b);
        }
        rest = tail;
        phase = 0;
    }
}

//! The SPAD's digital level as the deserializer samples it.
//!
//! Pulses come in; sample words and hits come out. A hit is the start of a run
//! of high samples: pulses that touch or overlap are one run, so hits follow
//! from the list of pulses alone and no edge is ever looked for in the words.

use std::ops::Range;

use crate::photons::Pulse;
use crate::scan::{Sample, Sampling};

/// Turns one detector's pulses, in order of their first sample, into words.
#[derive(Debug, Clone)]
pub struct LevelPainter {
    sampling: Sampling,
    /// The level is high on every sample before this one that a pulse covered,
    /// and low from here on unless another pulse covers it.
    high_until: Sample,
}

impl LevelPainter {
    /// A level that is low so far. `lanes` is S, a power of two.
    pub fn new(lanes: u32) -> LevelPainter {
        LevelPainter { sampling: Sampling::new(lanes), high_until: Sample(0) }
    }

    /// Paints the words of the clocks `block`.
    ///
    /// `pulses` are those whose first sample lies in the block, in order.
    /// `paint(i, bits)` is to OR lane bits into the word of the block's i-th
    /// clock. The first sample of every run that starts here goes to `hits`.
    pub fn paint(
        &mut self,
        block: Range<u64>,
        pulses: &[Pulse],
        mut paint: impl FnMut(usize, u64),
        hits: &mut Vec<Sample>,
    ) {
        let samples = self.sampling.samples(&block);
        if self.high_until > samples.start {
            self.paint_run(
                samples.start..self.high_until.min(samples.end),
                block.start,
                &mut paint,
            );
        }
        for pulse in pulses {
            debug_assert!(samples.contains(&pulse.first));
            // A run that ends where the pulse begins leaves no low sample
            // between the two. Sample 0 has no sample before it: whether it is
            // high at the very start is not an edge anyone could have seen.
            if pulse.first > self.high_until {
                hits.push(pulse.first);
            }
            if pulse.end > self.high_until {
                let from = pulse.first.max(self.high_until);
                self.paint_run(from..pulse.end.min(samples.end), block.start, &mut paint);
                self.high_until = pulse.end;
            }
        }
    }

    fn paint_run(&self, run: Range<Sample>, first_clock: u64, paint: &mut impl FnMut(usize, u64)) {
        let lanes = self.sampling.samples_of(1);
        let mut sample = run.start;
        while sample < run.end {
            let clock = self.sampling.clock_of(sample);
            let low = self.sampling.lane_of(sample);
            let high = (run.end - self.sampling.first_sample(clock)).min(lanes);
            let below_high = if high == 64 { u64::MAX } else { (1 << high) - 1 };
            paint((clock - first_clock) as usize, below_high & (u64::MAX << low));
            sample = self.sampling.first_sample(clock + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulse(first: u64, end: u64) -> Pulse {
        Pulse { first: Sample(first), end: Sample(end) }
    }

    fn painted(lanes: u32, clocks: u64, block: u64, pulses: &[Pulse]) -> (Vec<u64>, Vec<u64>) {
        let sampling = Sampling::new(lanes);
        let mut level = LevelPainter::new(lanes);
        let mut words = vec![0; clocks as usize];
        let mut hits = Vec::new();
        let mut start = 0;
        while start < clocks {
            let end = (start + block).min(clocks);
            let inside: Vec<_> = pulses
                .iter()
                .copied()
                .filter(|p| (start..end).contains(&sampling.clock_of(p.first)))
                .collect();
            let at = start as usize;
            level.paint(start..end, &inside, |clock, bits| words[at + clock] |= bits, &mut hits);
            start = end;
        }
        (words, hits.into_iter().map(|hit| hit.0).collect())
    }

    #[test]
    fn bit_0_of_a_word_is_the_earliest_sample() {
        let (words, hits) = painted(8, 3, 3, &[pulse(6, 10), pulse(17, 18)]);
        assert_eq!(words, [0b1100_0000, 0b0000_0011, 0b0000_0010]);
        assert_eq!(hits, [6, 17]);
    }

    #[test]
    fn pulses_that_touch_or_overlap_are_one_hit_and_a_gap_of_one_sample_makes_two() {
        let (_, touching) = painted(4, 8, 8, &[pulse(4, 7), pulse(7, 9)]);
        assert_eq!(touching, [4]);
        let (_, nested) = painted(4, 8, 8, &[pulse(4, 20), pulse(5, 6), pulse(20, 21)]);
        assert_eq!(nested, [4]);
        let (_, apart) = painted(4, 8, 8, &[pulse(4, 7), pulse(8, 9)]);
        assert_eq!(apart, [4, 8]);
    }

    #[test]
    fn the_size_of_the_blocks_changes_nothing() {
        let pulses: Vec<_> = (0..40u64)
            .map(|i| {
                let first = 3 + i * 7 + i * i % 5;
                pulse(first, first + 1 + i * 13 % 23)
            })
            .collect();
        let whole = painted(8, 64, 64, &pulses);
        for block in [1, 2, 3, 7, 63] {
            assert_eq!(painted(8, 64, block, &pulses), whole, "blocks of {block}");
        }
    }
}

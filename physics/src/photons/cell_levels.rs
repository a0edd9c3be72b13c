//! When the sampled levels of one detector's cells change.

use super::sampled::Pulse;
use crate::scan::Sample;
use crate::sensor::cells::CellChange;

/// The sampled levels of some cells, all low at first.
#[derive(Debug, Clone)]
pub struct CellLevels {
    /// Of each cell its pulse, or several that touch or overlap, whose end is not certain yet.
    open: Vec<Option<Pulse>>,
    /// Where cells begin or end a pulse, as far as that is certain and has not been told.
    edges: Vec<(Sample, usize)>,
    /// Cells with a pulse, bit c for cell c.
    high: u64,
}

impl CellLevels {
    /// Of so many cells, at most 64.
    pub fn new(cells: u32) -> CellLevels {
        CellLevels { open: vec![None; cells as usize], edges: Vec::new(), high: 0 }
    }

    /// Adds all changes before a sample. `pulses` are those of each cell that have not been given yet, in
    /// order: all that begin before that sample, and perhaps later ones.
    pub fn advance(&mut self, pulses: &[Vec<Pulse>], until: Sample, changes: &mut Vec<CellChange>) {
        for (cell, (open, pulses)) in self.open.iter_mut().zip(pulses).enumerate() {
            for pulse in pulses {
                match open {
                    Some(open) if pulse.first <= open.end => open.end = open.end.max(pulse.end),
                    _ => {
                        self.edges.extend(open.map(|ended| (ended.end, cell)));
                        self.edges.push((pulse.first, cell));
                        *open = Some(*pulse);
                    }
                }
            }
            // One that begins where it ends would prolong it.
            if let Some(ended) = open.take_if(|open| open.end < until) {
                self.edges.push((ended.end, cell));
            }
        }
        self.edges.sort_unstable();
        let certain = self.edges.partition_point(|(sample, _)| *sample < until);
        let mut certain = self.edges.drain(..certain).peekable();
        while let Some((sample, cell)) = certain.next() {
            let before = self.high;
            self.high ^= 1 << cell;
            while let Some((_, cell)) = certain.next_if(|(at, _)| *at == sample) {
                self.high ^= 1 << cell;
            }
            changes.push(CellChange { sample, before, after: self.high });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pulses that overlap, touch and end with a block, in blocks of any length: the changes are those
    /// of levels that are painted sample by sample.
    #[test]
    fn changes_are_those_of_painted_samples() {
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        let mut below = |end: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 33) % end
        };
        for _ in 0..200 {
            let mut painted = [[false; 400]; 5];
            let mut pulses: Vec<Vec<Pulse>> = vec![Vec::new(); 5];
            for (pulses, painted) in pulses.iter_mut().zip(&mut painted) {
                let mut first = below(20);
                while first < 360 {
                    let end = first + 1 + below(12);
                    pulses.push(Pulse { first: Sample(first), end: Sample(end) });
                    painted[first as usize..end as usize].fill(true);
                    first += below(16);
                }
            }
            let mut expected = Vec::new();
            let mut before = 0;
            for sample in 0..400 {
                let bits = painted.iter().enumerate();
                let after = bits.fold(0, |all, (cell, high)| all | u64::from(high[sample]) << cell);
                if after != before {
                    let sample = Sample(sample as u64);
                    expected.push(CellChange { sample, before, after });
                }
                before = after;
            }
            let mut levels = CellLevels::new(5);
            let mut found = Vec::new();
            let mut until = 0;
            while until < 400 {
                until += 1 + below(40);
                let early = below(10);
                let of_block = pulses.iter_mut().map(|pulses| {
                    let end = pulses.partition_point(|pulse| pulse.first.0 < until + early);
                    pulses.drain(..end).collect()
                });
                levels.advance(&of_block.collect::<Vec<_>>(), Sample(until), &mut found);
            }
            assert_eq!(found, expected);
        }
    }
}

//! The levels of all inputs, and the hits that they make of each detector.

use std::ops::Range;

use super::level::LevelPainter;
use crate::photons::{CellLevels, Pulse};
use crate::scan::{Sample, Sampling};
use crate::sensor::cells::{CellChange, Cells};
use crate::sensor::interface::Interface;

/// Turns the pulses of all inputs into words, and into hits of the detectors.
#[derive(Debug, Clone)]
pub struct Levels {
    cells: Cells,
    sampling: Sampling,
    /// For each input.
    inputs: Vec<LevelPainter>,
    /// For each detector, if its cells have an input each.
    of_cells: Vec<CellLevels>,
}

impl Levels {
    /// Levels that are low so far.
    pub fn of(interface: &Interface) -> Levels {
        let cells = interface.input_cells;
        let detectors = if cells.count > 1 { interface.reference_codes.len() } else { 0 };
        Levels {
            cells,
            sampling: interface.timing.sampling(),
            inputs: vec![LevelPainter::new(interface.lanes()); interface.inputs()],
            of_cells: vec![CellLevels::new(cells.count); detectors],
        }
    }

    /// Paints the words of the clocks `block`.
    ///
    /// `pulses` are those of each input whose first sample lies in the block, in order.
    /// `paint(input, i, bits)` is to OR lane bits into the input's word of the block's i-th clock.
    /// Each detector's hits replace `hits`, one sample for each of several at once, and `changes` those of its cells, if they have an input each.
    pub fn paint(
        &mut self,
        block: Range<u64>,
        pulses: &[Vec<Pulse>],
        mut paint: impl FnMut(usize, usize, u64),
        hits: &mut [Vec<Sample>],
        changes: &mut Vec<Vec<CellChange>>,
    ) {
        hits.iter_mut().for_each(Vec::clear);
        let mut of_cell = Vec::new();
        for (input, (level, pulses)) in self.inputs.iter_mut().zip(pulses).enumerate() {
            let hits = if self.of_cells.is_empty() { &mut hits[input] } else { &mut of_cell };
            level.paint(block.clone(), pulses, |clock, bits| paint(input, clock, bits), hits);
            of_cell.clear();
        }
        changes.resize(self.of_cells.len(), Vec::new());
        changes.iter_mut().for_each(Vec::clear);
        let until = self.sampling.first_sample(block.end);
        let pulses = pulses.chunks(self.cells.count as usize);
        for ((levels, pulses), (hits, changes)) in
            self.of_cells.iter_mut().zip(pulses).zip(hits.iter_mut().zip(changes))
        {
            levels.advance(pulses, until, changes);
            let of_change = |change: &CellChange| {
                std::iter::repeat_n(change.sample, change.hits(&self.cells) as usize)
            };
            hits.extend(changes.iter().flat_map(of_change));
        }
    }
}

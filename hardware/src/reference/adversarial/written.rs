//! A run of the adversary as records of all ports.
//!
//! Its own reference model sees every clock that it decides, so that no other need predict them again.

use std::ops::Range;

use super::Adversarial;
use crate::photons::Pulse;
use crate::reference::blocks::{BLOCK_CLOCKS, Block, Records};
use crate::reference::levels::Levels;
use crate::reference::painter::InputPainter;
use crate::reference::predictor::{ReferenceModel, StepResult, Surroundings};
use crate::scan::Sample;
use crate::sensor::cells::CellChange;
use crate::sensor::layout::Layout;

/// A run of an adversary, which writes its records itself.
pub struct WrittenRun {
    adversary: Adversarial,
    /// Clocks of the blocks made so far.
    made: u64,
    /// The run is over there, whatever is decided.
    end: u64,
}

/// The clocks that were decided since the last block.
#[derive(Debug, Clone)]
pub(super) struct Written {
    painter: InputPainter,
    /// Words of an input record, and of an output record.
    words: [usize; 2],
    first_clock: u64,
    /// What is decided from there on is not predicted.
    end: u64,
    inputs: Vec<u64>,
    expected: Vec<u64>,
    finished: Vec<StepResult>,
}

impl Written {
    /// Where in the records of so many words each those of some clocks stand.
    fn place(&self, clocks: &Range<u64>, words: usize) -> Range<usize> {
        let at = |clock: u64| (clock - self.first_clock) as usize * words;
        at(clocks.start)..at(clocks.end)
    }

    /// Paints the levels of the clocks that are decided next, as [`InputPainter::samples`] does.
    pub(super) fn paint(
        &mut self,
        levels: &mut Levels,
        (clocks, pulses): (Range<u64>, &[Vec<Pulse>]),
        hits: &mut [Vec<Sample>],
        changes: &mut Vec<Vec<CellChange>>,
    ) {
        let place = self.place(&clocks, self.words[0]);
        self.inputs.resize(place.end, 0);
        let inputs = &mut self.inputs[place];
        self.painter.samples(levels, (clocks, pulses), inputs, hits, changes);
    }

    /// Has some of these clocks predicted.
    pub(super) fn predict(
        &mut self,
        scout: &mut ReferenceModel,
        surroundings: &mut Surroundings,
        hits: &[Vec<Sample>],
    ) {
        let clocks = &mut surroundings.clocks;
        clocks.end = clocks.end.min(self.end);
        if clocks.is_empty() {
            return;
        }
        let [inputs, expected] = self.words.map(|words| self.place(clocks, words));
        self.expected.resize(expected.end, 0);
        self.painter.surroundings(surroundings, &mut self.inputs[inputs]);
        scout.predict(surroundings, hits, &mut self.expected[expected]);
        self.finished.extend(scout.take_finished());
    }

    /// Gives what has been written, as far as the run goes, and begins anew at `next`.
    fn give(&mut self, next: u64, records: &mut Records) {
        records.first_clock = self.first_clock;
        self.inputs.truncate(self.place(&(self.first_clock..next), self.words[0]).end);
        self.first_clock = next;
        for (own, given) in
            [(&mut self.inputs, &mut records.inputs), (&mut self.expected, &mut records.expected)]
        {
            std::mem::swap(own, given);
            own.clear();
        }
    }
}

impl WrittenRun {
    /// A run of at most so many clocks, or of fewer where the adversary ends it, which has decided nothing yet.
    pub fn new(mut adversary: Adversarial, clocks: u64) -> WrittenRun {
        let layout = Layout::of(&adversary.interface);
        adversary.written = Some(Box::new(Written {
            painter: InputPainter::new(&layout.inputs, &adversary.interface),
            words: [layout.inputs.words, layout.outputs.words],
            first_clock: 0,
            end: clocks,
            inputs: Vec::new(),
            expected: Vec::new(),
            finished: Vec::new(),
        }));
        WrittenRun { adversary, made: 0, end: clocks }
    }

    /// Clocks of the blocks made so far.
    pub fn clocks_made(&self) -> u64 {
        self.made
    }

    /// Its reference model, which has seen them.
    pub fn reference(&self) -> &ReferenceModel {
        &self.adversary.scout
    }

    /// Results of the phase steps that ended in the last block made.
    pub fn take_finished(&mut self) -> impl Iterator<Item = StepResult> {
        self.adversary.written.iter_mut().flat_map(|written| written.finished.drain(..))
    }

    /// Makes the next block, without room for what the Verilog shows; false when there is none.
    pub fn make(&mut self, block: &mut Block) -> bool {
        let start = self.made;
        self.adversary.decide_before((start + BLOCK_CLOCKS).min(self.end));
        self.made = self.adversary.decided.min(self.end);
        let mut surroundings = Surroundings { clocks: start..self.made, ..Surroundings::default() };
        self.adversary.tell(&mut surroundings);
        (block.clocks, block.skips) = (surroundings.clocks, surroundings.skips);
        block.exercise.clone_from(self.adversary.scout.exercise());
        if let Some(written) = &mut self.adversary.written {
            written.give(self.made, &mut block.records);
        }
        !block.clocks.is_empty()
    }
}

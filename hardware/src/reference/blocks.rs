//! Blocks of clocks: the stimulus, and what the reference model makes of it.

use std::ops::Range;

use super::painter::InputPainter;
use super::stimulus::{Drive, Stimulus};
use crate::reference::exercise::Exercised;
use crate::reference::levels::Levels;
use crate::reference::predictor::{ReferenceModel, Skip, StepResult};
use crate::scan::Sample;
use crate::sensor::layout::Layout;

/// Clocks per block: its arrays stay in a core's second-level cache.
pub const BLOCK_CLOCKS: u64 = 16_384;

/// Output records of the Verilog.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    /// Values.
    pub values: Vec<u64>,
    /// Which of their bits are undefined; empty where none is.
    pub undefined: Vec<u64>,
}

impl Outputs {
    /// Marks as undefined, too, what is another value in `others`, as many records of a run with
    /// other bits for all that the Verilog leaves undefined.
    pub fn mark_undefined(&mut self, others: &Outputs) {
        if self.values != others.values {
            self.undefined.resize(self.values.len(), 0);
            let pairs = self.values.iter().zip(&others.values);
            for (undefined, (value, other)) in self.undefined.iter_mut().zip(pairs) {
                *undefined |= value ^ other;
            }
        }
    }

    /// Records of `words` words, each with its undefined bits, which are empty where none is.
    pub fn records(&self, words: usize) -> impl Iterator<Item = (&[u64], &[u64])> {
        let undefined = move |at: usize| self.undefined.get(at * words..(at + 1) * words);
        let values = self.values.chunks_exact(words).enumerate();
        values.map(move |(at, values)| (values, undefined(at).unwrap_or_default()))
    }

    /// Appends some words of others.
    pub fn append(&mut self, others: &Outputs, words: Range<usize>) {
        if !(self.undefined.is_empty() && others.undefined.is_empty()) {
            self.undefined.resize(self.values.len(), 0);
            match others.undefined.get(words.clone()) {
                Some(undefined) => self.undefined.extend_from_slice(undefined),
                None => self.undefined.resize(self.values.len() + words.len(), 0),
            }
        }
        self.values.extend_from_slice(&others.values[words]);
    }
}

/// Records of a stretch of clocks, as many of each kind as there are clocks.
#[derive(Debug, Clone, Default)]
pub struct Records {
    /// First clock.
    pub first_clock: u64,
    /// Input records.
    pub inputs: Vec<u64>,
    /// Output records of the reference model.
    pub expected: Vec<u64>,
    /// What the Verilog showed after each clock's rising edge.
    pub got: Outputs,
    /// What the Verilog showed just before each clock's rising edge, with the clock low and
    /// its inputs there: what a receiver takes with that edge. Empty where nothing can
    /// have moved since the edge before.
    pub low: Outputs,
}

impl Records {
    /// The clocks of these records.
    pub fn clocks(&self, layout: &Layout) -> Range<u64> {
        let count = self.got.values.len() / layout.outputs.words;
        self.first_clock..self.first_clock + count as u64
    }
}

/// A block on its way round.
#[derive(Default)]
pub struct Block {
    /// Its clocks.
    pub clocks: Range<u64>,
    /// Inputs and outputs of both sides.
    pub records: Records,
    /// Where steps and scans are cut short in it.
    pub skips: Vec<Skip>,
    /// What the outputs have shown up to its end.
    pub exercise: Exercised,
    /// Why the Verilog ended the simulation in it, if it did.
    pub halted: Option<String>,
}

/// Makes blocks: stimulus, input records, expected records.
pub struct BlockMaker<'a> {
    levels: Levels,
    drive: Drive,
    /// For each detector.
    hits: Vec<Vec<Sample>>,
    painter: InputPainter,
    reference: &'a mut ReferenceModel,
    stimulus: &'a mut dyn Stimulus,
    layout: &'a Layout,
    next: u64,
    clocks: u64,
}

impl<'a> BlockMaker<'a> {
    /// Makes blocks for a run of `clocks` clocks, or of fewer if the stimulus ends it.
    pub fn new(
        reference: &'a mut ReferenceModel,
        stimulus: &'a mut dyn Stimulus,
        layout: &'a Layout,
        clocks: u64,
    ) -> BlockMaker<'a> {
        let detectors = reference.interface().reference_codes.len();
        BlockMaker {
            levels: Levels::of(reference.interface()),
            drive: Drive::of(reference.interface()),
            hits: vec![Vec::new(); detectors],
            painter: InputPainter::new(&layout.inputs, reference.interface()),
            reference,
            stimulus,
            layout,
            next: 0,
            clocks,
        }
    }

    /// First samples of the runs of high samples in the last block made, for
    /// each detector.
    pub fn hits(&self) -> &[Vec<Sample>] {
        &self.hits
    }

    /// Results of the phase steps that ended in the blocks made so far; see
    /// [`ReferenceModel::take_finished`].
    pub fn take_finished(&mut self) -> impl Iterator<Item = StepResult> {
        self.reference.take_finished()
    }

    /// Clocks of the blocks made so far.
    pub fn clocks_made(&self) -> u64 {
        self.next
    }

    /// Makes the next block; false when there is none.
    pub fn make(&mut self, block: &mut Block) -> bool {
        if self.next >= self.clocks {
            return false;
        }
        self.drive.start(self.next..(self.next + BLOCK_CLOCKS).min(self.clocks));
        self.stimulus.drive(&mut self.drive);
        let clocks = self.drive.surroundings.clocks.clone();
        if clocks.is_empty() {
            return false;
        }
        self.next = clocks.end;
        let count = (clocks.end - clocks.start) as usize;
        let records = &mut block.records;
        records.first_clock = clocks.start;
        records.inputs.resize(count * self.layout.inputs.words, 0);
        records.expected.resize(count * self.layout.outputs.words, 0);
        records.got.values.resize(count * self.layout.outputs.words, 0);
        records.inputs.fill(0);
        let Drive { pulses, surroundings } = &mut self.drive;
        let cells = &mut surroundings.cells;
        let painted = (clocks.clone(), &pulses[..]);
        let (levels, inputs) = (&mut self.levels, &mut records.inputs);
        self.painter.samples(levels, painted, inputs, &mut self.hits, cells);
        self.painter.surroundings(surroundings, inputs);
        self.reference.predict(&self.drive.surroundings, &self.hits, &mut records.expected);
        block.clocks = clocks;
        block.skips.clone_from(&self.drive.surroundings.skips);
        block.exercise.clone_from(self.reference.exercise());
        block.halted = None;
        true
    }
}

/// Results of the phase steps that a stimulus makes in so many clocks, in order, with no record of any
/// port.
pub fn results(
    reference: &mut ReferenceModel,
    stimulus: &mut dyn Stimulus,
    clocks: u64,
    on_result: &mut dyn FnMut(StepResult),
) {
    let detectors = reference.interface().reference_codes.len();
    let mut levels = Levels::of(reference.interface());
    let mut drive = Drive::of(reference.interface());
    let mut hits: Vec<Vec<Sample>> = vec![Vec::new(); detectors];
    let mut next = 0;
    while next < clocks {
        drive.start(next..(next + BLOCK_CLOCKS).min(clocks));
        stimulus.drive(&mut drive);
        let Drive { pulses, surroundings } = &mut drive;
        if surroundings.clocks.is_empty() {
            return;
        }
        next = surroundings.clocks.end;
        levels.paint(
            surroundings.clocks.clone(),
            pulses,
            |_, _, _| (),
            &mut hits,
            &mut surroundings.cells,
        );
        reference.predict_results(&drive.surroundings, &hits);
        reference.take_finished().for_each(&mut *on_result);
    }
}

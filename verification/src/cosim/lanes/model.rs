//! A design in lanes, running. `testbench/lanes.cpp` is the other side.

use std::collections::VecDeque;
use std::sync::Arc;

use super::design::{Backend, LaneDesign};
use super::planes::Planes;
use crate::cosim::error::CosimError;
use crate::cosim::process::Process;

/// Blocks that the model may have at once: one being clocked, one waiting.
pub(super) const BLOCKS_AT_ONCE: usize = 2;

/// An output that follows a code: its plane at every clock of a period.
#[derive(Debug, Clone)]
pub(super) struct PeriodicOutput {
    /// The output.
    pub(super) output: usize,
    /// A row for each clock.
    pub(super) planes: Arc<Planes>,
    /// How many.
    pub(super) length: u64,
}

/// A block of clocks.
#[derive(Debug, Clone)]
pub(super) struct LaneBlock {
    /// Clocks.
    pub(super) clocks: u64,
    /// Lanes in reset.
    pub(super) reset: Planes,
    /// Lanes that are compared.
    pub(super) watched: Planes,
    /// Where the detectors' levels, low before the block, change: number of the sample in the
    /// block, planes of a clock one after another, times the model's lanes, plus the lane.
    pub(super) edges: Vec<u32>,
    /// Changes of the expected outputs, in order: clock of the block in the upper half, and in the
    /// lower one the output times the model's lanes, plus the lane.
    pub(super) events: Vec<u64>,
    /// Where each table stands.
    pub(super) phases: Vec<u64>,
}

/// What came of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BlockAnswer {
    /// Lanes that differed.
    pub(super) different: Planes,
    /// First clock of the block at which one did.
    pub(super) first_clock: u64,
    /// Clocks of the block at which a watched lane's result was valid, each with the
    /// planes of all outputs.
    pub(super) beats: Vec<(u64, Planes)>,
}

/// What the model is asked for; `testbench/lanes.cpp` has the same.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
enum What {
    Load = 0,
    Save = 1,
    Expect = 2,
    Tables = 3,
    Check = 4,
}

/// Words of the description of a block before its planes and phases.
const BLOCK_WORDS: u64 = 6;
/// Words before what is found of the lanes.
const FOUND_WORDS: u64 = 2;

/// A design in lanes, running.
#[derive(Debug)]
pub(super) struct LaneModel {
    process: Process,
    lanes: usize,
    registers: usize,
    outputs: u64,
    offsets: BlockOffsets,
    next_place: usize,
    under_way: VecDeque<usize>,
}

/// Where a block and what belongs to it lie in the shared file.
#[derive(Debug, Clone, Copy)]
struct BlockOffsets {
    /// First word of the first block.
    first: u64,
    /// Words of a block.
    words: u64,
    /// Words from the start of a block to its edges, its events, and what is found.
    edges: u64,
    events: u64,
    found: u64,
}

impl LaneModel {
    /// Starts a design with the tables of its codes.
    ///
    /// # Errors
    /// When it cannot be started.
    pub(super) fn load(
        design: &LaneDesign,
        backend: Backend,
        tables: &[PeriodicOutput],
    ) -> Result<LaneModel, CosimError> {
        assert_eq!(tables.len(), design.tables);
        let lanes = backend.lanes();
        let of_plane = lanes as u64 / 64;
        let outputs = design.outputs as u64;
        let tables_at = (design.registers.len() as u64).max(outputs) * of_plane;
        let data_at = tables_at + 3 * tables.len() as u64;
        let clocks = design.block_clocks;
        // An edge has half a word, and every sample may be one.
        let most_edges = clocks * design.samples as u64 * lanes as u64;
        let edges = BLOCK_WORDS + 2 * of_plane + tables.len() as u64;
        let events = edges + most_edges / 2;
        let found = events + clocks * outputs * lanes as u64;
        let offsets = BlockOffsets {
            first: data_at + tables.iter().map(|table| table.length * of_plane).sum::<u64>(),
            words: found + FOUND_WORDS + of_plane + clocks * (outputs * of_plane + 1),
            edges,
            events,
            found,
        };
        let words = offsets.first + BLOCKS_AT_ONCE as u64 * offsets.words;
        let mut model = LaneModel {
            process: Process::load(design.built(backend), words)?,
            lanes,
            registers: design.registers.len(),
            outputs,
            offsets,
            next_place: 0,
            under_way: VecDeque::new(),
        };
        model.set_tables(tables, tables_at, data_at).map_err(halted)?;
        Ok(model)
    }

    fn set_tables(
        &mut self,
        tables: &[PeriodicOutput],
        at: u64,
        mut data_at: u64,
    ) -> Result<(), String> {
        let mut words = Vec::new();
        for table in tables {
            words.extend([table.output as u64, table.length, data_at]);
            self.process.write(data_at, table.planes.as_words())?;
            data_at += table.planes.as_words().len() as u64;
        }
        self.process.write(at, &words)?;
        self.ask(What::Tables, at)
    }

    fn ask(&mut self, what: What, at: u64) -> Result<(), String> {
        self.process.ask(what as u64, [at, 0, 0, 0, 0])?;
        self.process.answer()
    }

    /// Lanes that it clocks at once.
    pub(super) fn lanes(&self) -> usize {
        self.lanes
    }

    /// Sets all registers, a row each.
    pub(super) fn set_registers(&mut self, planes: &Planes) -> Result<(), String> {
        assert!(planes.rows().len() == self.registers && self.under_way.is_empty());
        self.process.write(0, planes.as_words())?;
        self.ask(What::Load, 0)
    }

    /// Reads all registers, a row each.
    pub(super) fn registers(&mut self) -> Result<Planes, String> {
        assert!(self.under_way.is_empty());
        self.ask(What::Save, 0)?;
        self.planes(0, self.registers)
    }

    /// Sets what all outputs are expected to be.
    pub(super) fn expect(&mut self, planes: &Planes) -> Result<(), String> {
        assert!(planes.rows().len() as u64 == self.outputs && self.under_way.is_empty());
        self.process.write(0, planes.as_words())?;
        self.ask(What::Expect, 0)
    }

    fn planes(&self, at: u64, rows: usize) -> Result<Planes, String> {
        let mut words = vec![0; rows * self.lanes / 64];
        self.process.read(at, &mut words)?;
        Ok(Planes::of_words(self.lanes, words))
    }

    /// Blocks under way.
    pub(super) fn under_way(&self) -> usize {
        self.under_way.len()
    }

    fn start_of(&self, place: usize) -> u64 {
        self.offsets.first + place as u64 * self.offsets.words
    }

    /// Hands over a block, and does not wait for its end. At most [`BLOCKS_AT_ONCE`]
    /// may be under way.
    pub(super) fn submit(&mut self, block: &LaneBlock) -> Result<(), String> {
        assert!(self.under_way.len() < BLOCKS_AT_ONCE);
        let place = self.next_place;
        self.next_place = (place + 1) % BLOCKS_AT_ONCE;
        let (at, offsets) = (self.start_of(place), self.offsets);
        let mut words = vec![
            block.clocks,
            block.edges.len() as u64,
            at + offsets.edges,
            block.events.len() as u64,
            at + offsets.events,
            at + offsets.found,
        ];
        words.extend(block.reset.as_words());
        words.extend(block.watched.as_words());
        words.extend(&block.phases);
        self.process.write(at, &words)?;
        self.process.write(at + offsets.edges, &block.edges)?;
        self.process.write(at + offsets.events, &block.events)?;
        self.process.ask(What::Check as u64, [at, 0, 0, 0, 0])?;
        self.under_way.push_back(place);
        Ok(())
    }

    /// Waits for the end of the block that was handed over first.
    pub(super) fn collect(&mut self) -> Result<BlockAnswer, String> {
        let place = self.under_way.pop_front().expect("a block is under way");
        self.process.answer()?;
        let at = self.start_of(place) + self.offsets.found;
        let mut head = [0; FOUND_WORDS as usize];
        self.process.read(at, &mut head)?;
        let [first_clock, beats] = head;
        let different = self.planes(at + FOUND_WORDS, 1)?;
        let of_plane = self.lanes as u64 / 64;
        let beat = |number: u64| {
            let at = at + FOUND_WORDS + of_plane + number * (1 + self.outputs * of_plane);
            let mut clock = [0];
            self.process.read(at, &mut clock)?;
            Ok((clock[0], self.planes(at + 1, self.outputs as usize)?))
        };
        let beats = (0..beats).map(beat).collect::<Result<_, String>>()?;
        Ok(BlockAnswer { different, first_clock, beats })
    }
}

/// A model of ours that ended by itself.
pub(super) fn halted(reason: String) -> CosimError {
    CosimError::Halted {
        when: crate::cosim::error::When::Start,
        reason: format!("in lanes: {reason}"),
    }
}

//! A design in lanes, running. `testbench/lanes.cpp` is the other side.

use std::collections::VecDeque;
use std::sync::Arc;

use super::design::Design;
use crate::cosim::error::CosimError;
use crate::cosim::process::Process;

/// Clocks of a block: its samples stay in a core's second-level cache.
pub const BLOCK_CLOCKS: u64 = 4_096;
/// Blocks that the model may have at once: one being clocked, one waiting.
pub const BLOCKS_AT_ONCE: usize = 2;

/// An output that follows a code: its plane at every clock of a period.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// The output.
    pub(super) output: usize,
    /// Planes.
    pub(super) planes: Arc<Vec<u64>>,
}

/// A change of what an output is expected to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event {
    /// Clock of the block, from which on it holds.
    pub(super) clock: u64,
    /// The output.
    pub(super) output: usize,
    /// Lanes in which it changes.
    pub(super) flips: u64,
}

/// A block of clocks.
#[derive(Debug, Clone, Default)]
pub(super) struct LaneBlock {
    /// Clocks.
    pub(super) clocks: u64,
    /// Lanes in reset.
    pub(super) reset: u64,
    /// Lanes that are compared.
    pub(super) watched: u64,
    /// Planes of samples, clock after clock.
    pub(super) samples: Vec<u64>,
    /// Changes of the expected outputs, in order.
    pub(super) events: Vec<Event>,
    /// Where each table stands.
    pub(super) phases: Vec<u64>,
}

/// What came of a block.
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    /// Lanes that differed.
    pub(super) different: u64,
    /// First clock of the block at which one did.
    pub(super) first_clock: u64,
    /// Clocks of the block at which a watched lane's result was valid, each with the
    /// planes of all outputs.
    pub(super) beats: Vec<(u64, Vec<u64>)>,
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

/// Words before the phases in the description of a block.
const BLOCK_WORDS: u64 = 8;
/// Words of an event.
const EVENT_WORDS: u64 = 3;
/// Words before the beats in what is found.
const FOUND_WORDS: u64 = 3;

/// A design in lanes, running.
#[derive(Debug)]
pub(super) struct LaneModel {
    process: Process,
    registers: usize,
    outputs: u64,
    samples: u64,
    /// First word of the first block.
    blocks_at: u64,
    block_words: u64,
    tables: u64,
    next_place: usize,
    under_way: VecDeque<usize>,
}

impl LaneModel {
    /// Starts a design with the tables of its codes.
    ///
    /// # Errors
    /// When it cannot be started.
    pub(super) fn load(design: &Design, tables: &[Table]) -> Result<LaneModel, CosimError> {
        let (outputs, samples) = (design.outputs as u64, design.samples as u64);
        assert_eq!(tables.len(), design.tables);
        let lengths = tables.iter().map(|table| table.planes.len() as u64);
        let scratch = (design.registers.len() as u64).max(outputs);
        let tables_at = scratch;
        let data_at = tables_at + 3 * tables.len() as u64;
        let blocks_at = data_at + lengths.sum::<u64>();
        let block_words = BLOCK_WORDS
            + tables.len() as u64
            + BLOCK_CLOCKS * samples
            + BLOCK_CLOCKS * outputs * EVENT_WORDS
            + FOUND_WORDS
            + BLOCK_CLOCKS * (outputs + 1);
        let words = blocks_at + BLOCKS_AT_ONCE as u64 * block_words;
        let mut model = LaneModel {
            process: Process::load(&design.built, words)?,
            registers: design.registers.len(),
            outputs,
            samples,
            blocks_at,
            block_words,
            tables: tables.len() as u64,
            next_place: 0,
            under_way: VecDeque::new(),
        };
        model.set_tables(tables, tables_at, data_at).map_err(halted)?;
        Ok(model)
    }

    fn set_tables(&mut self, tables: &[Table], at: u64, mut data_at: u64) -> Result<(), String> {
        let mut words = Vec::new();
        for table in tables {
            let length = table.planes.len() as u64;
            words.extend([table.output as u64, length, data_at]);
            self.process.write(data_at, &table.planes)?;
            data_at += length;
        }
        self.process.write(at, &words)?;
        self.ask(What::Tables, at)
    }

    fn ask(&mut self, what: What, at: u64) -> Result<(), String> {
        self.process.ask(what as u64, [at, 0, 0, 0, 0])?;
        self.process.answer()
    }

    /// Sets all registers, one plane each.
    pub(super) fn set_registers(&mut self, planes: &[u64]) -> Result<(), String> {
        assert!(planes.len() == self.registers && self.under_way.is_empty());
        self.process.write(0, planes)?;
        self.ask(What::Load, 0)
    }

    /// Reads all registers, one plane each.
    pub(super) fn registers(&mut self) -> Result<Vec<u64>, String> {
        assert!(self.under_way.is_empty());
        self.ask(What::Save, 0)?;
        let mut planes = vec![0; self.registers];
        self.process.read(0, &mut planes)?;
        Ok(planes)
    }

    /// Sets what all outputs are expected to be.
    pub(super) fn expect(&mut self, planes: &[u64]) -> Result<(), String> {
        assert!(planes.len() as u64 == self.outputs && self.under_way.is_empty());
        self.process.write(0, planes)?;
        self.ask(What::Expect, 0)
    }

    /// Blocks under way.
    pub(super) fn under_way(&self) -> usize {
        self.under_way.len()
    }

    /// Hands over a block, and does not wait for its end. At most [`BLOCKS_AT_ONCE`]
    /// may be under way.
    pub(super) fn submit(&mut self, block: &LaneBlock) -> Result<(), String> {
        assert!(self.under_way.len() < BLOCKS_AT_ONCE && block.clocks <= BLOCK_CLOCKS);
        assert_eq!(block.samples.len() as u64, block.clocks * self.samples);
        let place = self.next_place;
        self.next_place = (place + 1) % BLOCKS_AT_ONCE;
        let at = self.blocks_at + place as u64 * self.block_words;
        let samples_at = at + BLOCK_WORDS + self.tables;
        let events_at = samples_at + BLOCK_CLOCKS * self.samples;
        let mut words = vec![
            block.clocks,
            block.reset,
            block.watched,
            !block.reset,
            samples_at,
            block.events.len() as u64,
            events_at,
            self.found_at(place),
        ];
        words.extend(&block.phases);
        let events: Vec<u64> = block
            .events
            .iter()
            .flat_map(|event| [event.clock, event.output as u64, event.flips])
            .collect();
        self.process.write(at, &words)?;
        self.process.write(samples_at, &block.samples)?;
        self.process.write(events_at, &events)?;
        self.process.ask(What::Check as u64, [at, 0, 0, 0, 0])?;
        self.under_way.push_back(place);
        Ok(())
    }

    fn found_at(&self, place: usize) -> u64 {
        let at = self.blocks_at + place as u64 * self.block_words;
        at + self.block_words - FOUND_WORDS - BLOCK_CLOCKS * (self.outputs + 1)
    }

    /// Waits for the end of the block that was handed over first.
    pub(super) fn collect(&mut self) -> Result<Found, String> {
        let place = self.under_way.pop_front().expect("a block is under way");
        self.process.answer()?;
        let at = self.found_at(place);
        let mut head = [0; FOUND_WORDS as usize];
        self.process.read(at, &mut head)?;
        let [different, first_clock, beats] = head;
        let words = self.outputs as usize + 1;
        let beats = beats.min(BLOCK_CLOCKS) as usize;
        let mut list = vec![0; beats * words];
        self.process.read(at + FOUND_WORDS, &mut list)?;
        Ok(Found {
            different,
            first_clock,
            beats: list.chunks_exact(words).map(|beat| (beat[0], beat[1..].to_vec())).collect(),
        })
    }
}

/// A model of ours that ended by itself.
pub(super) fn halted(reason: String) -> CosimError {
    CosimError::Halted {
        when: crate::cosim::error::When::Start,
        reason: format!("in lanes: {reason}"),
    }
}

//! Runs the verilated model and the reference model side by side.
//!
//! One thread makes stimulus and expectation and compares; the verilated model
//! is a process of its own, which another thread keeps busy. Blocks of clocks go round between
//! them, so memory does not grow with the length of the run.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use super::comparison::OutputComparison;
use super::error::{CosimError, When};
use super::mismatch::{Mismatch, MismatchKind};
use super::sent::{SentCount, SentReader};
use super::verilated::{BLOCKS_AT_ONCE, Verilated};
use super::window::{Kept, Shown, Window};
use crate::reference::blocks::{Block, BlockMaker, Records};
use crate::reference::exercise::Exercised;
use crate::reference::predictor::{ReferenceModel, StepResult};
use crate::reference::stimulus::Stimulus;
use crate::sensor::layout::Layout;

/// Blocks on their way: one being clocked, one waiting, one being made.
const BLOCKS: usize = 3;

/// What came of a run.
#[derive(Debug, Clone)]
pub struct LockstepOutcome {
    /// Clocks compared.
    pub clocks: u64,
    /// Of these, clocks at which some port differed. After the first the run
    /// goes on only to the end of the block after it.
    pub mismatches: u64,
    /// The first of them.
    pub first: Option<Mismatch>,
    /// The clocks round the first mismatch, or else the first result.
    pub found: Shown,
    /// The clocks that were asked for, if the run came to them.
    pub asked: Option<Shown>,
    /// Whether what the result stream holds while it is not valid was free to differ.
    pub ignores_idle_payload: bool,
    /// What the outputs have shown within these clocks.
    pub exercise: Exercised,
    /// What the Verilog showed after the last clock.
    pub last_outputs: Vec<u64>,
    /// Wall time of the run, without building or loading.
    pub elapsed: Duration,
}

/// Both sides of a run.
pub struct Lockstep<'a> {
    /// The Verilog.
    pub model: &'a mut Verilated,
    /// The reference model.
    pub reference: &'a mut ReferenceModel,
    /// What drives both.
    pub stimulus: &'a mut dyn Stimulus,
    /// The records' layout.
    pub layout: &'a Layout,
    /// The clocks to keep.
    pub window: Window,
}

impl Lockstep<'_> {
    /// Runs `clocks` clocks. `on_result` gets the result of every finished phase
    /// step in order, `on_progress` the number of clocks compared so far.
    ///
    /// # Errors
    /// When the Verilog ends the simulation by itself.
    pub fn run(
        self,
        clocks: u64,
        mut on_result: impl FnMut(StepResult),
        mut on_progress: impl FnMut(u64),
    ) -> Result<LockstepOutcome, CosimError> {
        self.run_and_read(clocks, &mut on_result, &mut |_| (), &mut on_progress)
    }

    /// [`Lockstep::run`], and `on_sent` gets what the Verilog's result stream sends;
    /// always after `on_result` for the same step.
    ///
    /// # Errors
    /// When the Verilog ends the simulation by itself.
    pub fn run_and_read(
        self,
        clocks: u64,
        on_result: &mut dyn FnMut(StepResult),
        on_sent: &mut dyn FnMut(SentCount),
        on_progress: &mut dyn FnMut(u64),
    ) -> Result<LockstepOutcome, CosimError> {
        let started = Instant::now();
        let mut reader = SentReader::new(self.reference.interface(), self.layout);
        let mut maker = BlockMaker::new(self.reference, self.stimulus, self.layout, clocks);
        let model = self.model;
        let mut judge = Judge::new(self.layout, model.is_users, self.window);
        thread::scope(|scope| {
            let (to_model, blocks) = sync_channel::<Block>(BLOCKS);
            let (done, from_model) = sync_channel::<Block>(BLOCKS);
            scope.spawn(move || clock_blocks(model, &blocks, &done));
            let mut spare: Vec<Block> = (0..BLOCKS).map(|_| Block::default()).collect();
            let mut under_way = 0;
            loop {
                while let Some(mut block) = spare.pop() {
                    if !maker.make(&mut block) {
                        break;
                    }
                    maker.take_finished().for_each(&mut *on_result);
                    if to_model.send(block).is_err() {
                        break;
                    }
                    under_way += 1;
                }
                if under_way == 0 {
                    break;
                }
                let Ok(block) = from_model.recv() else {
                    break;
                };
                under_way -= 1;
                if let Some(reason) = block.halted {
                    return Err(CosimError::Halted {
                        when: When::BlockFrom(block.clocks.start),
                        reason,
                    });
                }
                reader.read(&block.records, on_sent);
                on_progress(block.clocks.end);
                match judge.judge(block) {
                    Some(block) => spare.push(block),
                    None => break,
                }
            }
            Ok(())
        })?;
        Ok(judge.outcome(started.elapsed()))
    }
}

/// The other thread: keeps the model busy until no more blocks come.
fn clock_blocks(model: &mut Verilated, blocks: &Receiver<Block>, done: &SyncSender<Block>) {
    let mut under_way = VecDeque::new();
    loop {
        while under_way.len() < BLOCKS_AT_ONCE {
            // With one under way there is something better to do than to wait.
            let next =
                if under_way.is_empty() { blocks.recv().ok() } else { blocks.try_recv().ok() };
            let Some(mut block) = next else {
                break;
            };
            block.halted =
                model.submit(&block.records.inputs, block.clocks.start, &block.skips).err();
            under_way.push_back(block);
        }
        let Some(mut block) = under_way.pop_front() else {
            return;
        };
        if block.halted.is_none() {
            block.halted = model.collect(&mut block.records).err();
        }
        let is_over = block.halted.is_some();
        if done.send(block).is_err() || is_over {
            return model.discard();
        }
    }
}

/// Whether all outputs are defined, as expected, and still so before the next rising edge; `last`
/// is what was expected of the clock before these, if any.
fn is_as_expected(records: &Records, last: &[u64], words: usize) -> bool {
    let Records { expected, got, low, .. } = records;
    let is_still = low.values.split_at_checked(words).is_none_or(|(first, rest)| {
        rest == &expected[..rest.len()] && (last.is_empty() || first == last)
    });
    *expected == got.values && is_still && got.undefined.is_empty() && low.undefined.is_empty()
}

/// Compares blocks, and keeps what waveforms are made of.
struct Judge<'a> {
    comparison: OutputComparison<'a>,
    clocks: u64,
    mismatches: u64,
    /// The last of them.
    last_different: Option<u64>,
    /// What was expected of the last clock.
    last_expected: Vec<u64>,
    first: Option<Mismatch>,
    kept: Kept<'a>,
    exercise: Exercised,
    last_outputs: Vec<u64>,
}

impl<'a> Judge<'a> {
    fn new(layout: &'a Layout, ignores_idle_payload: bool, window: Window) -> Judge<'a> {
        Judge {
            comparison: OutputComparison { layout, ignores_idle_payload },
            clocks: 0,
            mismatches: 0,
            last_different: None,
            last_expected: Vec::new(),
            first: None,
            kept: Kept::new(layout, window),
            exercise: Exercised::default(),
            last_outputs: Vec::new(),
        }
    }

    /// Compares a block; gives one back to be used again, or nothing when enough is known.
    fn judge(&mut self, mut block: Block) -> Option<Block> {
        self.clocks = block.clocks.end;
        self.exercise.clone_from(&block.exercise);
        let got = &block.records.got.values;
        let last_record = got.len() - self.comparison.layout.outputs.words;
        self.last_outputs.clear();
        self.last_outputs.extend_from_slice(&got[last_record..]);
        let known = self.first.is_some();
        self.find(&block.records);
        self.last_expected.clear();
        self.last_expected.extend_from_slice(&block.records.expected[last_record..]);
        let found = self.first.as_ref().filter(|_| !known);
        let mismatch = found.map(|first| first.clock);
        block.records = self.kept.take(block.records, mismatch);
        (!known).then_some(block)
    }

    /// Looks for differences, in the order in which they show.
    fn find(&mut self, records: &Records) {
        let words = self.comparison.layout.outputs.words;
        let last = self.last_expected.clone();
        if is_as_expected(records, &last, words) {
            return;
        }
        let mut low = records.low.records(words);
        let mut before = last.as_slice();
        let sides = records.expected.chunks_exact(words).zip(records.got.records(words));
        for (clock, (expected, got)) in (records.first_clock..).zip(sides) {
            if let Some(low) = low.next().filter(|_| !before.is_empty()) {
                self.compare(clock - 1, MismatchKind::Moved, before, low);
            }
            self.compare(clock, MismatchKind::Value, expected, got);
            before = expected;
        }
    }

    fn compare(&mut self, clock: u64, kind: MismatchKind, expected: &[u64], got: (&[u64], &[u64])) {
        let Some(mismatch) = self.comparison.mismatch(clock, kind, expected, got) else {
            return;
        };
        if self.last_different.replace(clock) != Some(clock) {
            self.mismatches += 1;
        }
        self.first.get_or_insert(mismatch);
    }

    fn outcome(self, elapsed: Duration) -> LockstepOutcome {
        let (found, asked) = self.kept.into_shown();
        LockstepOutcome {
            clocks: self.clocks,
            mismatches: self.mismatches,
            first: self.first,
            found,
            asked,
            ignores_idle_payload: self.comparison.ignores_idle_payload,
            exercise: self.exercise,
            last_outputs: self.last_outputs,
            elapsed,
        }
    }
}

//! A verilated `sensor_top`, clocked in blocks. `testbench/cosim.cpp` is the other
//! side.
//!
//! Verilator has two states and Verilog four. So several processes run the same blocks. Every
//! bit that Verilog leaves undefined, of a register before its reset or of an x, is a pseudo-random
//! one in the first, the opposite in the second, and another pseudo-random one in each behind it:
//! where their outputs differ these are undefined. As soon as one holds the same as the first it has
//! nothing more to say until the first makes use of an x. Then it takes up what the first held
//! before that block, and runs the block with its own x.

use std::collections::VecDeque;

use super::build::Built;
use super::error::CosimError;
use super::ports::{MOST_SKIPS, STATE_BYTES};
use super::process::Process;
use crate::reference::blocks::{BLOCK_CLOCKS, Records};
use crate::reference::predictor::Skip;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::layout::Layout;

/// Blocks that the model may have at once: one being clocked, one waiting.
pub const BLOCKS_AT_ONCE: usize = 2;

/// Words of a skip: the clock in its block, and what goes into the two counters.
const SKIP_WORDS: usize = 3;

/// Processes beside the first: the opposite, and two of other bits.
const COMPANIONS: u32 = 3;
/// Blocks that those of other bits run at most: what cancels (`a ^ b` of two registers that nothing
/// resets) shows as soon as it is looked at.
const BLOCKS_OF_OTHER_BITS: u32 = 64;
/// What the model is asked for; `testbench/cosim.cpp` has the same.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
enum What {
    Run = 0,
    RunBare = 1,
    Finish = 2,
}

/// What of the state is asked for, added up; `testbench/cosim.cpp` has the same.
const HASH: u64 = 1;
const KEEP: u64 = 2;
const TAKE: u64 = 4;

/// One instance of a verilated model.
#[derive(Debug)]
pub struct Verilated {
    process: Process,
    /// Those with other bits for what is undefined.
    companions: Vec<Companion>,
    place: BlockLayout,
    /// Whether its Verilog is the user's own.
    pub(super) is_users: bool,
    /// What moves its scan's counters on.
    registers: Option<ScanRegisters>,
    /// Where the next block goes.
    next_place: usize,
    /// The blocks that it has.
    under_way: VecDeque<UnderWay>,
}

/// A process that runs the same blocks with other bits.
#[derive(Debug)]
struct Companion {
    process: Process,
    /// Whether it holds what the first one does, and waits.
    rests: bool,
    /// Blocks that it has, the latest of those under way.
    blocks: usize,
    /// Blocks that it may yet run.
    left: Option<u32>,
}

/// A block under way.
#[derive(Debug)]
struct UnderWay {
    place: usize,
    clocks: usize,
    /// Of skips.
    words: Vec<u64>,
}

impl UnderWay {
    fn ask(&self, process: &mut Process, at: BlockLayout, state: u64) -> Result<(), String> {
        let skips = (self.words.len() / SKIP_WORDS) as u64;
        process.write(at.skips_at(self.place), &self.words)?;
        let arguments = [self.clocks as u64, at.start(self.place), skips, state, 0];
        process.ask(What::Run as u64, arguments)
    }
}

impl Verilated {
    /// Starts the program that [`super::build::build`] made for this layout.
    ///
    /// # Errors
    /// When it cannot be started, or ends before its first clock.
    pub fn load(built: &Built, layout: &Layout) -> Result<Verilated, CosimError> {
        let (input_words, output_words) = (layout.inputs.words, layout.outputs.words);
        let place = BlockLayout { input_words, output_words };
        let words = BLOCKS_AT_ONCE as u64 * place.words();
        let companion = |number| {
            let process = Process::load_another(built, words, number)?;
            let left = (number > 1).then_some(BLOCKS_OF_OTHER_BITS);
            Ok(Companion { process, rests: false, blocks: 0, left })
        };
        Ok(Verilated {
            process: Process::load(built, words)?,
            companions: (1..=COMPANIONS).map(companion).collect::<Result<_, CosimError>>()?,
            place,
            is_users: built.is_users,
            registers: built.registers.clone(),
            next_place: 0,
            under_way: VecDeque::new(),
        })
    }

    /// Hands over the input records of a block, one per clock, and does not wait
    /// for its end. At most [`BLOCKS_AT_ONCE`] may be under way. `skips` are those of
    /// the block, which begins with `first_clock`.
    ///
    /// # Errors
    /// The reason when the model has ended.
    ///
    /// # Panics
    /// When the block is too long, too many are under way, or there are skips of a
    /// model that was built without the scan's counters.
    pub fn submit(
        &mut self,
        input: &[u64],
        first_clock: u64,
        skips: &[Skip],
    ) -> Result<(), String> {
        let clocks = input.len() / self.place.input_words;
        assert_eq!(input.len(), clocks * self.place.input_words);
        assert!(clocks as u64 <= BLOCK_CLOCKS && self.under_way.len() < BLOCKS_AT_ONCE);
        let place = self.next_place;
        self.next_place = (place + 1) % BLOCKS_AT_ONCE;
        let block = UnderWay { place, clocks, words: self.skip_words(first_clock, skips) };
        let runs = self.companions.iter().any(|companion| !companion.rests);
        let state = match (self.companions.is_empty(), runs) {
            (true, _) => 0,
            (false, true) => HASH + KEEP,
            (false, false) => KEEP,
        };
        self.process.write(self.place.input_at(place), input)?;
        block.ask(&mut self.process, self.place, state)?;
        self.under_way.push_back(block);
        for number in 0..self.companions.len() {
            self.go_on(number)?;
        }
        Ok(())
    }

    /// Hands a process that does not rest the blocks under way that it does not have.
    fn go_on(&mut self, number: usize) -> Result<(), String> {
        let companion = &mut self.companions[number];
        if companion.rests {
            return Ok(());
        }
        for block in self.under_way.iter().skip(companion.blocks) {
            let mut input = vec![0; block.clocks * self.place.input_words];
            let at = self.place.input_at(block.place);
            self.process.read(at, &mut input)?;
            companion.process.write(at, &input)?;
            block.ask(&mut companion.process, self.place, HASH)?;
        }
        companion.blocks = self.under_way.len();
        Ok(())
    }

    fn skip_words(&mut self, first_clock: u64, skips: &[Skip]) -> Vec<u64> {
        assert!(skips.len() <= MOST_SKIPS);
        let mut words = Vec::with_capacity(skips.len() * SKIP_WORDS);
        for skip in skips {
            let registers = self.registers.as_mut().expect("a model with counters");
            let chips = registers.chips.as_mut();
            let groups = registers.groups.as_mut();
            words.extend([
                skip.clock - first_clock,
                chips.map_or(0, |register| register.difference(skip.chip, skip.chips)),
                groups.map_or(0, |register| register.difference(skip.group.0, skip.groups)),
            ]);
        }
        words
    }

    /// Waits for the end of the block that was handed over first, and writes its
    /// output records: one per clock, and one more where the low half can move any.
    ///
    /// # Errors
    /// The reason when the model has ended.
    ///
    /// # Panics
    /// When no block is under way, or it has another length.
    pub fn collect(&mut self, records: &mut Records) -> Result<(), String> {
        let block = self.under_way.front().expect("a block is under way");
        let words = block.clocks * self.place.output_words;
        let place = block.place;
        assert_eq!(records.got.values.len(), words);
        self.process.answer()?;
        let head = self.place.read(&self.process, place, records)?;
        records.got.undefined.clear();
        records.low.undefined.clear();
        for number in 0..self.companions.len() {
            if self.take_up(number, &head)? {
                let companion = &mut self.companions[number];
                companion.process.answer()?;
                companion.blocks -= 1;
                let mut others = Records::default();
                others.got.values.resize(words, 0);
                let other = self.place.read(&companion.process, place, &mut others)?;
                records.got.mark_undefined(&others.got);
                records.low.mark_undefined(&others.low);
                let is_known = head.may_read_x == 0 || head.kept_bytes > 0;
                companion.rests = is_known && head.state != 0 && other.state == head.state;
                companion.left = companion.left.map(|left| left.saturating_sub(1));
            }
        }
        self.under_way.pop_front();
        self.companions.retain(|companion| {
            companion.left != Some(0) && (head.may_read_x != 0 || !companion.rests)
        });
        (0..self.companions.len()).try_for_each(|number| self.go_on(number))
    }

    /// Whether a process runs the first block under way: it has it, or it has rested and takes
    /// up the state before it, since an x is made use of.
    fn take_up(&mut self, number: usize, head: &Head) -> Result<bool, String> {
        let companion = &mut self.companions[number];
        if companion.blocks > 0 || head.has_read_x == 0 {
            return Ok(companion.blocks > 0);
        }
        let block = &self.under_way[0];
        let mut input = vec![0; block.clocks * self.place.input_words];
        let at = self.place.input_at(block.place);
        self.process.read(at, &mut input)?;
        companion.process.write(at, &input)?;
        let mut kept = vec![0; head.kept_bytes.div_ceil(8) as usize];
        let at = self.place.kept_at(block.place);
        self.process.read(at, &mut kept)?;
        companion.process.write(at, &kept)?;
        block.ask(&mut companion.process, self.place, HASH + TAKE)?;
        companion.blocks = 1;
        Ok(true)
    }

    /// Waits for the end of the blocks that are under way, and for nothing of what
    /// they give.
    pub fn discard(&mut self) {
        for _ in 0..self.under_way.len() {
            if self.process.answer().is_err() {
                return;
            }
        }
        for companion in &mut self.companions {
            for _ in 0..companion.blocks {
                if companion.process.answer().is_err() {
                    return;
                }
            }
        }
        self.under_way.clear();
    }

    /// Runs clocks with one constant input record and reads nothing: the speed
    /// that co-simulation is measured against.
    ///
    /// # Errors
    /// As [`Verilated::collect`].
    ///
    /// # Panics
    /// When `input` is not one record.
    pub fn run_bare(&mut self, input: &[u64], clocks: u64) -> Result<(), String> {
        assert_eq!(input.len(), self.place.input_words);
        self.process.write(self.place.input_at(0), input)?;
        self.ask(What::RunBare, clocks)?;
        self.process.answer()
    }

    /// Runs the final blocks. The last that may be asked for.
    ///
    /// # Errors
    /// The reason when one of them ends the simulation with more than `$finish`,
    /// which a final block may call.
    pub fn finish(&mut self) -> Result<(), String> {
        let asked = self.ask(What::Finish, 0);
        match asked.and_then(|()| self.process.answer()) {
            Err(reason) if !reason.starts_with("$finish") => Err(reason),
            _ => Ok(()),
        }
    }

    fn ask(&mut self, what: What, clocks: u64) -> Result<(), String> {
        self.process.ask(what as u64, [clocks, self.place.start(0), 0, 0, 0])
    }
}

/// Where a block lies in the shared file: `BlockLayout` of `testbench/cosim.cpp`.
#[derive(Debug, Clone, Copy)]
struct BlockLayout {
    input_words: usize,
    output_words: usize,
}

/// What a process tells of a block beside its outputs: the first words of `BlockLayout` of
/// `testbench/cosim.cpp`.
#[derive(Debug, Clone, Copy)]
struct Head {
    /// A hash of what the model holds after the block; 0 if it was not asked for.
    state: u64,
    /// Whether the model has an x that it may make use of at any time.
    may_read_x: u64,
    /// Whether one was made use of.
    has_read_x: u64,
    /// Bytes of what it held before the block; 0 if it was not asked for or did not fit.
    kept_bytes: u64,
}

impl BlockLayout {
    /// Words of [`Head`].
    const HEAD: u64 = 5;

    fn words(self) -> u64 {
        let records = BLOCK_CLOCKS * (self.input_words + 2 * self.output_words) as u64;
        BlockLayout::HEAD + records + (MOST_SKIPS * SKIP_WORDS) as u64 + STATE_BYTES / 8
    }

    fn start(self, place: usize) -> u64 {
        place as u64 * self.words()
    }

    fn input_at(self, place: usize) -> u64 {
        self.start(place) + BlockLayout::HEAD
    }

    fn output_at(self, place: usize) -> u64 {
        self.input_at(place) + BLOCK_CLOCKS * self.input_words as u64
    }

    fn low_at(self, place: usize) -> u64 {
        self.output_at(place) + BLOCK_CLOCKS * self.output_words as u64
    }

    fn skips_at(self, place: usize) -> u64 {
        self.low_at(place) + BLOCK_CLOCKS * self.output_words as u64
    }

    fn kept_at(self, place: usize) -> u64 {
        self.skips_at(place) + (MOST_SKIPS * SKIP_WORDS) as u64
    }

    /// Reads the outputs of a block, and what else is told of it.
    fn read(self, process: &Process, place: usize, records: &mut Records) -> Result<Head, String> {
        let mut head = [0; BlockLayout::HEAD as usize];
        process.read(self.start(place), &mut head)?;
        let [looks_again, state, may_read_x, has_read_x, kept_bytes] = head;
        let words = records.got.values.len();
        process.read(self.output_at(place), &mut records.got.values)?;
        records.low.values.resize(if looks_again == 0 { 0 } else { words }, 0);
        process.read(self.low_at(place), &mut records.low.values)?;
        Ok(Head { state, may_read_x, has_read_x, kept_bytes })
    }
}

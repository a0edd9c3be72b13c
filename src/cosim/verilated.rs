//! A verilated `sensor_top`, clocked in blocks. `testbench/cosim.cpp` is the other
//! side.
//!
//! Verilator has two states and Verilog four. So two processes run the same blocks, and every
//! bit that Verilog leaves undefined, of a register before its reset or of an x, is 0 in one
//! and 1 in the other: where their outputs differ these are undefined. As soon as all that both
//! hold is the same the second has nothing more to say, and ends.

use std::collections::VecDeque;

use super::build::Built;
use super::error::CosimError;
use super::ports::MOST_SKIPS;
use super::process::Process;
use crate::reference::blocks::{BLOCK_CLOCKS, Records};
use crate::reference::predictor::Skip;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::layout::Layout;

/// Blocks that the model may have at once: one being clocked, one waiting.
pub const BLOCKS_AT_ONCE: usize = 2;

/// Words of a skip: the clock in its block, and what goes into the two counters.
const SKIP_WORDS: usize = 3;

/// What the model is asked for; `testbench/cosim.cpp` has the same.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
enum What {
    Run = 0,
    RunBare = 1,
    Finish = 2,
}

/// One instance of a verilated model.
#[derive(Debug)]
pub struct Verilated {
    process: Process,
    /// The one with the opposite of all undefined bits, until both hold the same.
    opposite: Option<Process>,
    place: Place,
    /// Whether its Verilog is the user's own.
    pub(super) is_users: bool,
    /// What moves its scan's counters on.
    registers: Option<ScanRegisters>,
    /// Where the next block goes.
    next_place: usize,
    /// Places and clocks of the blocks that it has.
    under_way: VecDeque<(usize, usize)>,
}

impl Verilated {
    /// Starts the program that [`super::build::build`] made for this layout.
    ///
    /// # Errors
    /// When it cannot be started, or ends before its first clock.
    pub fn load(built: &Built, layout: &Layout) -> Result<Verilated, CosimError> {
        let (input_words, output_words) = (layout.inputs.words, layout.outputs.words);
        let place = Place { input_words, output_words };
        let words = BLOCKS_AT_ONCE as u64 * place.words();
        Ok(Verilated {
            process: Process::load(built, words)?,
            opposite: Some(Process::load_opposite(built, words)?),
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
        let skip_words = self.skip_words(first_clock, skips);
        let wants_state = u64::from(self.opposite.is_some());
        let start = self.place.start(place);
        for process in [Some(&mut self.process), self.opposite.as_mut()].into_iter().flatten() {
            process.write(self.place.input_at(place), input)?;
            process.write(self.place.skips_at(place), &skip_words)?;
            let skips = skips.len() as u64;
            process.ask(What::Run as u64, [clocks as u64, start, skips, wants_state, 0])?;
        }
        self.under_way.push_back((place, clocks));
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
        let (place, clocks) = self.under_way.pop_front().expect("a block is under way");
        let words = clocks * self.place.output_words;
        assert_eq!(records.got.values.len(), words);
        self.process.answer()?;
        let state = self.place.read(&self.process, place, records)?;
        records.got.undefined.clear();
        records.low.undefined.clear();
        let Some(opposite) = &mut self.opposite else {
            return Ok(());
        };
        opposite.answer()?;
        let mut others = Records::default();
        others.got.values.resize(words, 0);
        let others_state = self.place.read(opposite, place, &mut others)?;
        records.got.mark_undefined(&others.got);
        records.low.mark_undefined(&others.low);
        if state == others_state {
            self.opposite = None;
        }
        Ok(())
    }

    /// Waits for the end of the blocks that are under way, and for nothing of what
    /// they give.
    pub fn discard(&mut self) {
        while self.under_way.pop_front().is_some() {
            let opposite = self.opposite.as_mut().map_or(Ok(()), Process::answer);
            if self.process.answer().and(opposite).is_err() {
                return;
            }
        }
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

/// Where a block lies in the shared file: `Place` of `testbench/cosim.cpp`.
#[derive(Debug, Clone, Copy)]
struct Place {
    input_words: usize,
    output_words: usize,
}

impl Place {
    /// Words before the inputs: whether it was looked at again, and the state.
    const HEAD: u64 = 2;

    fn words(self) -> u64 {
        let records = BLOCK_CLOCKS * (self.input_words + 2 * self.output_words) as u64;
        Place::HEAD + records + (MOST_SKIPS * SKIP_WORDS) as u64
    }

    fn start(self, place: usize) -> u64 {
        place as u64 * self.words()
    }

    fn input_at(self, place: usize) -> u64 {
        self.start(place) + Place::HEAD
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

    /// Reads the outputs of a block; gives the state after it.
    fn read(self, process: &Process, place: usize, records: &mut Records) -> Result<u64, String> {
        let mut head = [0; Place::HEAD as usize];
        process.read(self.start(place), &mut head)?;
        let [looks_again, state] = head;
        let words = records.got.values.len();
        process.read(self.output_at(place), &mut records.got.values)?;
        records.low.values.resize(if looks_again == 0 { 0 } else { words }, 0);
        process.read(self.low_at(place), &mut records.low.values)?;
        Ok(state)
    }
}

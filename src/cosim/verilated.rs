//! A verilated `sensor_top`, clocked in blocks. `testbench/cosim.cpp` is the other
//! side.

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
        Ok(Verilated {
            process: Process::load(built, BLOCKS_AT_ONCE as u64 * place.words())?,
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
        self.process.write(self.place.input_at(place), input)?;
        self.write_skips(first_clock, skips, place)?;
        self.ask(What::Run, clocks as u64, place, skips.len())?;
        self.under_way.push_back((place, clocks));
        Ok(())
    }

    fn write_skips(
        &mut self,
        first_clock: u64,
        skips: &[Skip],
        place: usize,
    ) -> Result<(), String> {
        if skips.is_empty() {
            return Ok(());
        }
        assert!(skips.len() <= MOST_SKIPS);
        let registers = self.registers.as_mut().expect("a model with counters");
        let mut words = Vec::with_capacity(skips.len() * SKIP_WORDS);
        for skip in skips {
            let chips = registers.chips.as_mut();
            let groups = registers.groups.as_mut();
            words.extend([
                skip.clock - first_clock,
                chips.map_or(0, |register| register.difference(skip.chip, skip.chips)),
                groups.map_or(0, |register| register.difference(skip.group.0, skip.groups)),
            ]);
        }
        self.process.write(self.place.skips_at(place), &words)
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
        assert_eq!(records.got.len(), words);
        self.process.answer()?;
        let mut looks_again = [0];
        self.process.read(self.place.start(place), &mut looks_again)?;
        self.process.read(self.place.output_at(place), &mut records.got)?;
        records.low.resize(if looks_again == [0] { 0 } else { words }, 0);
        self.process.read(self.place.low_at(place), &mut records.low)
    }

    /// Waits for the end of the blocks that are under way, and for nothing of what
    /// they give.
    pub fn discard(&mut self) {
        while self.under_way.pop_front().is_some() && self.process.answer().is_ok() {}
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
        self.ask(What::RunBare, clocks, 0, 0)?;
        self.process.answer()
    }

    /// Runs the final blocks. The last that may be asked for.
    ///
    /// # Errors
    /// The reason when one of them ends the simulation with more than `$finish`,
    /// which a final block may call.
    pub fn finish(&mut self) -> Result<(), String> {
        let asked = self.ask(What::Finish, 0, 0, 0);
        match asked.and_then(|()| self.process.answer()) {
            Err(reason) if !reason.starts_with("$finish") => Err(reason),
            _ => Ok(()),
        }
    }

    fn ask(&mut self, what: What, clocks: u64, place: usize, skips: usize) -> Result<(), String> {
        self.process.ask(what as u64, [clocks, self.place.start(place), skips as u64, 0, 0])
    }
}

/// Where a block lies in the shared file: `Place` of `testbench/cosim.cpp`.
#[derive(Debug, Clone, Copy)]
struct Place {
    input_words: usize,
    output_words: usize,
}

impl Place {
    /// Words before the inputs.
    const HEAD: u64 = 1;

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
}

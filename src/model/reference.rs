//! Predicts every output port of `sensor_top` at every clock.
//!
//! The work follows events, not clocks: chips are copied period by period from
//! the code table, counts change only where there is a hit, and the result
//! stream only where a result arrives or is taken.

use std::ops::Range;

use super::contract::Contract;
use super::layout::Layout;
use super::pattern::{ChipPattern, chip_patterns};
use super::stream::{Arrival, ResultStream};

/// What the surroundings do to the hardware in a block of clocks, besides the
/// detectors' levels.
#[derive(Debug, Clone, Default)]
pub struct Surroundings {
    /// The block's clocks.
    pub clocks: Range<u64>,
    /// Clocks at which `i_rst` is high, in order; may reach beyond the block.
    pub resets: Vec<Range<u64>>,
    /// Clocks at which `m_axis_tready` is low, in order, disjoint; may reach
    /// beyond the block.
    pub stalls: Vec<Range<u64>>,
}

/// A phase step whose integration is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepResult {
    /// Number of the scan since the last reset.
    pub scan: u64,
    /// Number of the step within the scan, 0..steps.
    pub step: u64,
    /// The count, saturated as the hardware does.
    pub count: i64,
}

/// Why a contract cannot be predicted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// More than one detector.
    #[error(
        "the scene has {0} detectors; the reference model predicts the ports of a sensor with one \
         detector: keep one [[detector]]"
    )]
    Detectors(usize),
    /// More than one phase step at a time.
    #[error(
        "hardware.parallel is {0}; the reference model predicts one phase step at a time: set it \
         to 1"
    )]
    Parallel(u32),
}

/// The reference model. One per run; it starts in reset.
#[derive(Debug, Clone)]
pub struct Reference {
    contract: Contract,
    /// chi of the reference's chips (eq. 10).
    signs: Vec<i8>,
    chips: Vec<ChipPattern>,
    words: usize,
    stream: ResultStream,
    /// First clock without reset; before it every output is 0.
    released: u64,
    scan: ScanState,
    finished: Vec<StepResult>,
}

/// Where the scan stands, in cycles since reset.
#[derive(Debug, Clone, Copy, Default)]
struct ScanState {
    scan: u64,
    step: u64,
    /// First cycle of the step.
    from: u64,
    count: i64,
}

impl Reference {
    /// A model of the hardware with this contract.
    ///
    /// # Errors
    /// When the contract asks for hardware that is not modelled.
    pub fn new(contract: Contract) -> Result<Reference, ReferenceError> {
        if contract.reference_codes.len() != 1 {
            return Err(ReferenceError::Detectors(contract.reference_codes.len()));
        }
        if contract.parallel != 1 {
            return Err(ReferenceError::Parallel(contract.parallel));
        }
        let layout = Layout::of(&contract);
        let place = |name| {
            let field = layout.outputs.field(name);
            (field.word, field.shift)
        };
        Ok(Reference {
            signs: contract.reference_codes[0]
                .chips
                .iter()
                .map(|&chip| 2 * chip as i8 - 1)
                .collect(),
            chips: chip_patterns(&contract, place("o_laser"), place("o_epoch")),
            words: layout.outputs.words,
            stream: ResultStream::new(&contract, &layout),
            released: 0,
            scan: ScanState::default(),
            finished: Vec::new(),
            contract,
        })
    }

    /// Words per clock of the expected outputs.
    pub fn words(&self) -> usize {
        self.words
    }

    /// Results of the steps that ended in the blocks predicted so far, in order,
    /// whether or not the stream had room for them. Empties the list.
    pub fn take_finished(&mut self) -> std::vec::Drain<'_, StepResult> {
        self.finished.drain(..)
    }

    /// Predicts a block. Blocks follow one another without a gap.
    ///
    /// `hits` are the first samples of the runs of high samples that start in
    /// the block, in order, numbered as in [`super::level::Level::paint`].
    /// `expected` has `words()` entries per clock and is overwritten.
    pub fn predict(&mut self, block: &Surroundings, hits: &[u64], expected: &mut [u64]) {
        expected.fill(0);
        let lanes = u64::from(self.contract.lanes);
        let mut clock = block.clocks.start;
        let mut resets = block.resets.iter().peekable();
        while resets.next_if(|r| r.end <= clock).is_some() {}
        while clock < block.clocks.end {
            if let Some(reset) = resets.next_if(|r| r.start <= clock) {
                self.reset(reset.end);
            }
            if clock < self.released {
                clock = self.released.min(block.clocks.end);
                continue;
            }
            let until = resets
                .peek()
                .map_or(block.clocks.end, |r| r.start.min(block.clocks.end));
            let from = hits.partition_point(|&s| s < clock * lanes);
            let to = hits.partition_point(|&s| s < until * lanes);
            self.predict_released(clock..until, block, &hits[from..to], expected);
            clock = until;
        }
    }

    fn reset(&mut self, released: u64) {
        self.released = released;
        self.scan = ScanState::default();
        self.stream.reset();
    }

    /// A stretch of clocks without reset.
    fn predict_released(
        &mut self,
        clocks: Range<u64>,
        block: &Surroundings,
        hits: &[u64],
        expected: &mut [u64],
    ) {
        let at = (clocks.start - block.clocks.start) as usize * self.words;
        let expected = &mut expected[at..at + (clocks.end - clocks.start) as usize * self.words];
        for pattern in &self.chips {
            pattern.or_into(expected, self.words, clocks.start - self.released);
        }
        self.count(hits);
        self.finish_steps(|last_word| last_word < clocks.end);
        self.stream.predict(clocks, &block.stalls, expected);
    }

    /// Counts hits up or down (eq. 11). The word of cycle n is presented one
    /// clock after the chip of cycle n shows on `o_laser`.
    fn count(&mut self, hits: &[u64]) {
        let lanes = u64::from(self.contract.lanes);
        let period = self.signs.len() as u64;
        let steps_per_period = period * lanes;
        for &sample in hits {
            let Some(cycle) = (sample / lanes).checked_sub(self.released + 1) else {
                continue;
            };
            self.finish_steps_before(cycle);
            if cycle < self.scan.from {
                continue;
            }
            let step = self.contract.scan.step(self.scan.step);
            let in_period = (cycle % period) * lanes + sample % lanes;
            let delayed = (in_period + steps_per_period - step) % steps_per_period;
            self.scan.count += i64::from(self.signs[(delayed / lanes) as usize]);
        }
    }

    fn finish_steps_before(&mut self, cycle: u64) {
        let released = self.released;
        self.finish_steps(|last_word| last_word < released + 1 + cycle);
    }

    /// Ends every step whose last word is presented at a clock that `over`
    /// accepts.
    fn finish_steps(&mut self, over: impl Fn(u64) -> bool) {
        let dwell = self.contract.scan.integration_chips;
        while over(self.released + self.scan.from + dwell) {
            let end = self.scan.from + dwell;
            let last = self.scan.step + 1 == self.contract.scan.steps;
            let limit = 1i128 << (self.contract.count_bits - 1);
            let exact = i128::from(self.scan.count);
            let count = exact.clamp(-limit, limit - 1);
            self.stream.push(Arrival {
                clock: self.released + end + u64::from(self.contract.result_latency_clocks),
                count: count as i64,
                saturated: count != exact,
                last,
            });
            self.finished.push(StepResult {
                scan: self.scan.scan,
                step: self.scan.step,
                count: count as i64,
            });
            self.scan = if last {
                ScanState {
                    scan: self.scan.scan + 1,
                    step: 0,
                    from: self.next_scan(end),
                    count: 0,
                }
            } else {
                ScanState {
                    step: self.scan.step + 1,
                    from: end,
                    count: 0,
                    ..self.scan
                }
            };
        }
    }

    /// First cycle of the scan that follows one which ended before cycle `end`.
    fn next_scan(&self, end: u64) -> u64 {
        if self.contract.realigns() {
            end.next_multiple_of(self.signs.len() as u64)
        } else {
            end
        }
    }
}

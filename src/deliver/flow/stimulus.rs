//! A recorded run: hostile inputs and what the reference model makes of them.

use std::ops::Range;

use super::run_length::Runs;
use crate::reference::adversarial::Adversarial;
use crate::reference::blocks::{Block, BlockMaker};
use crate::reference::predictor::{Reference, ReferenceError, StepResult, Surroundings};
use crate::reference::stimulus::{Drive, Stimulus};
use crate::sensor::contract::{Contract, Port};
use crate::sensor::layout::{Field, Layout};

/// Clocks before the first reset of a run that cannot be whole.
const CALM_CLOCKS: u64 = 40_000;
/// The same at most: an interpreting simulator takes seconds.
const MOST_CALM_CLOCKS: u64 = 65_536;
/// Phase steps that should end before the first reset.
const CALM_STEPS: u64 = 3;
/// Resets after that, each in the middle of a scan.
const RESETS: u64 = 8;
/// Clocks from one to the next where a phase step takes longer.
const RESET_SPACING_CLOCKS: u64 = 1_000;
/// Clocks of a phase step that can end between two resets.
const SHORT_STEP_CLOCKS: u64 = 3_000;
/// Clocks of a phase step that can end after the last reset.
const MOST_STEP_CLOCKS: u64 = 16_000;
/// Seed of the adversary.
const SEED: u64 = 1;

/// Ports that share a vector file, from bit 0 up.
#[derive(Debug, Clone)]
pub struct Group {
    /// The ports.
    pub ports: Vec<Port>,
    /// Their values, clock by clock.
    pub runs: Runs,
    /// Where they lie in a record, in the same order.
    fields: Vec<Field>,
    /// The value being put together.
    packed: Vec<u64>,
}

impl Group {
    fn new(fields: Vec<Field>) -> Group {
        let ports: Vec<Port> = fields.iter().map(|field| field.port.clone()).collect();
        let bits: u32 = ports.iter().map(|port| port.width).sum();
        Group {
            ports,
            runs: Runs::default(),
            fields,
            packed: vec![0; bits.div_ceil(64) as usize],
        }
    }

    /// Bits of all ports.
    pub fn bits(&self) -> u32 {
        self.ports.iter().map(|port| port.width).sum()
    }

    fn push_zero(&mut self) {
        self.packed.fill(0);
        self.runs.push(&self.packed);
    }

    fn push(&mut self, words: &[u64]) {
        self.packed.fill(0);
        let mut at = 0;
        for field in &self.fields {
            if field.port.width <= 64 {
                put(&mut self.packed, at, &[field.low_word(words)]);
            } else {
                put(&mut self.packed, at, &field.read(words));
            }
            at += field.port.width;
        }
        self.runs.push(&self.packed);
    }
}

/// ORs `value`, whose bits beyond its width are 0, into `packed` at bit `at`.
fn put(packed: &mut [u64], at: u32, value: &[u64]) {
    let (word, shift) = (at as usize / 64, at % 64);
    for (i, part) in value.iter().enumerate() {
        packed[word + i] |= part << shift;
        if shift > 0 && part >> (64 - shift) != 0 {
            packed[word + i + 1] |= part >> (64 - shift);
        }
    }
}

/// Inputs and expected outputs of a bench.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Every input but the clock.
    pub inputs: Group,
    /// Lasers and epoch, which change from chip to chip. As every output: what
    /// stands there before the first clock, then after each.
    pub chips: Group,
    /// The other outputs, which change from phase step to phase step.
    pub results: Group,
    /// Clocks of the run.
    pub clocks: u64,
    /// Times that it enters reset.
    pub resets: u64,
    /// Phase steps whose integration ends in it.
    pub phase_steps: u64,
    /// Scans whose last phase step ends in it.
    pub scans: u64,
    /// Hits that the results on the stream count up.
    pub hits_up: u64,
    /// Hits that they count down.
    pub hits_down: u64,
}

/// Records a run that begins in reset.
///
/// # Errors
/// When the reference model cannot predict the ports.
pub fn record(contract: &Contract) -> Result<Recording, ReferenceError> {
    let layout = Layout::of(contract);
    let (chips, results) = layout
        .outputs
        .fields
        .iter()
        .cloned()
        .partition(|field| matches!(field.port.name.as_str(), "o_laser" | "o_epoch"));
    let run = Run::of(contract);
    let mut recording = Recording {
        inputs: Group::new(layout.inputs.fields.clone()),
        chips: Group::new(chips),
        results: Group::new(results),
        clocks: run.clocks,
        resets: 0,
        phase_steps: 0,
        scans: 0,
        hits_up: 0,
        hits_down: 0,
    };
    recording.chips.push_zero();
    recording.results.push_zero();
    let (inputs, outputs) = (&layout.inputs, &layout.outputs);
    let reset = inputs.field("i_rst");
    let mut in_reset = false;
    run.each_block(contract, &layout, |block, finished| {
        for words in block.records.inputs.chunks_exact(inputs.words) {
            recording.inputs.push(words);
            let was_in_reset = std::mem::replace(&mut in_reset, reset.low_word(words) == 1);
            recording.resets += u64::from(in_reset && !was_in_reset);
        }
        for words in block.records.expected.chunks_exact(outputs.words) {
            recording.chips.push(words);
            recording.results.push(words);
        }
        let detectors = &block.exercise.detectors;
        recording.hits_up = detectors.iter().map(|d| d.hits_up).sum();
        recording.hits_down = detectors.iter().map(|d| d.hits_down).sum();
        for result in finished {
            recording.phase_steps += 1;
            recording.scans += u64::from(result.step + 1 == contract.timing.scan.steps);
        }
    })?;
    Ok(recording)
}

/// How long to run, and where to reset besides.
#[derive(Debug, Clone)]
struct Run {
    clocks: u64,
    resets: Vec<Range<u64>>,
    /// Clocks at which the receiver stalls, long enough to lose a result.
    stall: Range<u64>,
}

impl Run {
    /// All that the adversary has where scans are short; otherwise as many
    /// phase steps as the limits leave, then resets, then one more step.
    fn of(contract: &Contract) -> Run {
        let whole = Adversarial::default_clocks(contract);
        if whole <= CALM_CLOCKS {
            return Run {
                clocks: whole,
                resets: Vec::new(),
                stall: losing_stall(contract, whole / 2),
            };
        }
        let margin = 2 * u64::from(contract.result_latency_clocks) + 100;
        let steps = |number: u64| {
            let clocks = contract
                .timing
                .scan
                .integration_chips
                .saturating_mul(number);
            clocks.saturating_add(margin)
        };
        let calm = steps(CALM_STEPS).clamp(CALM_CLOCKS, MOST_CALM_CLOCKS);
        let spacing = if steps(1) <= SHORT_STEP_CLOCKS {
            steps(1).max(RESET_SPACING_CLOCKS)
        } else {
            RESET_SPACING_CLOCKS
        };
        let last = calm + (RESETS - 1) * spacing;
        let tail = steps(1).clamp(spacing, MOST_STEP_CLOCKS);
        Run {
            clocks: last + tail,
            stall: losing_stall(contract, calm),
            // Of several lengths, down to a single clock.
            resets: (calm..=last)
                .step_by(spacing as usize)
                .zip((1..=4).cycle())
                .map(|(at, length)| at..at + length)
                .collect(),
        }
    }

    /// Runs the reference model under hostile inputs.
    fn each_block(
        &self,
        contract: &Contract,
        layout: &Layout,
        mut each: impl FnMut(&Block, &[StepResult]),
    ) -> Result<(), ReferenceError> {
        let mut reference = Reference::new(contract.clone())?;
        let mut stimulus = WithResets {
            adversary: Adversarial::new(contract, SEED),
            resets: &self.resets,
            stall: &self.stall,
        };
        let mut maker = BlockMaker::new(&mut reference, &mut stimulus, layout, self.clocks);
        let mut block = Block::default();
        while maker.make(&mut block) {
            let finished: Vec<StepResult> = maker.take_finished().collect();
            each(&block, &finished);
        }
        Ok(())
    }
}

/// A stall at the end of the `calm` clocks in which at least two results arrive,
/// the second of which is lost: two steps, and what a scan may wait for its
/// code's first chip.
fn losing_stall(contract: &Contract, calm: u64) -> Range<u64> {
    let step = contract.timing.scan.integration_chips;
    let wait = contract.timing.longest_gap_chips();
    calm.saturating_sub(step.saturating_add(wait).saturating_mul(2))..calm
}

/// The adversary with more resets than its own, and a stall.
struct WithResets<'a> {
    adversary: Adversarial,
    resets: &'a [Range<u64>],
    stall: &'a Range<u64>,
}

impl Stimulus for WithResets<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        self.adversary.drive(drive);
        let Surroundings {
            clocks,
            resets,
            stalls,
        } = &mut drive.surroundings;
        let in_block = |range: &&Range<u64>| range.end > clocks.start && range.start < clocks.end;
        resets.extend(self.resets.iter().filter(in_block).cloned());
        merge(resets);
        stalls.extend(std::iter::once(self.stall).filter(in_block).cloned());
        merge(stalls);
    }
}

/// Orders ranges by their start and joins those that touch.
fn merge(ranges: &mut Vec<Range<u64>>) {
    ranges.sort_by_key(|range| range.start);
    ranges.dedup_by(|later, earlier| {
        let joined = later.start <= earlier.end;
        if joined {
            earlier.end = earlier.end.max(later.end);
        }
        joined
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resets_that_touch_are_one() {
        let mut ranges = vec![5..9, 20..21, 9..10, 1..2, 6..7];
        merge(&mut ranges);
        assert_eq!(ranges, [1..2, 5..10, 20..21]);
    }

    #[test]
    fn values_are_packed_across_words() {
        let mut packed = [0; 3];
        put(&mut packed, 0, &[0x1]);
        put(&mut packed, 1, &[u64::MAX, 0x3]);
        put(&mut packed, 67, &[u64::MAX >> 3]);
        assert_eq!(packed, [u64::MAX, u64::MAX, 0]);
        put(&mut packed, 128, &[0x5]);
        assert_eq!(packed[2], 0x5);
    }
}

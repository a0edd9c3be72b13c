//! Recorded runs: hostile inputs and what the reference model makes of them.

use super::run_length::Runs;
use crate::cosim::adversarial::Adversarial;
use crate::cosim::blocks::{Block, BlockMaker};
use crate::cosim::stimulus::clocks_for_scans;
use crate::model::contract::{Contract, Port};
use crate::model::layout::{Layout, Record};
use crate::model::reference::{Reference, ReferenceError};

/// Clocks of the long run, where a phase step does not need more.
const LONG_RUN_CLOCKS: u64 = 40_000;
/// Clocks of the long run at most: an interpreting simulator takes seconds.
const MOST_LONG_RUN_CLOCKS: u64 = 65_536;
/// Phase steps that the long run should see the end of.
const LONG_RUN_STEPS: u64 = 3;
/// Short runs after it: other inputs, and a reset in the middle of a scan each.
const SHORT_RUNS: u64 = 8;
/// Clocks of a short run.
const SHORT_RUN_CLOCKS: u64 = 1_000;
/// Seed of the first run; the others count up from it. Any number.
const FIRST_SEED: u64 = 1;

/// Ports that share a vector file, from bit 0 up.
#[derive(Debug, Clone)]
pub struct Group {
    /// The ports.
    pub ports: Vec<Port>,
    /// Their values, clock by clock.
    pub runs: Runs,
}

impl Group {
    fn new(ports: Vec<Port>) -> Group {
        Group {
            ports,
            runs: Runs::default(),
        }
    }

    /// Bits of all ports.
    pub fn bits(&self) -> u32 {
        self.ports.iter().map(|port| port.width).sum()
    }

    fn push_zero(&mut self) {
        self.runs.push(&vec![0; self.words()]);
    }

    fn words(&self) -> usize {
        self.bits().div_ceil(64) as usize
    }

    fn push(&mut self, record: &Record, words: &[u64]) {
        let mut packed = vec![0; self.words()];
        let mut at = 0;
        for port in &self.ports {
            let value = record.field(&port.name).read(words);
            put(&mut packed, at, &value);
            at += port.width;
        }
        self.runs.push(&packed);
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
    /// Clocks of each run; each starts in reset.
    pub run_clocks: Vec<u64>,
    /// Phase steps whose integration ends in a run.
    pub phase_steps: u64,
    /// Scans whose last phase step ends in a run.
    pub scans: u64,
}

/// Records a long run and several short ones.
///
/// # Errors
/// When the reference model cannot predict the ports.
pub fn record(contract: &Contract) -> Result<Recording, ReferenceError> {
    let layout = Layout::of(contract);
    let ports_of =
        |record: &Record| -> Vec<Port> { record.fields.iter().map(|f| f.port.clone()).collect() };
    let (chips, results) = ports_of(&layout.outputs)
        .into_iter()
        .partition(|port| matches!(port.name.as_str(), "o_laser" | "o_epoch"));
    let mut recording = Recording {
        inputs: Group::new(ports_of(&layout.inputs)),
        chips: Group::new(chips),
        results: Group::new(results),
        run_clocks: vec![long_run_clocks(contract)],
        phase_steps: 0,
        scans: 0,
    };
    for outputs in [&mut recording.chips, &mut recording.results] {
        outputs.push_zero();
    }
    recording
        .run_clocks
        .extend((0..SHORT_RUNS).map(|_| SHORT_RUN_CLOCKS));
    for (seed, clocks) in (FIRST_SEED..).zip(recording.run_clocks.clone()) {
        recording.run(contract, &layout, seed, clocks)?;
    }
    Ok(recording)
}

/// Two scans and their like with resets where they are short; otherwise as
/// many phase steps as the limits leave.
fn long_run_clocks(contract: &Contract) -> u64 {
    let hostile = Adversarial::default_clocks(contract);
    if hostile <= LONG_RUN_CLOCKS {
        return hostile;
    }
    let step_clocks = contract.scan.integration_chips;
    let margin = 2 * u64::from(contract.result_latency_clocks) + 100;
    let steps = step_clocks
        .saturating_mul(LONG_RUN_STEPS)
        .saturating_add(margin)
        .clamp(LONG_RUN_CLOCKS, MOST_LONG_RUN_CLOCKS);
    steps.min(clocks_for_scans(contract, 2))
}

impl Recording {
    /// Clocks of all runs.
    pub fn clocks(&self) -> u64 {
        self.run_clocks.iter().sum()
    }

    fn run(
        &mut self,
        contract: &Contract,
        layout: &Layout,
        seed: u64,
        clocks: u64,
    ) -> Result<(), ReferenceError> {
        let mut reference = Reference::new(contract.clone())?;
        let mut adversary = Adversarial::new(contract, seed);
        let mut maker = BlockMaker::new(
            &mut reference,
            &mut adversary,
            layout,
            contract.lanes,
            clocks,
        );
        let mut block = Block::default();
        let (inputs, outputs) = (&layout.inputs, &layout.outputs);
        while maker.make(&mut block) {
            for words in block.records.inputs.chunks_exact(inputs.words) {
                self.inputs.push(inputs, words);
            }
            for words in block.records.expected.chunks_exact(outputs.words) {
                self.chips.push(outputs, words);
                self.results.push(outputs, words);
            }
            for result in maker.take_finished() {
                self.phase_steps += 1;
                self.scans += u64::from(result.step + 1 == contract.scan.steps);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

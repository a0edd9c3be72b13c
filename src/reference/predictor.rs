//! Predicts every output port of `sensor_top` at every clock.
//!
//! The work follows events, not clocks: chips are copied period by period from
//! the code table, counts change only where there is a hit, and the result
//! stream only where a result arrives or is taken.

use std::ops::Range;

use super::exercise::{Counted, Exercise};
use super::pattern::{ChipPattern, chip_patterns};
use super::peak_ports::PeakPorts;
use super::stream::{Arrival, Beat, ResultStream};
use crate::scan::Group;
use crate::sensor::contract::Contract;
use crate::sensor::layout::{Layout, mask};

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
    /// The detector.
    pub detector: usize,
    /// Number of the step within the scan, 0..steps.
    pub step: u64,
    /// The count, saturated as the hardware does.
    pub count: i64,
    /// The hits that were counted, up and down together; saturated as the hardware
    /// does where it sends them.
    pub total: u64,
}

/// Why a contract cannot be predicted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// References of different length.
    #[error(
        "the detectors' reference codes have {0:?} chips per period; one scan walks all of them, \
         so they need one length"
    )]
    CodeLengths(Vec<u64>),
}

/// The reference model. One per run; it starts in reset.
#[derive(Debug, Clone)]
pub struct Reference {
    contract: Contract,
    /// chi of the chips of each detector's reference (eq. 10).
    signs: Vec<Vec<i8>>,
    chips: Vec<ChipPattern>,
    words: usize,
    stream: ResultStream,
    peak: Option<PeakPorts>,
    /// First clock without reset; before it every output is 0.
    released: u64,
    scan: ScanState,
    /// Counts of the present group: detector by detector, step by step.
    counts: Vec<i64>,
    /// Hits of the present group, detector by detector: all steps see the same.
    totals: Vec<u64>,
    finished: Vec<StepResult>,
}

/// Where the scan stands, in cycles since reset.
#[derive(Debug, Clone, Copy)]
struct ScanState {
    scan: u64,
    group: Group,
    /// First cycle of the group of steps.
    from: u64,
}

impl ScanState {
    const START: ScanState = ScanState {
        scan: 0,
        group: Group(0),
        from: 0,
    };
}

impl Reference {
    /// A model of the hardware with this contract.
    ///
    /// # Errors
    /// When the contract asks for hardware that is not modelled.
    pub fn new(contract: Contract) -> Result<Reference, ReferenceError> {
        let lengths = contract.reference_codes.iter().map(|code| code.len());
        if lengths
            .clone()
            .any(|length| length != contract.reference_codes[0].len())
        {
            return Err(ReferenceError::CodeLengths(lengths.collect()));
        }
        let layout = Layout::of(&contract);
        let place = |name| {
            let field = layout.outputs.field(name);
            (field.word, field.shift)
        };
        Ok(Reference {
            signs: contract
                .reference_codes
                .iter()
                .map(|code| code.chips.iter().map(|&chip| 2 * chip as i8 - 1).collect())
                .collect(),
            chips: chip_patterns(&contract, place("o_laser"), place("o_epoch")),
            words: layout.outputs.words,
            stream: ResultStream::new(&contract, &layout),
            peak: PeakPorts::new(&contract, &layout),
            released: 0,
            scan: ScanState::START,
            counts: vec![0; contract.reference_codes.len() * contract.parallel() as usize],
            totals: vec![0; contract.reference_codes.len()],
            finished: Vec::new(),
            contract,
        })
    }

    /// What it predicts.
    pub fn contract(&self) -> &Contract {
        &self.contract
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

    /// What the outputs have shown in the blocks predicted so far.
    pub fn exercise(&self) -> &Exercise {
        &self.stream.exercise
    }

    /// Predicts a block. Blocks follow one another without a gap.
    ///
    /// `hits` are, for each detector, the first samples of the runs of high
    /// samples that start in the block, in order, numbered as in
    /// [`super::level::Level::paint`]. `expected` has `words()` entries per
    /// clock and is overwritten.
    pub fn predict(&mut self, block: &Surroundings, hits: &[Vec<u64>], expected: &mut [u64]) {
        expected.fill(0);
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
            self.predict_released(clock..until, block, hits, expected);
            clock = until;
        }
    }

    fn reset(&mut self, released: u64) {
        // One that reaches into this block was told in the block before, too.
        self.stream.exercise.resets += u64::from(released != self.released);
        self.released = released;
        self.scan = ScanState::START;
        self.counts.fill(0);
        self.totals.fill(0);
        self.stream.reset();
        if let Some(peak) = &mut self.peak {
            peak.reset();
        }
    }

    /// A stretch of clocks without reset.
    fn predict_released(
        &mut self,
        clocks: Range<u64>,
        block: &Surroundings,
        hits: &[Vec<u64>],
        expected: &mut [u64],
    ) {
        let at = (clocks.start - block.clocks.start) as usize * self.words;
        let expected = &mut expected[at..at + (clocks.end - clocks.start) as usize * self.words];
        for pattern in &self.chips {
            pattern.or_into(expected, self.words, clocks.start - self.released);
        }
        self.count(clocks.clone(), hits);
        self.stream.predict(clocks.clone(), &block.stalls, expected);
        if let Some(peak) = &mut self.peak {
            peak.predict(clocks, expected);
        }
    }

    /// Counts the hits of a stretch of clocks, group by group, and ends the
    /// groups whose last word is among them. The word of cycle n is presented
    /// one clock after the chip of cycle n shows on `o_laser`.
    fn count(&mut self, clocks: Range<u64>, hits: &[Vec<u64>]) {
        let lanes = u64::from(self.contract.lanes());
        let first_word = self.released + 1;
        let mut counted = clocks.start.max(first_word);
        loop {
            let group_end =
                first_word + self.scan.from + self.contract.timing.scan.integration_chips;
            let until = group_end.min(clocks.end);
            let from = counted.max(first_word + self.scan.from);
            if from < until {
                for (detector, hits) in hits.iter().enumerate() {
                    let first = hits.partition_point(|&s| s < from * lanes);
                    let end = first + hits[first..].partition_point(|&s| s < until * lanes);
                    self.count_detector(detector, &hits[first..end]);
                }
            }
            if group_end > clocks.end {
                return;
            }
            self.finish_group();
            counted = until;
        }
    }

    /// Counts one detector's hits up or down (eq. 11) in the present group.
    fn count_detector(&mut self, detector: usize, hits: &[u64]) {
        let lanes_log2 = self.contract.lanes().trailing_zeros();
        let signs = &self.signs[detector][..];
        let steps_per_period = (signs.len() as u64) << lanes_log2;
        let parallel = u64::from(self.contract.parallel());
        let first = self.contract.grouping().step_of(self.scan.group, 0);
        let phase_step = self.contract.timing.scan.phase_step(first);
        let first_sample = (self.released + 1) << lanes_log2;
        self.totals[detector] += hits.len() as u64;
        let counts = &mut self.counts[detector * parallel as usize..][..parallel as usize];
        for &sample in hits {
            let in_period = (sample - first_sample) % steps_per_period;
            let mut delayed = in_period + steps_per_period - phase_step;
            if delayed >= steps_per_period {
                delayed -= steps_per_period;
            }
            for count in counts.iter_mut() {
                *count += i64::from(signs[(delayed >> lanes_log2) as usize]);
                delayed = delayed.checked_sub(1).unwrap_or(steps_per_period - 1);
            }
        }
    }

    /// Sends the present group's counts on their way and goes on to the next.
    fn finish_group(&mut self) {
        let scan = &self.contract.timing.scan;
        let parallel = u64::from(self.contract.parallel());
        let end = self.scan.from + scan.integration_chips;
        let grouping = self.contract.grouping();
        let last = grouping.is_last(self.scan.group);
        let limit = 1i128 << (self.contract.count_bits - 1);
        let most = self
            .contract
            .total
            .map_or(u64::MAX, |total| mask(total.bits));
        let mut beats = Vec::with_capacity(self.counts.len());
        let mut saturated = false;
        for (detector, counts) in self.counts.chunks_exact(parallel as usize).enumerate() {
            let total = self.totals[detector].min(most);
            saturated |= total != self.totals[detector];
            for (step, &exact) in grouping.steps_of(self.scan.group).zip(counts) {
                let count = i128::from(exact).clamp(-limit, limit - 1) as i64;
                saturated |= count != exact;
                let counted = Counted::new(detector, exact, self.totals[detector]);
                beats.push(Beat {
                    count,
                    total,
                    counted,
                });
                if let Some(peak) = &mut self.peak {
                    peak.count(detector, scan.phase_step(step), count);
                }
                self.finished.push(StepResult {
                    scan: self.scan.scan,
                    detector,
                    step: step.0,
                    count,
                    total,
                });
            }
        }
        self.stream.exercise.phase_steps += grouping.steps_of(self.scan.group).count() as u64;
        self.stream.push(Arrival {
            clock: self.released + end + u64::from(self.contract.result_latency_clocks),
            beats,
            saturated,
            last,
        });
        if let Some(peak) = self.peak.as_mut().filter(|_| last) {
            peak.end_scan(self.released + end);
        }
        self.counts.fill(0);
        self.totals.fill(0);
        self.scan = if last {
            ScanState {
                scan: self.scan.scan + 1,
                group: Group(0),
                from: self.next_scan(end),
            }
        } else {
            ScanState {
                group: Group(self.scan.group.0 + 1),
                from: end,
                ..self.scan
            }
        };
    }

    /// First cycle of the scan that follows one which ended before cycle `end`.
    fn next_scan(&self, end: u64) -> u64 {
        let next = self.contract.timing.next_scan_after(u128::from(end));
        u64::try_from(next).unwrap_or(u64::MAX)
    }
}

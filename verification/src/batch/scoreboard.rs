//! Stands beside a design in somebody's testbench and compares every port at every clock.

use super::model::{Inputs, Model};
use super::record::{Clocks, RecordReader, TestbenchPort};
use super::{BatchError, held_to};
use crate::cosim::Verdict;
use crate::cosim::comparison::Comparison;
use crate::cosim::exercised::{Exercised, missing};
use crate::cosim::mismatch::{FirstMismatch, MismatchKind};
use crate::sensor::Sensor;

/// How a design is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScoreboardOptions {
    /// Clocks from a group's last word to its first result, if not the emitted design's.
    pub result_latency_clocks: Option<u32>,
    /// Clocks from a scan's last word to its peak. If it is not given, a peak moves by as
    /// much as the results.
    pub peak_latency_clocks: Option<u32>,
    /// What `m_axis_tdata` and `m_axis_tlast` hold while `m_axis_tvalid` is low is the
    /// design's own business, as the interface has it.
    pub is_idle_payload_free: bool,
    /// Clocks that are compared at once, at least 1: a difference is told when the last
    /// of them has come.
    pub batch_clocks: u32,
}

impl Default for ScoreboardOptions {
    fn default() -> ScoreboardOptions {
        ScoreboardOptions {
            result_latency_clocks: None,
            peak_latency_clocks: None,
            is_idle_payload_free: true,
            batch_clocks: 4096,
        }
    }
}

/// Compares what a design shows with what the reference model expects. Comparison begins
/// with the first clock at which `i_rst` is high.
#[derive(Debug, Clone)]
pub struct Scoreboard {
    sensor: Sensor,
    model: Model,
    reader: RecordReader,
    options: ScoreboardOptions,
    /// Words of a clock that has not come whole.
    partial: Vec<u64>,
    pending: Clocks,
    expected: Vec<u64>,
    compared: u64,
    mismatches: u64,
    first: Option<FirstMismatch>,
}

/// What a comparison has found so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// What it says of the design.
    pub verdict: Verdict,
    /// Clocks compared.
    pub clocks: u64,
    /// Of these, clocks at which a port differed.
    pub mismatches: u64,
    /// The first of them.
    pub first_mismatch: Option<FirstMismatch>,
    /// What the outputs have shown: a match says no more than that.
    pub exercised: Exercised,
    /// Why equal outputs say nothing of the sensor, with an inconclusive verdict.
    pub missing: Vec<String>,
    /// What else was not exercised.
    pub not_exercised: Vec<&'static str>,
}

impl Scoreboard {
    /// A scoreboard for a testbench whose records have these ports, in this order.
    ///
    /// # Errors
    /// When the ports are not the sensor's, or no design is held to such a latency.
    pub fn new(
        sensor: &Sensor,
        ports: &[TestbenchPort],
        options: ScoreboardOptions,
    ) -> Result<Scoreboard, BatchError> {
        let sensor = held_to(sensor, options.result_latency_clocks, options.peak_latency_clocks)?;
        let model = Model::new(&sensor)?;
        Ok(Scoreboard {
            reader: RecordReader::new(&sensor, model.layout(), ports)?,
            model,
            sensor,
            options,
            partial: Vec::new(),
            pending: Clocks::default(),
            expected: Vec::new(),
            compared: 0,
            mismatches: 0,
            first: None,
        })
    }

    /// Words of a clock's record.
    pub fn words(&self) -> usize {
        self.reader.words
    }

    /// Takes the words of records, as many as there are, and compares when enough clocks
    /// have come together.
    pub fn push(&mut self, words: &[u64]) {
        let mut words = words;
        let of_clock = self.reader.words;
        if !self.partial.is_empty() {
            let lacking = (of_clock - self.partial.len()).min(words.len());
            self.partial.extend_from_slice(&words[..lacking]);
            words = &words[lacking..];
            if self.partial.len() < of_clock {
                return;
            }
            let record = std::mem::take(&mut self.partial);
            self.take(&record);
            self.partial = record;
            self.partial.clear();
        }
        let records = words.chunks_exact(of_clock);
        self.partial.extend_from_slice(records.remainder());
        for record in records {
            self.take(record);
        }
    }

    #[inline]
    fn take(&mut self, record: &[u64]) {
        self.reader.read(record, &mut self.pending);
        if self.pending.reset.len() as u64 >= u64::from(self.options.batch_clocks) {
            self.compare();
        }
    }

    /// Compares the clocks that have come and were not compared.
    pub fn compare(&mut self) {
        let first_clock = self.model.clocks();
        let inputs = Inputs {
            samples: &self.pending.samples,
            reset: &self.pending.reset,
            ready: &self.pending.ready,
        };
        let clocked = self.model.clock(&inputs, &mut self.expected);
        debug_assert_eq!(clocked, Ok(()), "the reader cuts words to a chip's samples");
        // Before the first reset a design may show anything.
        let from = match self.model.first_reset() {
            Some(reset) => reset.saturating_sub(first_clock) as usize,
            None => self.pending.reset.len(),
        };
        let words = self.model.layout().outputs.words;
        let from = from.min(self.pending.reset.len());
        self.compared += (self.pending.reset.len() - from) as u64;
        if self.expected[from * words..] != self.pending.got[from * words..] {
            self.find(first_clock, from);
        }
        self.pending.clear();
    }

    fn find(&mut self, first_clock: u64, from: usize) {
        let layout = self.model.layout();
        let comparison =
            Comparison { layout, ignores_idle_payload: self.options.is_idle_payload_free };
        let words = layout.outputs.words;
        let clocks = self.expected.chunks_exact(words);
        let clocks = clocks.zip(self.pending.got.chunks_exact(words));
        for (at, (expected, got)) in clocks.enumerate().skip(from) {
            let clock = first_clock + at as u64;
            let kind = MismatchKind::Value;
            let Some(mismatch) = comparison.mismatch(clock, kind, expected, (got, &[])) else {
                continue;
            };
            self.mismatches += 1;
            let field = &layout.outputs.fields[mismatch.field];
            self.first.get_or_insert_with(|| FirstMismatch::new(&self.sensor, field, &mismatch));
        }
    }

    /// The first difference in the clocks compared.
    pub fn first_mismatch(&self) -> Option<&FirstMismatch> {
        self.first.as_ref()
    }

    /// What all clocks that have come say.
    pub fn summary(&mut self) -> Summary {
        self.compare();
        let interface = self.sensor.interface();
        let detectors = self.sensor.scene().detectors.iter();
        let names = detectors.map(|detector| detector.name.as_str());
        let exercised = self.model.exercise().clone().named(names);
        let missing = match &self.first {
            Some(_) => Vec::new(),
            None if self.model.first_reset().is_none() => {
                vec!["i_rst was never high, and before that the outputs mean nothing".to_owned()]
            }
            None => missing(&exercised, interface, None),
        };
        Summary {
            verdict: match &self.first {
                Some(_) => Verdict::Mismatch,
                None if missing.is_empty() => Verdict::Match,
                None => Verdict::Inconclusive,
            },
            clocks: self.compared,
            mismatches: self.mismatches,
            first_mismatch: self.first.clone(),
            not_exercised: exercised.not_reached(interface),
            exercised,
            missing,
        }
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} clocks compared", self.verdict, self.clocks)?;
        if let Some(first) = &self.first_mismatch {
            return write!(
                f,
                ", {} differ\nclock {} ({:.3} ns): {}",
                self.mismatches,
                first.clock,
                first.time_ps * 1e-3,
                first.text()
            );
        }
        for missing in &self.missing {
            write!(f, "\nmissing: {missing}")?;
        }
        write!(f, "\nexercised: {}", self.exercised.text())?;
        match self.not_exercised.is_empty() {
            true => Ok(()),
            false => write!(f, "\nnot exercised: {}", self.not_exercised.join(", ")),
        }
    }
}

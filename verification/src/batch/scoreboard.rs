//! Stands beside a design in somebody's testbench and compares every port at every clock.

use super::model::{BatchInputs, Model};
use super::record::{Clocks, RecordReader, TestbenchPort};
use super::{BatchError, held_to};
use crate::cosim::Verdict;
use crate::cosim::asked_latency::MOST_CLOCKS;
use crate::cosim::comparison::OutputComparison;
use crate::cosim::exercised::{Exercised, missing};
use crate::cosim::latency::HeldLatency;
use crate::cosim::mismatch::{FirstMismatch, MismatchKind};
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// How a design is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScoreboardOptions {
    /// Clocks from a group's last word to its first result, if not the emitted design's.
    pub result_latency_clocks: Option<u32>,
    /// Clocks from a scan's last word to its peak. If it is not given, a peak moves by as
    /// much as the results.
    pub peak_latency_clocks: Option<u32>,
    /// The latency is the design's own: its first result tells it, in place of
    /// `result_latency_clocks`. Clocks until then are kept and compared afterwards.
    pub finds_latency: bool,
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
            finds_latency: false,
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
    /// While the design's latency is not known.
    search: Option<Search>,
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
    /// The latency that the design was held to, where it is not the emitted design's.
    pub latency: Option<HeldLatency>,
}

/// Most clocks that are kept until a first result.
const MOST_KEPT_CLOCKS: usize = 1 << 22;

/// Clocks that were kept, and when results begin behind the last reset.
#[derive(Debug, Clone, Default)]
struct Search {
    kept: Clocks,
    expected_at: Option<u64>,
    got_at: Option<u64>,
}

impl Search {
    /// Looks for the first result in clocks that have come, of which the first is `from`; `layout` is
    /// that of the outputs.
    fn look(&mut self, from: u64, clocks: &Clocks, expected: &[u64], layout: &Layout) {
        let words = layout.outputs.words;
        let valid = layout.outputs.field(PortRole::Valid);
        let shown = expected.chunks_exact(words).zip(clocks.got.chunks_exact(words));
        for (clock, (reset, (expected, got))) in (from..).zip(clocks.reset.iter().zip(shown)) {
            if self.late().is_some() {
                return;
            }
            if *reset != 0 {
                (self.expected_at, self.got_at) = (None, None);
            }
            for (at, outputs) in [(&mut self.expected_at, expected), (&mut self.got_at, got)] {
                if at.is_none() && *reset == 0 && valid.low_word(outputs) != 0 {
                    *at = Some(clock);
                }
            }
        }
    }

    /// How many clocks later than expected the design's results come, once both are known.
    fn late(&self) -> Option<i64> {
        Some(self.got_at? as i64 - self.expected_at? as i64)
    }

    /// Whether more clocks would tell no more.
    fn is_in_vain(&self, clocks: u64) -> bool {
        let waited = self.expected_at.or(self.got_at).map(|at| clocks - at);
        let too_late = waited.is_some_and(|waited| waited > u64::from(MOST_CLOCKS));
        too_late || self.kept.reset.len() >= MOST_KEPT_CLOCKS
    }
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
            search: options.finds_latency.then(Search::default),
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

    /// Compares the clocks that have come and were not compared; while the design's latency is not
    /// known, they are kept.
    pub fn compare(&mut self) {
        if self.search.is_none() || self.finds_latency(false) {
            self.compare_pending();
        }
    }

    /// Clocks the emitted design's model beside the design until both have shown a result, or, `at_once`,
    /// no longer. Then what was kept is to be compared with a model of the latency that was found, or, if
    /// none was, of the emitted design.
    fn finds_latency(&mut self, at_once: bool) -> bool {
        let Some(mut search) = self.search.take() else { return true };
        let from = self.model.clocks();
        self.clock_pending();
        search.look(from, &self.pending, &self.expected, self.model.layout());
        search.kept.append(&mut self.pending);
        let late = search.late();
        if late.is_none() && !at_once && !search.is_in_vain(self.model.clocks()) {
            self.search = Some(search);
            return false;
        }
        let emitted = self.sensor.interface().result_latency_clocks;
        let found = i64::from(emitted) + late.unwrap_or(0);
        let found = u32::try_from(found).ok().filter(|found| *found <= MOST_CLOCKS);
        let held = held_to(&self.sensor, found, self.options.peak_latency_clocks);
        // Whatever the emitted design may have, a design may.
        if let Ok((sensor, model)) = held.and_then(|sensor| {
            let model = Model::new(&sensor)?;
            Ok((sensor, model))
        }) {
            (self.sensor, self.model) = (sensor, model);
        }
        self.pending = search.kept;
        true
    }

    /// Clocks the model with the inputs of the clocks that have come.
    fn clock_pending(&mut self) {
        let inputs = BatchInputs {
            samples: &self.pending.samples,
            reset: &self.pending.reset,
            ready: &self.pending.ready,
            host: &self.pending.host,
        };
        let clocked = self.model.clock(&inputs, &mut self.expected);
        debug_assert_eq!(clocked, Ok(()), "the reader cuts words to a chip's samples");
    }

    fn compare_pending(&mut self) {
        let first_clock = self.model.clocks();
        self.clock_pending();
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
            OutputComparison { layout, ignores_idle_payload: self.options.is_idle_payload_free };
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
        self.finds_latency(true);
        self.compare_pending();
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
            latency: HeldLatency::of(&self.sensor),
            not_exercised: exercised.not_reached(interface),
            exercised,
            missing,
        }
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} clocks compared", self.verdict, self.clocks)?;
        if let Some(latency) = &self.latency {
            write!(f, "; {}", latency.text())?;
        }
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::sensor::port::Direction;

    const CLOCKS: u64 = 9_000;

    /// What a design of some latency shows, as a testbench records it: hits in every other word, reset at
    /// the start and once more before the first step has ended, and a receiver that is always ready.
    fn records(sensor: &Sensor, clocks: Option<u32>) -> (Vec<TestbenchPort>, Vec<u64>) {
        let mut model = Model::new(&held_to(sensor, clocks, None).unwrap()).unwrap();
        let samples: Vec<u64> = (0..CLOCKS).map(|clock| (clock % 2) << 4).collect();
        let is_reset = |clock: u64| clock < 2 || clock == 1_700;
        let reset: Vec<u8> = (0..CLOCKS).map(|clock| u8::from(is_reset(clock))).collect();
        let inputs = BatchInputs { samples: &samples, reset: &reset, ready: &[], host: &[] };
        let mut outputs = Vec::new();
        model.clock(&inputs, &mut outputs).unwrap();
        let layout = model.layout();
        let ports: Vec<TestbenchPort> = sensor
            .interface()
            .ports()
            .into_iter()
            .filter(|port| port.role != PortRole::Clock)
            .map(|port| TestbenchPort { name: port.name, width: port.width })
            .collect();
        let mut words = Vec::new();
        for (clock, outputs) in outputs.chunks_exact(layout.outputs.words).enumerate() {
            let (mut record, mut at) = (0_u64, 0);
            for port in sensor.interface().ports().iter().filter(|p| p.role != PortRole::Clock) {
                let value = match (port.direction, port.role) {
                    (Direction::Output, role) => layout.outputs.field(role).low_word(outputs),
                    (_, PortRole::Reset) => u64::from(reset[clock]),
                    (_, PortRole::Ready) => 1,
                    _ => samples[clock],
                };
                record |= value << at;
                at += port.width;
            }
            words.push(record);
        }
        (ports, words)
    }

    fn judged(sensor: &Sensor, ports: &[TestbenchPort], words: &[u64]) -> Summary {
        let options = ScoreboardOptions {
            finds_latency: true,
            batch_clocks: 100,
            ..ScoreboardOptions::default()
        };
        let mut scoreboard = Scoreboard::new(sensor, ports, options).unwrap();
        scoreboard.push(words);
        scoreboard.summary()
    }

    #[test]
    fn a_latency_is_found_of_results_that_come_earlier_or_later_also_after_a_second_reset() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
        let sensor = Sensor::new(&crate::scene::load(&path).unwrap());
        let emitted = sensor.interface().result_latency_clocks;
        for clocks in [0, 2, emitted, emitted + 1, 150, 2_000] {
            let (ports, mut words) = records(&sensor, Some(clocks));
            let summary = judged(&sensor, &ports, &words);
            assert_eq!(summary.verdict, Verdict::Match, "{clocks}: {summary}");
            assert_eq!(summary.clocks, CLOCKS, "{clocks}");
            let held = summary.latency.map_or(emitted, |latency| latency.result_clocks);
            assert_eq!(held, clocks);
            // A laser that is off for a clock before any result is found all the same.
            words[900] ^= 1
                << ports
                    .iter()
                    .take_while(|port| port.name != "o_laser")
                    .map(|p| p.width)
                    .sum::<u32>();
            let summary = judged(&sensor, &ports, &words);
            assert_eq!(summary.first_mismatch.map(|first| first.clock), Some(900), "{clocks}");
        }
    }

    #[test]
    fn a_design_without_results_is_held_to_those_of_the_emitted_one() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
        let sensor = Sensor::new(&crate::scene::load(&path).unwrap());
        let (ports, mut words) = records(&sensor, None);
        let valid: u32 =
            ports.iter().take_while(|port| port.name != "m_axis_tvalid").map(|p| p.width).sum();
        let first = words.iter().position(|word| word >> valid & 1 == 1).unwrap() as u64;
        words.iter_mut().for_each(|word| *word &= !(1 << valid));
        let summary = judged(&sensor, &ports, &words);
        assert_eq!(summary.verdict, Verdict::Mismatch);
        let found = summary.first_mismatch.unwrap();
        assert_eq!((found.clock, found.port.as_str()), (first, "m_axis_tvalid"));
    }
}

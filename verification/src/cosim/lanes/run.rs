//! A run in lanes: each lane clocks its slice, every output is compared at every clock,
//! and the ends are stitched to the starts.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use super::LaneRefusal;
use super::expected::ExpectedRun;
use super::pulses::{LaneStimulus, refuse_if_stopped};
use super::tables::output_places;
use super::vectors::LANES;
use super::word::{Setup, VectorRun, WordResult};
use crate::cosim::error::CosimError;
use crate::cosim::sent::{SentCount, SentReader};
use crate::reference::blocks::Records;
use crate::reference::canvas::OutputChange;
use crate::reference::exercise::Exercised;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// What a run in lanes found.
#[derive(Debug)]
pub struct LanesOutcome {
    /// Clocks compared.
    pub clocks: u64,
    /// Lanes that shared them.
    pub lanes: usize,
    /// Clocks of the first 64 lanes, together, that Verilator's model went through with the same
    /// words in all registers.
    pub refereed_clocks: u64,
    /// What the outputs have shown.
    pub exercise: Exercised,
    /// What the result stream sent, in order.
    pub sent: Vec<SentCount>,
    /// For each detector the hits of each step, as the reference model counts them.
    pub hits: Vec<Vec<u64>>,
    /// The outputs after the last clock.
    pub last_outputs: Vec<u64>,
    /// A clock at which some output differed; not the first one.
    pub differs: Option<u64>,
}

/// A run in lanes.
pub(super) struct LanesRun<'a> {
    /// What all lanes share.
    pub(super) setup: Setup<'a>,
    /// Photons.
    pub(super) light: LaneStimulus<'a>,
    /// Threads that make photons.
    pub(super) threads: usize,
}

impl LanesRun<'_> {
    /// Runs all lanes.
    ///
    /// # Errors
    /// When the registers do not stitch, or a model fails.
    pub(super) fn run(
        &self,
        on_progress: &(dyn Fn(u64) + Sync),
    ) -> Result<LanesOutcome, LaneRefusal> {
        let expected =
            ExpectedRun::of(&self.light, &self.setup.slices, self.threads, self.setup.stop)?;
        let done = AtomicU64::new(0);
        let results = thread::scope(|scope| {
            let word = |number: usize| {
                let (expected, done) = (&expected, &done);
                scope.spawn(move || {
                    let word = VectorRun::new(&self.setup, expected, number * LANES)?;
                    word.run(&mut |clocks| {
                        on_progress(done.fetch_add(clocks, Ordering::Relaxed) + clocks);
                    })
                })
            };
            let count = self.setup.slices.list.len().div_ceil(LANES);
            let words: Vec<_> = (0..count).map(word).collect();
            words
                .into_iter()
                .map(|word| word.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect::<Result<Vec<WordResult>, CosimError>>()
        })?;
        let mut refereed_clocks = 0;
        for result in &results {
            refereed_clocks += result.refereed.clone().map_err(|differs| {
                LaneRefusal::NoVerdict(format!(
                    "the compiler's vectors and Verilator's words made of the same gates differ in \
                     {differs}"
                ))
            })?;
        }
        let differs = results.iter().filter_map(|result| result.differs).min();
        if differs.is_none() {
            refuse_if_stopped(self.setup.stop)?;
            self.stitch(&results)?;
        }
        let layout = Layout::of(self.setup.interface);
        Ok(LanesOutcome {
            clocks: self.setup.slices.list.last().map_or(0, |slice| slice.clocks.end),
            lanes: self.setup.slices.list.len(),
            refereed_clocks,
            sent: self.sent(&results, &layout),
            last_outputs: last_outputs(&expected.changes, &layout),
            exercise: expected.exercise,
            hits: expected.hits,
            differs,
        })
    }

    /// Every lane ends, in every register, as the next one starts: so they are one
    /// run.
    fn stitch(&self, results: &[WordResult]) -> Result<(), LaneRefusal> {
        let start =
            |lane: usize, register| results[lane / LANES].starts.get(register, lane % LANES);
        let end = |lane: usize, register| results[lane / LANES].ends.get(register, lane % LANES);
        let mut loose: Vec<String> = Vec::new();
        for (number, register) in self.setup.design.registers.iter().enumerate() {
            let fits = (1..self.setup.slices.list.len())
                .all(|lane| start(lane, number) == end(lane - 1, number));
            if !fits {
                loose.push(format!("{}[{}]", register.name.0, register.name.1));
            }
        }
        if loose.is_empty() {
            return Ok(());
        }
        let count = loose.len();
        loose.truncate(4);
        Err(LaneRefusal::NoVerdict(format!(
            "{count} registers do not begin a lane as the lane before ends, so that a guess of where \
             they are was wrong: {}{}",
            loose.join(", "),
            if count > 4 { ", ..." } else { "" }
        )))
    }

    /// What the stream sent, lane after lane.
    fn sent(&self, results: &[WordResult], layout: &Layout) -> Vec<SentCount> {
        let places = output_places(layout);
        let ready = layout.inputs.field(PortRole::Ready);
        let mut input = vec![0; layout.inputs.words];
        input[ready.word] = 1 << ready.shift;
        let valid = layout.outputs.field(PortRole::Valid);
        let mut reader = SentReader::new(self.setup.interface, layout);
        let mut sent = Vec::new();
        let mut records = Records::default();
        let mut read = |got: Vec<u64>| {
            records.inputs.clone_from(&input);
            records.got.values = got;
            reader.read(&records, &mut |count| sent.push(count));
        };
        for lane in 0..self.setup.slices.list.len() {
            for (_, planes) in &results[lane / LANES].beats {
                let mut got = vec![0; layout.outputs.words];
                for (output, &(word, shift)) in places.iter().enumerate() {
                    got[word] |= u64::from(planes.get(output, lane % LANES)) << shift;
                }
                if got[valid.word] >> valid.shift & 1 == 1 {
                    read(got);
                }
            }
        }
        read(vec![0; layout.outputs.words]);
        sent
    }
}

/// The record of those outputs that do not follow a code, after the last clock.
fn last_outputs(changes: &[OutputChange], layout: &Layout) -> Vec<u64> {
    let mut record = vec![0; layout.outputs.words];
    for change in changes {
        record[change.word] ^= change.flips;
    }
    record
}

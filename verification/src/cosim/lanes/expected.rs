//! What the reference model expects of a whole run, as changes; and what it counted
//! by the start of every slice.

use std::sync::atomic::AtomicBool;

use super::LaneRefusal;
use super::high_samples::HighSamples;
use super::pulses::LaneStimulus;
use super::slices::Slices;
use super::tally::LaneTally;
use crate::cosim::error::CosimError;
use crate::reference::canvas::{Changes, OutputChange};
use crate::reference::exercise::Exercised;
use crate::reference::predictor::{ReferenceModel, Surroundings};
use crate::reference::stimulus::RESET_CLOCKS;
use crate::scan::Sample;

/// Stimulus and expectations of a run.
pub(super) struct ExpectedRun {
    /// For each detector.
    pub(super) high: Vec<HighSamples>,
    /// In order.
    pub(super) changes: Vec<OutputChange>,
    /// For each slice what had been counted where its warm-up begins.
    pub(super) counted: Vec<Vec<i64>>,
    /// For each detector the hits of each step.
    pub(super) hits: Vec<Vec<u64>>,
    /// What the outputs show in the whole run.
    pub(super) exercise: Exercised,
}

impl ExpectedRun {
    /// Runs photons and reference model.
    ///
    /// # Errors
    /// When it is more than can be kept, or the run was stopped.
    pub(super) fn of(
        light: &LaneStimulus,
        slices: &Slices,
        threads: usize,
        stop: &AtomicBool,
    ) -> Result<ExpectedRun, LaneRefusal> {
        let interface = light.interface;
        let reference = ReferenceModel::new(interface.clone()).map_err(CosimError::from)?;
        let mut follower = Follower {
            totals: vec![Vec::new(); light.models.len()],
            reference,
            changes: Changes::default(),
            list: Vec::new(),
            tally: LaneTally::new(interface),
            clock: 0,
            // Groups before which the counted numbers are wanted, last first.
            wanted: slices
                .list
                .iter()
                .rev()
                .map(|slice| slice.group.saturating_sub(slices.warm_up_groups))
                .collect(),
            counted: Vec::new(),
            results_of_group: light.models.len() as u64 * u64::from(interface.parallel()),
            results: 0,
        };
        let clocks = slices.list.last().map_or(0, |slice| slice.clocks.end);
        follower.note();
        let high =
            light.pulses(clocks, threads, stop, |clock, hits| follower.follow(clock, hits))?;
        Ok(ExpectedRun {
            high,
            exercise: follower.reference.exercise().clone(),
            changes: follower.list,
            counted: follower.counted,
            hits: follower.totals,
        })
    }
}

/// The reference model, fed chunk by chunk.
struct Follower {
    /// For each detector the hits of each step so far.
    totals: Vec<Vec<u64>>,
    reference: ReferenceModel,
    changes: Changes,
    list: Vec<OutputChange>,
    tally: LaneTally,
    clock: u64,
    wanted: Vec<u64>,
    counted: Vec<Vec<i64>>,
    results_of_group: u64,
    results: u64,
}

impl Follower {
    /// Goes on to a clock. `hits` are those of every detector from the last one on, and
    /// perhaps later ones.
    fn follow(&mut self, until_clock: u64, hits: &[Vec<Sample>]) {
        let clocks = self.clock..until_clock;
        let surroundings = Surroundings {
            clocks: clocks.clone(),
            resets: std::iter::once(0..RESET_CLOCKS).collect(),
            ..Surroundings::default()
        };
        self.reference.predict_changes(&surroundings, hits, &mut self.changes);
        self.clock = clocks.end;
        // What ends with the chunk goes on in the next: its end is not a change.
        self.list.extend(self.changes.take_before(clocks.end));
        let results: Vec<_> = self.reference.take_finished().collect();
        for result in results {
            if self.results.is_multiple_of(self.results_of_group) {
                self.note();
            }
            self.results += 1;
            self.tally.add(&result);
            self.totals[result.detector].push(result.total);
        }
        if self.results.is_multiple_of(self.results_of_group) {
            self.note();
        }
    }

    /// Notes the numbers for the slices that want those of the groups so far.
    fn note(&mut self) {
        let groups = self.results / self.results_of_group;
        while self.wanted.last() == Some(&groups) {
            self.wanted.pop();
            self.counted.push(self.tally.values());
        }
    }
}

//! The pulses of a run, made by several threads and kept.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use super::Unfit;
use super::high_samples::HighSamples;
use crate::photons::fast::Recorder;
use crate::photons::{DetectorModel, Pulse, PulseStream};
use crate::reference::stimulus::{RESET_CLOCKS, first_sample};
use crate::scan::{Group, Sample, Sampling};
use crate::sensor::interface::Interface;

/// Groups that a thread makes at once.
const GROUPS_AT_ONCE: u64 = 64;

/// What drives a run in lanes.
#[derive(Debug, Clone, Copy)]
pub(super) struct LaneStimulus<'a> {
    /// The detectors.
    pub(super) models: &'a [DetectorModel],
    /// The sensor.
    pub(super) interface: &'a Interface,
    /// The seed.
    pub(super) seed: u64,
}

/// The pulses of some groups, detector by detector.
#[derive(Default)]
struct Chunk {
    /// Clock before which the pulses of the next groups do not begin.
    until_clock: u64,
    /// For each detector.
    pulses: Vec<Vec<Pulse>>,
}

/// All chunks so far, in order.
struct Joined<F> {
    /// What pulses are counted from.
    origin: Sample,
    sampling: Sampling,
    /// Those that came before their turn.
    early: BTreeMap<u64, Chunk>,
    /// Number of the next one.
    wanted: u64,
    /// For each detector.
    high: Vec<HighSamples>,
    /// Those that have not been told.
    hits: Vec<Vec<Sample>>,
    /// Chunks that have been taken in, for their memory.
    spare: Vec<Chunk>,
    on_hits: F,
}

impl<F: FnMut(u64, &[Vec<Sample>])> Joined<F> {
    /// Takes in a chunk, and those that have waited for it; gives one that is used up.
    fn take(&mut self, number: u64, chunk: Chunk) -> Result<Chunk, Unfit> {
        self.early.insert(number, chunk);
        while let Some(chunk) = self.early.remove(&self.wanted) {
            let of_detectors = chunk.pulses.iter().zip(&mut self.high).zip(&mut self.hits);
            for ((pulses, high), hits) in of_detectors {
                high.add(pulses, self.origin, hits)?;
            }
            (self.on_hits)(chunk.until_clock, &self.hits);
            let told = self.sampling.first_sample(chunk.until_clock);
            self.hits.iter_mut().for_each(|hits| {
                hits.drain(..hits.partition_point(|&hit| hit < told));
            });
            self.wanted += 1;
            self.spare.push(chunk);
        }
        Ok(self.spare.pop().unwrap_or_default())
    }
}

impl LaneStimulus<'_> {
    /// Makes the pulses of the first `clocks` clocks on several threads, and keeps the samples
    /// that are high, detector by detector. `on_hits` gets clock after clock before which all is
    /// known, with each detector's hits from the clock before on, and perhaps later ones: the
    /// first samples of runs of high samples.
    ///
    /// # Errors
    /// When there are too many to keep, or `stop` is set.
    pub(super) fn pulses(
        &self,
        clocks: u64,
        threads: usize,
        stop: &AtomicBool,
        on_hits: impl FnMut(u64, &[Vec<Sample>]) + Send,
    ) -> Result<Vec<HighSamples>, Unfit> {
        let groups = self.interface.groups();
        let needed = clocks.div_ceil(self.interface.timing.scan.integration_chips);
        let chunks = needed.min(groups).div_ceil(GROUPS_AT_ONCE);
        let next = AtomicU64::new(0);
        let recorders: Vec<_> = self.models.iter().map(|m| Arc::new(Recorder::new(m))).collect();
        let joined = Mutex::new(Joined {
            origin: first_sample(self.interface, RESET_CLOCKS),
            sampling: self.interface.timing.sampling(),
            early: BTreeMap::new(),
            wanted: 0,
            high: vec![HighSamples::default(); self.models.len()],
            hits: vec![Vec::new(); self.models.len()],
            spare: Vec::new(),
            on_hits,
        });
        let locked = || joined.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || {
            let mut chunk = Chunk::default();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= chunks {
                    return Ok(());
                }
                self.make(&mut chunk, &recorders, (number, number + 1 == chunks), clocks);
                // Whoever made the chunk that is wanted goes on with it: it is in that core's cache.
                let taken = refuse_if_stopped(stop).and_then(|()| locked().take(number, chunk));
                chunk = taken.inspect_err(|_| next.store(chunks, Ordering::Relaxed))?;
            }
        };
        thread::scope(|scope| {
            let makers: Vec<_> = (0..threads).map(|_| scope.spawn(make)).collect();
            makers.into_iter().try_for_each(|maker| {
                maker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })
        })?;
        Ok(joined.into_inner().unwrap_or_else(PoisonError::into_inner).high)
    }

    /// Makes a chunk, in the memory of one that is used up.
    fn make(
        &self,
        chunk: &mut Chunk,
        recorders: &[Arc<Recorder>],
        (number, is_last): (u64, bool),
        clocks: u64,
    ) {
        let sampling = self.interface.timing.sampling();
        let origin = first_sample(self.interface, RESET_CLOCKS);
        let first = Group(number * GROUPS_AT_ONCE);
        let end = Group(first.0 + GROUPS_AT_ONCE);
        chunk.until_clock = if is_last {
            clocks
        } else {
            end.0 * self.interface.timing.scan.integration_chips + sampling.clock_of(origin)
        };
        let until_sample = match is_last {
            true => sampling.samples_of(clocks).saturating_sub(origin.0),
            false => u64::MAX,
        };
        chunk.pulses.resize_with(recorders.len(), Vec::new);
        for (recorder, pulses) in recorders.iter().zip(&mut chunk.pulses) {
            let stop = (!is_last).then_some(end);
            let mut stream = PulseStream::of_groups(recorder, self.seed, 0, first, stop);
            pulses.clear();
            stream.advance(Sample(until_sample), pulses);
        }
    }
}

/// # Errors
/// When a run is no longer wanted.
pub(super) fn refuse_if_stopped(stop: &AtomicBool) -> Result<(), Unfit> {
    match stop.load(Ordering::Relaxed) {
        true => Err(Unfit::new("it was stopped")),
        false => Ok(()),
    }
}

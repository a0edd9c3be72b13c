//! The pulses of a run, made by several threads and kept.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;

use super::Unfit;
use crate::photons::fast::Recorder;
use crate::photons::{DetectorModel, Pulse, PulseStream};
use crate::reference::stimulus::{RESET_CLOCKS, first_sample};
use crate::scan::{Group, Sample};
use crate::sensor::interface::Interface;

/// Groups that a thread makes at once.
const GROUPS_AT_ONCE: u64 = 64;
/// Most pulses that are kept, 8 bytes each.
const MOST_PULSES: usize = 1 << 27;

/// A stretch of high samples in one word: the first, and how many there are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packed(u64);

impl Packed {
    const LENGTH_BITS: u32 = 16;

    fn new(high: Range<Sample>) -> Option<Packed> {
        let (first, length) = (high.start.0, high.end - high.start);
        (length < 1 << Self::LENGTH_BITS && first < 1 << (64 - Self::LENGTH_BITS))
            .then_some(Packed(first << Self::LENGTH_BITS | length))
    }

    /// The samples that are high.
    pub(super) fn samples(self) -> Range<Sample> {
        let first = Sample(self.0 >> Self::LENGTH_BITS);
        first..first + (self.0 & ((1 << Self::LENGTH_BITS) - 1))
    }
}

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

/// The pulses of some groups, detector by detector, numbered as the run's samples.
struct Chunk {
    /// Clock before which the pulses of the next groups do not begin.
    until_clock: u64,
    /// For each detector.
    pulses: Vec<Vec<Pulse>>,
}

impl LaneStimulus<'_> {
    /// Makes the pulses of the first `clocks` clocks on several threads, and keeps the samples
    /// that are high, detector by detector. `on_hits` gets clock after clock before which all is
    /// known, with each detector's hits from the clock before on, and perhaps later ones: the
    /// first samples of runs of high samples.
    ///
    /// # Errors
    /// When there are too many to keep, one is too long, or `stop` is set.
    pub(super) fn pulses(
        &self,
        clocks: u64,
        threads: usize,
        stop: &AtomicBool,
        mut on_hits: impl FnMut(u64, &[Vec<Sample>]),
    ) -> Result<Vec<Vec<Packed>>, Unfit> {
        let groups = self.interface.groups();
        let needed = clocks.div_ceil(self.interface.timing.scan.integration_chips);
        let chunks = needed.min(groups).div_ceil(GROUPS_AT_ONCE);
        let next = AtomicU64::new(0);
        let sampling = self.interface.timing.sampling();
        let mut kept: Vec<Kept> = vec![Kept::default(); self.models.len()];
        let mut hits = vec![Vec::new(); self.models.len()];
        let recorders: Vec<_> = self.models.iter().map(|m| Arc::new(Recorder::new(m))).collect();
        thread::scope(|scope| {
            let (done, made) = sync_channel(2 * threads);
            for _ in 0..threads {
                let (done, next, recorders) = (done.clone(), &next, &recorders);
                scope.spawn(move || {
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= chunks {
                            return;
                        }
                        let chunk = self.chunk(recorders, number, number + 1 == chunks, clocks);
                        if done.send((number, chunk)).is_err() {
                            return;
                        }
                    }
                });
            }
            drop(done);
            let mut early = BTreeMap::new();
            let mut wanted = 0;
            for (number, chunk) in made {
                refuse_if_stopped(stop)?;
                early.insert(number, chunk);
                while let Some(chunk) = early.remove(&wanted) {
                    let of_detectors = chunk.pulses.iter().zip(&mut kept).zip(&mut hits);
                    for ((pulses, kept), hits) in of_detectors {
                        kept.add(pulses, hits)?;
                    }
                    on_hits(chunk.until_clock, &hits);
                    let told = sampling.first_sample(chunk.until_clock);
                    hits.iter_mut().for_each(|hits| {
                        hits.drain(..hits.partition_point(|&hit| hit < told));
                    });
                    wanted += 1;
                }
            }
            Ok(())
        })?;
        Ok(kept.into_iter().map(|kept| kept.high).collect())
    }

    fn chunk(&self, recorders: &[Arc<Recorder>], number: u64, is_last: bool, clocks: u64) -> Chunk {
        let sampling = self.interface.timing.sampling();
        let origin = first_sample(self.interface, RESET_CLOCKS);
        let first = Group(number * GROUPS_AT_ONCE);
        let end = Group(first.0 + GROUPS_AT_ONCE);
        let until_clock = if is_last {
            clocks
        } else {
            end.0 * self.interface.timing.scan.integration_chips + sampling.clock_of(origin)
        };
        let until_sample = match is_last {
            true => sampling.samples_of(clocks).saturating_sub(origin.0),
            false => u64::MAX,
        };
        let of_detector = |recorder: &Arc<Recorder>| {
            let stop = (!is_last).then_some(end);
            let mut stream = PulseStream::of_groups(recorder, self.seed, 0, first, stop);
            let mut pulses = Vec::new();
            stream.advance(Sample(until_sample), &mut pulses);
            pulses.iter_mut().for_each(|pulse| pulse.shift(origin));
            pulses
        };
        Chunk { until_clock, pulses: recorders.iter().map(of_detector).collect() }
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

/// The samples at which a detector's level is high.
#[derive(Debug, Clone, Default)]
struct Kept {
    /// In order; they never overlap.
    high: Vec<Packed>,
    /// End of the last of them.
    until: Sample,
}

impl Kept {
    /// Takes in pulses, in order of their first samples, and adds the hits that they make. One that
    /// begins where another has just ended makes none.
    fn add(&mut self, pulses: &[Pulse], hits: &mut Vec<Sample>) -> Result<(), Unfit> {
        if self.high.len() + pulses.len() > MOST_PULSES {
            return Err(Unfit::new(format!(
                "the scan has more than {MOST_PULSES} pulses, which lanes keep in memory"
            )));
        }
        for pulse in pulses {
            if pulse.first > self.until {
                hits.push(pulse.first);
            }
            let first = pulse.first.max(self.until);
            if first >= pulse.end {
                continue;
            }
            let packed = Packed::new(first..pulse.end)
                .ok_or_else(|| Unfit::new("a pulse is 65,536 samples long"))?;
            self.high.push(packed);
            self.until = pulse.end;
        }
        Ok(())
    }
}

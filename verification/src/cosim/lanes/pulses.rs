//! The pulses of a run, made by several threads and kept.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;

use super::Unfit;
use crate::photons::{DetectorModel, Pulse, PulseStream};
use crate::reference::stimulus::{RESET_CLOCKS, first_sample};
use crate::scan::{Group, Sample};
use crate::sensor::interface::Interface;

/// Groups that a thread makes at once.
const GROUPS_AT_ONCE: u64 = 32;
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
pub(super) struct Light<'a> {
    /// The detectors.
    pub(super) models: &'a [DetectorModel],
    /// The sensor.
    pub(super) interface: &'a Interface,
    /// The seed.
    pub(super) seed: u64,
}

/// The pulses of some groups, detector by detector, numbered as the run's samples.
pub(super) struct Chunk {
    /// Clock before which the pulses begin.
    pub(super) until_clock: u64,
    /// For each detector.
    pub(super) pulses: Vec<Vec<Pulse>>,
}

impl Light<'_> {
    /// Makes the pulses of the first `clocks` clocks on several threads; gives them to
    /// `on_chunk` in order, and keeps the samples that are high, detector by detector.
    ///
    /// # Errors
    /// When there are too many to keep, one is too long, or `stop` is set.
    pub(super) fn pulses(
        &self,
        clocks: u64,
        threads: usize,
        stop: &AtomicBool,
        mut on_chunk: impl FnMut(&Chunk),
    ) -> Result<Vec<Vec<Packed>>, Unfit> {
        let groups = self.interface.groups();
        let needed = clocks.div_ceil(self.interface.timing.scan.integration_chips);
        let chunks = needed.min(groups).div_ceil(GROUPS_AT_ONCE);
        let next = AtomicU64::new(0);
        let mut kept: Vec<Vec<Packed>> = vec![Vec::new(); self.models.len()];
        thread::scope(|scope| {
            let (done, made) = sync_channel(2 * threads);
            for _ in 0..threads {
                let (done, next) = (done.clone(), &next);
                scope.spawn(move || {
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= chunks {
                            return;
                        }
                        let chunk = self.chunk(number, number + 1 == chunks, clocks);
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
                    keep(&chunk, &mut kept)?;
                    on_chunk(&chunk);
                    wanted += 1;
                }
            }
            Ok(kept)
        })
    }

    fn chunk(&self, number: u64, is_last: bool, clocks: u64) -> Chunk {
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
        let of_detector = |model| {
            let stop = (!is_last).then_some(end);
            let mut stream = PulseStream::of_groups(model, self.seed, 0, first, stop);
            let mut pulses = Vec::new();
            stream.advance(Sample(until_sample), &mut pulses);
            pulses.iter_mut().for_each(|pulse| pulse.shift(origin));
            pulses
        };
        Chunk { until_clock, pulses: self.models.iter().map(of_detector).collect() }
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

/// Keeps the part of each pulse that begins where those before it have ended, so that
/// what is kept never overlaps.
fn keep(chunk: &Chunk, kept: &mut [Vec<Packed>]) -> Result<(), Unfit> {
    for (pulses, kept) in chunk.pulses.iter().zip(kept) {
        if kept.len() + pulses.len() > MOST_PULSES {
            return Err(Unfit::new(format!(
                "the scan has more than {MOST_PULSES} pulses, which lanes keep in memory"
            )));
        }
        let mut high_until = kept.last().map_or(Sample(0), |last| last.samples().end);
        for pulse in pulses {
            let first = pulse.first.max(high_until);
            if first >= pulse.end {
                continue;
            }
            let packed = Packed::new(first..pulse.end)
                .ok_or_else(|| Unfit::new("a pulse is 65,536 samples long"))?;
            kept.push(packed);
            high_until = pulse.end;
        }
    }
    Ok(())
}

//! Photons of a detector on their way into bins and pulses.

use super::epochs::{EpochLine, Sampled, TOGETHER};
use crate::photons::fast::{InstructionSet, Runner};
use crate::photons::{Level, Pulse};
use crate::scan::{Sample, Sampler};

/// How many samples there are between two epochs, and in a scan.
pub(super) struct EpochSamples {
    pub of_epoch: u64,
    pub of_scan: u64,
}

/// What has been folded of a detector's photons.
pub(super) struct Folding {
    /// Samples that a pulse is high for.
    pulse_samples: f64,
    sampler: Sampler,
    /// Rising edges in each bin: what is below 2^16, which fits the processor's nearest memory, and the rest.
    few: Vec<u16>,
    many: Vec<u64>,
    level: Level,
    last: u64,
    pub photons: u64,
    /// Of these, those that no sample shows as a rising edge.
    pub unseen: u64,
    /// Of the first scan.
    pub pulses: Vec<Pulse>,
}

impl Folding {
    /// Of pulses that are `pulse_samples` wide, into so many bins.
    pub fn new(pulse_samples: f64, sampler: Sampler, bins: usize) -> Folding {
        Folding {
            pulse_samples,
            sampler,
            few: vec![0; bins],
            many: vec![0; bins],
            level: Level::default(),
            last: 0,
            photons: 0,
            unseen: 0,
            pulses: Vec::new(),
        }
    }

    /// Takes the photons of a line, and forgets those that are earlier.
    pub fn fold(&mut self, line: &EpochLine, waiting: &mut Vec<u64>, samples: &EpochSamples) {
        let mut fold = Fold { folding: self, line, waiting, samples, taken: 0 };
        InstructionSet::best().run(&mut fold);
        let taken = fold.taken;
        waiting.drain(..taken);
    }

    /// Takes a photon that shows from sample `rises` on, which is `of_epoch` of its epoch.
    #[inline(always)]
    fn take(&mut self, rises: u64, of_epoch: u64, high: u64, samples: &EpochSamples) {
        // Where two lines meet a photon may come before one that was earlier by a tick.
        let first = rises.max(self.last);
        let end = (rises + high).max(first);
        let pulse = Pulse { first: Sample(first), end: Sample(end) };
        self.last = first;
        self.photons += 1;
        let leaves_no_trace = end == first;
        if leaves_no_trace || !self.level.rises(&pulse) {
            self.unseen += 1;
        } else {
            // An epoch is of whole code periods, mostly of one.
            let (bin, bins) = (of_epoch as usize, self.few.len());
            let bin = if bin < bins { bin } else { bin % bins };
            self.few[bin] = self.few[bin].wrapping_add(1);
            if self.few[bin] == 0 {
                self.many[bin] += 1 << 16;
            }
        }
        if first < samples.of_scan && !leaves_no_trace {
            self.pulses.push(pulse);
        }
    }

    /// Rising edges in each bin.
    pub fn bins(&self) -> Vec<u64> {
        self.many.iter().zip(&self.few).map(|(many, few)| many + u64::from(*few)).collect()
    }
}

/// The photons of a line on their way.
struct Fold<'a> {
    folding: &'a mut Folding,
    line: &'a EpochLine,
    waiting: &'a [u64],
    samples: &'a EpochSamples,
    /// Those before the line's end.
    taken: usize,
}

impl Runner for Fold<'_> {
    #[inline(always)]
    fn run(&mut self) {
        let Fold { folding, line, waiting, samples, taken } = self;
        let base = line.first() * samples.of_epoch;
        let mut sampled = Sampled::default();
        for photons in waiting.chunks(TOGETHER) {
            let (sampler, pulse) = (&folding.sampler, folding.pulse_samples);
            line.sample(photons, samples.of_epoch, sampler, pulse, &mut sampled);
            let Sampled { since_line, of_epoch, high } = &sampled;
            let places = since_line.iter().zip(of_epoch).zip(high);
            for (&ticks, ((since, &of_epoch), &high)) in photons.iter().zip(places) {
                if ticks >= line.until {
                    return;
                }
                if ticks >= line.from {
                    folding.take(base + since, of_epoch, high, samples);
                }
                *taken += 1;
            }
        }
    }
}

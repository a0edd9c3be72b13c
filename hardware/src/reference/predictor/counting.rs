//! Hits, counted up and down by the sign of the delayed reference (eq. 11).

use std::ops::Range;

use super::{ReferenceModel, Surroundings};
use crate::reference::coverage::CountedHit;
use crate::scan::{Group, Sample, Sampling};
use crate::scene::DetectorIndex;
use crate::sensor::cells::CellChange;

/// The signs with which one group's correlators count hits, for one detector.
#[derive(Debug, Clone, Copy)]
pub struct GroupSigns<'a> {
    /// Of each chip of the detector's code.
    signs: &'a [i8],
    sampling: Sampling,
    /// The group's first sample.
    origin: Sample,
    /// Sample of the code's period that the group's first step has there.
    first: u64,
}

/// The same signs at one sample.
#[derive(Debug, Clone, Copy)]
pub struct SampleSigns<'a> {
    signs: &'a [i8],
    sampling: Sampling,
    period: u64,
    /// Sample of the code's period that the group's first step has.
    delayed: u64,
}

impl<'a> GroupSigns<'a> {
    /// At a sample of the group. It costs a division, which is more than each step's does.
    pub fn at(&self, sample: Sample) -> SampleSigns<'a> {
        let period = self.sampling.samples_of(self.signs.len() as u64);
        SampleSigns {
            signs: self.signs,
            sampling: self.sampling,
            period,
            delayed: (self.first + (sample - self.origin)) % period,
        }
    }

    /// At samples of the group that follow one another: a division for all of them.
    pub fn along(self, samples: Range<Sample>) -> impl Iterator<Item = (Sample, SampleSigns<'a>)> {
        let mut signs = self.at(samples.start);
        (samples.start.0..samples.end.0).map(move |sample| {
            let here = signs;
            signs.delayed = if here.delayed + 1 == here.period { 0 } else { here.delayed + 1 };
            (Sample(sample), here)
        })
    }
}

impl SampleSigns<'_> {
    /// Whether the correlator of the group's step `step` counts a hit up.
    #[inline]
    pub fn count_up(&self, step: u64) -> bool {
        // Hardly ever: a code period has more samples than a group has steps.
        let step = if step < self.period { step } else { step % self.period };
        let delayed = match self.delayed.checked_sub(step) {
            Some(delayed) => delayed,
            None => self.delayed + self.period - step,
        };
        self.signs[self.sampling.clock_of(Sample(delayed)) as usize] > 0
    }
}

impl ReferenceModel {
    /// How the present group's correlators of a detector count, if its first sample is
    /// `origin`.
    pub fn group_signs(&self, detector: DetectorIndex, origin: Sample) -> GroupSigns<'_> {
        let signs = &self.signs[detector][..];
        let sampling = self.interface.timing.sampling();
        let period = sampling.samples_of(signs.len() as u64);
        let first = sampling.samples_of(self.scan.from % signs.len() as u64);
        GroupSigns {
            signs,
            sampling,
            origin,
            first: (first + period - self.delay() % period) % period,
        }
    }

    /// Looks for hits on the last sample before a scan, if its clock is among these.
    fn watch_before_scan(&mut self, clocks: &Range<u64>, hits: &[Vec<Sample>]) {
        let first_word = self.released + 1 + self.scan.from;
        let may_pause = self.scan.scan == 0 || self.interface.realigns() || self.hosted.is_some();
        if self.scan.group != Group(0) || !may_pause || !clocks.contains(&(first_word - 1)) {
            return;
        }
        let of_scan = self.interface.timing.sampling().first_sample(first_word);
        let sample = Sample(of_scan.0 - 1);
        for (seen, hits) in self.before_scan.iter_mut().zip(hits) {
            *seen = hits.binary_search(&sample).is_ok();
        }
    }

    /// Counts the hits of a stretch of clocks, group by group, and ends the
    /// groups whose last word is among them. The word of cycle n is presented
    /// one clock after the chip of cycle n shows on `o_laser`.
    pub(super) fn count(&mut self, clocks: Range<u64>, block: &Surroundings, hits: &[Vec<Sample>]) {
        let sampling = self.interface.timing.sampling();
        let first_word = self.released + 1;
        let mut counted = clocks.start.max(first_word);
        loop {
            self.watch_before_scan(&clocks, hits);
            let group_end = first_word + self.scan.from + self.scan.chips;
            let until = group_end.min(clocks.end);
            let from = counted.max(first_word + self.scan.from);
            if from < until {
                let samples = sampling.samples(&(from..until));
                for (detector, hits) in DetectorIndex::all().zip(hits.iter()) {
                    let first = hits.partition_point(|&s| s < samples.start);
                    let end = first + hits[first..].partition_point(|&s| s < samples.end);
                    self.count_detector(detector, &hits[first..end]);
                }
                for (detector, changes) in DetectorIndex::all().zip(&block.cells) {
                    self.running.cells(detector, CellChange::within(changes, &samples));
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
    fn count_detector(&mut self, detector: DetectorIndex, hits: &[Sample]) {
        let (Some(first_hit), Some(last_hit)) = (hits.first(), hits.last()) else {
            return;
        };
        let sampling = self.interface.timing.sampling();
        let first_sample = sampling.first_sample(self.released + 1);
        let group_start = first_sample + sampling.samples_of(self.scan.from);
        if let Some(histogram) = &mut self.histogram {
            let samples = (first_sample, group_start);
            return histogram.count(detector, hits, samples, &mut self.resets);
        }
        let first = self.group_signs(detector, group_start).first;
        let signs = &self.signs[detector][..];
        let period = sampling.samples_of(signs.len() as u64);
        let parallel = u64::from(self.interface.parallel());
        self.totals[detector] += hits.len() as u64;
        self.running.counted(detector, hits.len() as u64);
        let counts = &mut self.counts[detector.0 * parallel as usize..][..parallel as usize];
        for (step, count) in (0..parallel).zip(counts) {
            let first = (first + period - step % period) % period;
            // Whole code periods behind the first.
            let mut periods = 0;
            let signed = hits.iter().map(|&sample| {
                let mut delayed = sample - group_start + first - periods;
                // A division costs more than all the rest, and many hits share a period.
                if delayed >= period {
                    periods += delayed - delayed % period;
                    delayed %= period;
                }
                CountedHit {
                    clock: sampling.clock_of(sample),
                    lane: sampling.lane_of(sample),
                    up: signs[sampling.clock_of(Sample(delayed)) as usize] > 0,
                }
            });
            *count += self.running.count((detector, step as usize), signed);
        }
        if let Some(beside) = self.hosted.as_mut().and_then(|hosted| hosted.beside.as_mut()) {
            let first = (first + period - beside.later(period)) % period;
            let signs = GroupSigns { signs, sampling, origin: group_start, first };
            let counts = &mut beside.counts[detector.0 * parallel as usize..][..parallel as usize];
            for &hit in hits {
                let signs = signs.at(hit);
                for (step, count) in (0..parallel).zip(&mut *counts) {
                    *count += if signs.count_up(step) { 1 } else { -1 };
                }
            }
        }
        // Of the words with a hit the last two are what a reset may come upon.
        let word = sampling.clock_of(*last_hit);
        let before = hits.iter().rev().map(|&hit| sampling.clock_of(hit)).find(|&w| w != word);
        before.into_iter().chain([word]).for_each(|word| self.resets.hits_in(word));
        // A group may be as long as 64 bits tell, its end farther than they do.
        let last_sample = sampling.samples_of(self.scan.chips) - 1;
        let first = *first_hit == group_start;
        let last = *last_hit - group_start == last_sample;
        self.running.border(detector, first, last);
    }
}

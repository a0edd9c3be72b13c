//! Hits, counted in the bins of their samples; and what a frame has counted when it ends.

use super::{Ended, HistogramModel};
use crate::reference::coverage::{BinPoint, CoverPoint, GroupPosition, ScanPoint};
use crate::reference::exercise::Exercised;
use crate::reference::resets::ResetWatch;
use crate::scan::{Sample, Sampling};
use crate::scene::DetectorIndex;
use crate::sensor::histogram::{CLOCKS_TO_FLAG, CLOCKS_TO_TURN};
use crate::sensor::layout::mask;

impl HistogramModel {
    /// Whether a hit has been counted in the present frame.
    pub(in crate::reference) fn has_counted(&self) -> bool {
        self.bins.iter().flatten().any(|&bin| bin > 0)
    }

    /// Counts a detector's hits in words of the present frame, whose first sample is
    /// `frame_start`; `first_sample` is that of a code period.
    pub(in crate::reference) fn count(
        &mut self,
        detector: DetectorIndex,
        hits: &[Sample],
        (first_sample, frame_start): (Sample, Sample),
        resets: &mut ResetWatch,
    ) {
        let sampling = Sampling::new(self.plan.row_bins);
        let adder_of = |sample| sampling.lane_of(sample) / self.plan.adder_samples;
        let period = self.plan.bins();
        let frame_samples = period * self.plan.periods;
        let limit = mask(self.plan.bin_bits);
        for word in hits.chunk_by(|&a, &b| sampling.clock_of(a) == sampling.clock_of(b)) {
            let clock = sampling.clock_of(word[0]);
            resets.hits_in(clock);
            let mut adders = 0;
            for at_adder in word.chunk_by(|&a, &b| adder_of(a) == adder_of(b)) {
                // Of several the earliest counts.
                let sample = at_adder[0];
                let adder = adder_of(sample);
                adders += 1;
                let points = &self.points[detector.0];
                if at_adder.len() > 1 {
                    self.proves.add(points.extra[adder as usize]);
                }
                let bin = ((sample - first_sample) % period) as usize;
                let lane = sampling.lane_of(sample);
                let count = self.bins[detector][bin];
                if count == limit {
                    self.was_clamped = true;
                    self.flags.push_back((clock + u64::from(CLOCKS_TO_FLAG), detector, lane));
                    continue;
                }
                self.bins[detector][bin] += 1;
                let later = sample - frame_start >= period;
                self.proves.add(points.hit[lane as usize][usize::from(later)]);
                if (count + 1).is_power_of_two() {
                    let bit = (count + 1).ilog2();
                    self.proves.add(points.carry[adder as usize][bit as usize]);
                    self.tops[detector] |= u64::from(bit + 1 == self.plan.bin_bits) << lane;
                }
                for (first, at) in [(true, 0), (false, frame_samples - 1)] {
                    if sample - frame_start == at {
                        self.proves.add(points.border[usize::from(first)]);
                    }
                }
            }
            if adders == self.plan.adders() {
                self.proves.add(self.points[detector.0].full_row);
            }
        }
    }

    /// The present frame ends: its last word was presented at `clock`.
    pub(in crate::reference) fn end_frame(
        &mut self,
        clock: u64,
        scan: u64,
        resets: &mut ResetWatch,
        exercise: &mut Exercised,
    ) {
        resets.group_ends(clock, true, self.has_counted());
        exercise.phase_steps += self.plan.bins();
        exercise.saturations += u64::from(std::mem::take(&mut self.was_clamped));
        let bins: Vec<Vec<u64>> =
            self.bins.iter_mut().map(|bins| std::mem::replace(bins, vec![0; bins.len()])).collect();
        if self.plan.saturates() {
            self.find_full(&bins);
        }
        let mut proves = self.proves.take();
        let is_later = scan > 0;
        let place = GroupPosition::Last;
        proves.extend(self.table.number(ScanPoint::Result { place, later_scan: is_later }));
        proves.append(&mut resets.of_results);
        self.ended.push_back(Ended {
            turn: clock + u64::from(CLOCKS_TO_TURN),
            is_later,
            bins,
            tops: self.tops.iter_mut().map(std::mem::take).collect(),
            proves,
        });
    }

    /// Notes the lanes with a bin at its limit.
    fn find_full(&mut self, bins: &[Vec<u64>]) {
        let (lanes, limit) = (self.plan.row_bins, mask(self.plan.bin_bits));
        for (detector, bins) in DetectorIndex::all().zip(bins) {
            for lane in 0..lanes {
                let of_lane = bins.iter().skip(lane as usize).step_by(lanes as usize);
                if of_lane.into_iter().any(|&bin| bin == limit) {
                    self.proves.add(self.points[detector.0].full[lane as usize]);
                }
            }
        }
    }

    /// Lanes with a bin whose top bit is set in the memory that counted.
    pub(super) fn find_tops(&self, ended: &mut Ended) {
        let memory = self.half;
        for (detector, &tops) in DetectorIndex::all().zip(&ended.tops) {
            let lanes = (0..self.plan.row_bins).filter(|&lane| tops >> lane & 1 == 1);
            let point = |lane| CoverPoint::of(detector, BinPoint::Top { lane, memory });
            ended.proves.extend(lanes.filter_map(|lane| self.table.number(point(lane))));
        }
    }

    /// Lanes with a bin that this frame has no hit in, and that its memory had counts in.
    pub(super) fn find_emptied(&self, ended: &mut Ended) {
        let Some(before) = &self.memories[self.half] else {
            return;
        };
        let lanes = self.plan.row_bins as usize;
        for (detector, (before, bins)) in DetectorIndex::all().zip(before.iter().zip(&ended.bins)) {
            for lane in 0..lanes {
                let mut pairs = before.iter().zip(bins).skip(lane).step_by(lanes);
                if pairs.any(|(&before, &now)| before > 0 && now == 0) {
                    let point = BinPoint::Emptied { lane: lane as u32 };
                    ended.proves.extend(self.table.number(CoverPoint::of(detector, point)));
                }
            }
        }
    }
}

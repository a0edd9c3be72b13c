//! What a group of steps has counted when it ends: its results, and what they prove.

use super::{ReferenceModel, StepResult};
use crate::reference::axis::Beat;
use crate::reference::coverage::{CoverPoint, GroupPosition, HitPoint, SaturationPoint, ScanPoint};
use crate::reference::exercise::CountedHits;
use crate::reference::stream::GroupArrival;
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::layout::mask;

impl ReferenceModel {
    /// Sends the present group's counts on their way and goes on to the next.
    pub(super) fn finish_group(&mut self) {
        let end = self.scan.from + self.scan.chips;
        if let Some(histogram) = &mut self.histogram {
            let exercise = &mut self.stream.axis.exercise;
            let last_word = self.released + end;
            histogram.end_frame(last_word, self.scan.scan, &mut self.resets, exercise);
            return self.go_on(end, true);
        }
        let grouping = self.interface.grouping();
        let last = grouping.is_last(self.scan.group);
        let shows_at = self.released + end + u64::from(self.interface.result_latency_clocks);
        let (beats, clamps) = self.beats(shows_at);
        let saturated = clamps.counts + clamps.totals > 0;
        let proves = self.proven_points(last);
        self.stream.axis.exercise.phase_steps += grouping.steps_of(self.scan.group).count() as u64;
        let is_counted = self.totals.iter().any(|&total| total > 0);
        self.resets.group_ends(self.released + end, last, is_counted);
        self.stream.push(GroupArrival {
            clock: shows_at,
            beats,
            saturated,
            last,
            place: GroupPosition::of(self.scan.group.0, self.interface.groups()),
            proves,
            proves_if_first: clamps
                .lone_points(last)
                .into_iter()
                .filter_map(|point| self.table.number(point?))
                .collect(),
        });
        if let Some(peak) = self.peak.as_mut().filter(|_| last) {
            peak.end_scan(self.released + end, &mut self.resets.of_peaks, &self.table);
        }
        if let Some(hosted) = self.hosted.as_mut().filter(|_| last) {
            hosted.scan_ends(shows_at);
        }
        self.counts.fill(0);
        self.totals.fill(0);
        self.go_on(end, last);
    }

    /// The results of the present group, in the order in which they are sent, and what
    /// was saturated.
    fn beats(&mut self, shows_at: u64) -> (Vec<Beat>, Clamps) {
        let parallel = self.interface.parallel() as usize;
        let grouping = self.interface.grouping();
        let steps = grouping.steps_of(self.scan.group).len();
        let first = grouping.step_of(self.scan.group, 0).0;
        let limit = 1i128 << (self.interface.count_bits() - 1);
        let most = self.interface.total().map_or(u64::MAX, |total| mask(total.bits));
        let mut beats = Vec::with_capacity(self.counts.len());
        let mut clamps = Clamps::default();
        for (detector, counts) in DetectorIndex::all().zip(self.counts.chunks_exact(parallel)) {
            let total = self.totals[detector].min(most);
            if total != self.totals[detector] {
                clamps.totals += 1;
                clamps.total = detector;
            }
            for (step, &exact) in counts.iter().enumerate() {
                let count = i128::from(exact).clamp(-limit, limit - 1) as i64;
                let is_absent = step >= steps;
                clamps.count(is_absent, count != exact, (detector, step, exact > 0));
                if is_absent {
                    continue;
                }
                let counted = CountedHits::new(detector, exact, self.totals[detector]);
                beats.push(self.stream.beat(count, total, counted));
                let number = first + step as u64;
                if let Some(hosted) = &mut self.hosted {
                    hosted.count(count);
                }
                if let Some(peak) = &mut self.peak {
                    // It counts the steps that it has seen.
                    let seen = Step(number - self.scan.left_out);
                    let shown = match self.hosted {
                        None => self.interface.timing.scan.phase_step(seen),
                        // From the scan's first on.
                        Some(_) => seen.0,
                    };
                    peak.count((detector, step), shown, count, self.scan.group);
                }
                self.finished.push(StepResult {
                    clock: shows_at,
                    scan: self.scan.scan,
                    detector,
                    step: number,
                    count,
                    total,
                    exact,
                    exact_total: self.totals[detector],
                });
            }
        }
        (beats, clamps)
    }

    /// Cover points that the results of the present group, the `last` of its scan or not, prove when they show.
    fn proven_points(&mut self, last: bool) -> Vec<usize> {
        let parallel = u64::from(self.interface.parallel());
        let steps = self.interface.grouping().steps_of(self.scan.group).len();
        let begins_scan = self.scan.group.0 * parallel == self.scan.left_out;
        let mut points = self.running.end_group(&self.table, steps, begins_scan);
        let delay = self.delay();
        let mut add = |point: CoverPoint| points.extend(self.table.number(point));
        for (detector, seen) in DetectorIndex::all().zip(self.before_scan.iter_mut()) {
            if std::mem::take(seen) {
                add(CoverPoint::of(detector, HitPoint::BeforeScan));
            }
        }
        if self.interface.saturates() {
            let limit = 1i64 << (self.interface.count_bits() - 1);
            for (at, &count) in self.counts.iter().enumerate() {
                let detector = DetectorIndex(at / self.interface.parallel() as usize);
                let step = at % self.interface.parallel() as usize;
                if step < steps && (count == limit - 1 || count == -limit) {
                    let up = count > 0;
                    add(CoverPoint::of(detector, SaturationPoint::Limit { step, up }));
                }
            }
            for (detector, &total) in DetectorIndex::all().zip(self.totals.iter()) {
                if self.interface.total().is_some_and(|t| total == mask(t.bits)) {
                    let at_limit = SaturationPoint::OfTotal { beyond: false };
                    add(CoverPoint::of(detector, at_limit));
                }
            }
        }
        if self.totals.iter().any(|&total| total > 0) {
            let place = GroupPosition::of(self.scan.group.0, self.interface.groups());
            let later_scan = self.scan.scan > 0;
            add(ScanPoint::Result { place, later_scan }.into());
            if self.scan.chips == self.interface.timing.scan.integration_chips {
                add(ScanPoint::WholeStep.into());
            }
            if place == GroupPosition::Last && self.scan.left_out == 0 {
                add(ScanPoint::WholeScan.into());
            }
            let lanes = u64::from(self.interface.lanes());
            if let Some(previous) = self.scan.previous_delay {
                let period = previous > delay;
                if period || previous / lanes < delay / lanes {
                    add(ScanPoint::DelayWraps { period }.into());
                }
            }
        }
        if let Some(hosted) = &mut self.hosted {
            let limit = 1i128 << (self.interface.count_bits() - 1);
            let shown = |count: i64| i128::from(count).clamp(-limit, limit - 1) as i64;
            hosted.compare_beside(&self.counts, shown);
        }
        if let Some(hosted) =
            self.hosted.as_mut().filter(|_| self.totals.iter().any(|&total| total > 0))
        {
            let proven = hosted.take_proven(last);
            points.extend(proven.into_iter().filter_map(|point| self.table.number(point)));
        }
        points.append(&mut self.resets.of_results);
        points
    }
}

/// What was saturated in a group.
#[derive(Debug, Default)]
struct Clamps {
    counts: u32,
    totals: u32,
    absent: u32,
    /// The last of each kind: detector, step, whether beyond the largest count.
    count: (DetectorIndex, usize, bool),
    absent_count: (DetectorIndex, usize, bool),
    total: DetectorIndex,
}

impl Clamps {
    fn count(&mut self, is_absent: bool, is_clamped: bool, which: (DetectorIndex, usize, bool)) {
        if is_clamped && is_absent {
            self.absent += 1;
            self.absent_count = which;
        } else if is_clamped {
            self.counts += 1;
            self.count = which;
        }
    }

    /// The one thing that was saturated in a group, `last` of its scan or not, if there is only one.
    fn lone_points(&self, last: bool) -> [Option<CoverPoint>; 2] {
        match (self.counts, self.totals, self.absent) {
            (1, 0, _) => {
                let (detector, step, up) = self.count;
                let point = |point| CoverPoint::of(detector, point);
                let of_last = point(SaturationPoint::InLastGroup { step, up });
                [Some(point(SaturationPoint::Beyond { step, up })), last.then_some(of_last)]
            }
            (0, 0, 1) => {
                let (detector, step, up) = self.absent_count;
                [Some(CoverPoint::of(detector, SaturationPoint::Absent { step, up })), None]
            }
            (0, 1, 0) => {
                [Some(CoverPoint::of(self.total, SaturationPoint::OfTotal { beyond: true })), None]
            }
            _ => [None; 2],
        }
    }
}

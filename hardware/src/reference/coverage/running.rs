//! What the counters have gone through: which hits, which carries.

use super::cells::CellsSeen;
use super::{CarryPoint, CoverPoint, CoverTable, HitPoint};
use crate::scene::DetectorIndex;
use crate::sensor::cells::{CellChange, Cells};
use crate::sensor::interface::Interface;

/// The counters of all detectors, as far as cover points need them.
#[derive(Debug, Clone)]
pub(in crate::reference) struct Running {
    parallel: usize,
    /// Hits of a word that is full of them; a word with room for one is full of anything.
    full: u32,
    cells: Cells,
    /// Bits below each border between segments, the top of the counter included.
    borders: Vec<u32>,
    lowest: u32,
    /// Numbers of the points of a hit that each step of each detector counts down, and up, lane by lane: looked for
    /// once, as nearly every step of a scan has them all.
    hit_points: Vec<[Vec<Option<usize>>; 2]>,
    /// Of each step of each detector.
    steps: Vec<Counter>,
    /// Of each detector.
    detectors: Vec<Hits>,
}

/// One correlator.
#[derive(Debug, Clone, Copy, Default)]
struct Counter {
    /// Lanes with a hit that it counted down, and up, in the present step.
    lanes: [u64; 2],
    /// Sum of all hits since reset.
    total: i64,
    /// That at the end of the last step.
    base: i64,
    /// Borders that it has crossed downwards, and upwards, in the present step: bit n is
    /// border n.
    crossed: [u64; 2],
}

/// A hit as a correlator counts it.
#[derive(Debug, Clone, Copy)]
pub(in crate::reference) struct CountedHit {
    pub(in crate::reference) clock: u64,
    pub(in crate::reference) lane: u32,
    pub(in crate::reference) up: bool,
}

/// Hits of one clock that a correlator has counted.
#[derive(Debug, Clone, Copy, Default)]
struct Word {
    clock: u64,
    hits: u32,
    sum: i64,
}

/// All hits of a detector.
#[derive(Debug, Clone, Copy, Default)]
struct Hits {
    total: u64,
    base: u64,
    /// The present step had a word full of hits that count down, and up, in its first
    /// correlator.
    full: [bool; 2],
    first_sample: bool,
    last_sample: bool,
    /// What its cells have done in the present step.
    cells: CellsSeen,
}

impl Running {
    pub(in crate::reference) fn of(interface: &Interface, table: &CoverTable) -> Running {
        let borders = interface.correlator().into_iter().flat_map(|correlator| {
            let segments = correlator.count_segments;
            segments.borders().chain([segments.bits()])
        });
        // What no number of hits can reach is not a point of the table either.
        let borders: Vec<u32> = borders.filter(|&bit| bit < i64::BITS - 1).collect();
        let (detectors, parallel) =
            (interface.reference_codes.len(), interface.parallel() as usize);
        let hit_points = |detector: DetectorIndex, step: usize| {
            [false, true].map(|up| {
                let point = |lane| CoverPoint::of(detector, HitPoint::Hit { step, lane, up });
                (0..interface.lanes()).map(|lane| table.number(point(lane))).collect()
            })
        };
        Running {
            parallel,
            hit_points: DetectorIndex::of(&interface.reference_codes)
                .flat_map(|detector| (0..parallel).map(move |step| hit_points(detector, step)))
                .collect(),
            full: interface.correlator().map_or(0, |counts| counts.pairs).max(2),
            cells: interface.input_cells,
            lowest: borders.first().copied().unwrap_or(i64::BITS - 1),
            borders,
            steps: vec![Counter::default(); detectors * parallel],
            detectors: vec![Hits::default(); detectors],
        }
    }

    /// Forgets everything, as reset does.
    pub(in crate::reference) fn reset(&mut self) {
        self.steps.fill(Counter::default());
        self.detectors.fill(Hits::default());
    }

    /// Counts a detector's hits, in order, in the correlator of one step; gives the sum of
    /// their signs. The hits of a word come in one call.
    #[inline]
    pub(in crate::reference) fn count(
        &mut self,
        (detector, step): (DetectorIndex, usize),
        hits: impl Iterator<Item = CountedHit>,
    ) -> i64 {
        let counter = &mut self.steps[detector.0 * self.parallel + step];
        let seen = &mut self.detectors[detector];
        let full = if step == 0 { self.full } else { u32::MAX };
        let start = counter.total;
        // Beside the counter: what the loop needs stays in registers.
        let mut total = start;
        let mut lanes = [0; 2];
        let mut word = Word::default();
        let mut total_after = |word: Word, total: i64| {
            if word.hits == full {
                seen.full[0] |= word.sum == -i64::from(full);
                seen.full[1] |= word.sum == i64::from(full);
            }
            let after = total + word.sum;
            if total >> self.lowest != after >> self.lowest {
                counter.crosses(total, after, &self.borders);
            }
            after
        };
        for hit in hits {
            if hit.clock != word.clock {
                total = total_after(word, total);
                word = Word { clock: hit.clock, ..Word::default() };
            }
            // The sign is anything: no branch foresees it.
            let up = i64::from(hit.up);
            word.hits += 1;
            word.sum += 2 * up - 1;
            lanes[0] |= ((1 - up) as u64) << hit.lane;
            lanes[1] |= (up as u64) << hit.lane;
        }
        counter.total = total_after(word, total);
        counter.lanes[0] |= lanes[0];
        counter.lanes[1] |= lanes[1];
        counter.total - start
    }

    /// So many hits of a detector have been counted, in all its correlators.
    pub(in crate::reference) fn counted(&mut self, detector: DetectorIndex, hits: u64) {
        self.detectors[detector].total += hits;
    }

    /// What a detector's cells do in the present step.
    pub(in crate::reference) fn cells(&mut self, detector: DetectorIndex, changes: &[CellChange]) {
        let seen = &mut self.detectors[detector].cells;
        changes.iter().for_each(|change| seen.add(&self.cells, change));
    }

    /// Hits on the first and on the last sample of a step.
    pub(in crate::reference) fn border(
        &mut self,
        detector: DetectorIndex,
        first: bool,
        last: bool,
    ) {
        self.detectors[detector].first_sample |= first;
        self.detectors[detector].last_sample |= last;
    }

    /// The present group ends, with so many steps: numbers of the points that its results
    /// prove. `begins_scan` if it is a scan's first.
    pub(in crate::reference) fn end_group(
        &mut self,
        table: &CoverTable,
        steps: usize,
        begins_scan: bool,
    ) -> Vec<usize> {
        // Nearly every step has the points of all lanes.
        let of_lanes = self.hit_points.iter().flatten().map(Vec::len).sum();
        let mut points = Vec::with_capacity(of_lanes);
        let parallel = self.parallel;
        for (at, counter) in self.steps.iter().enumerate() {
            if at % parallel < steps {
                points.extend(counter.hit_points(&self.hit_points[at]));
            }
        }
        let mut add = |point: CoverPoint| points.extend(table.number(point));
        for (detector, seen) in DetectorIndex::all().zip(self.detectors.iter_mut()) {
            for up in [false, true] {
                if std::mem::take(&mut seen.full[usize::from(up)]) {
                    add(CoverPoint::of(detector, HitPoint::FullWord { up }));
                }
            }
            if std::mem::take(&mut seen.first_sample) {
                let first = true;
                add(match begins_scan {
                    true => CoverPoint::of(detector, HitPoint::FirstSample),
                    false => CoverPoint::of(detector, HitPoint::StepBorder { first }),
                });
            }
            if std::mem::take(&mut seen.last_sample) {
                let first = false;
                add(CoverPoint::of(detector, HitPoint::StepBorder { first }));
            }
            for point in std::mem::take(&mut seen.cells).points() {
                add(CoverPoint::of(detector, point));
            }
            for &bit in &self.borders {
                let low = |number: u64| number & ((1 << bit) - 1);
                let carries = seen.total >> bit != seen.base >> bit;
                let borrows = low(seen.total) < low(seen.base);
                for (borrow, is_seen) in [(false, carries), (true, borrows)] {
                    if is_seen {
                        add(CoverPoint::of(detector, CarryPoint::OfTotal { bit, borrow }));
                    }
                }
            }
            seen.base = seen.total;
            let counters = &mut self.steps[detector.0 * parallel..][..parallel];
            for (step, counter) in counters.iter_mut().enumerate() {
                if step < steps {
                    counter.end(detector, step, &self.borders, &mut add);
                }
                counter.lanes = [0; 2];
                counter.crossed = [0; 2];
                counter.base = counter.total;
            }
        }
        points
    }
}

impl Counter {
    /// Notes the borders between two totals.
    #[cold]
    fn crosses(&mut self, before: i64, after: i64, borders: &[u32]) {
        let up = usize::from(after > before);
        for (number, border) in borders.iter().enumerate() {
            let crosses = before >> border != after >> border;
            self.crossed[up] |= u64::from(crosses) << number;
        }
    }

    /// Numbers of the points of its hits, of those of each lane.
    fn hit_points<'p>(
        &self,
        [down, up]: &'p [Vec<Option<usize>>; 2],
    ) -> impl Iterator<Item = usize> + 'p {
        let seen = |points: &'p [Option<usize>], lanes: u64| {
            let lanes = points.iter().enumerate().filter(move |(lane, _)| lanes >> lane & 1 == 1);
            lanes.filter_map(|(_, number)| *number)
        };
        seen(down, self.lanes[0]).chain(seen(up, self.lanes[1]))
    }

    fn end(
        &self,
        detector: DetectorIndex,
        step: usize,
        borders: &[u32],
        add: &mut impl FnMut(CoverPoint),
    ) {
        for up in [false, true] {
            for (number, &bit) in borders.iter().enumerate() {
                if self.crossed[usize::from(up)] >> number & 1 == 1 {
                    add(CoverPoint::of(detector, CarryPoint::Carry { step, bit, up }));
                }
            }
        }
        for &bit in borders {
            let low = |number: i64| number.rem_euclid(1 << bit);
            if low(self.total) < low(self.base) {
                add(CoverPoint::of(detector, CarryPoint::Borrow { step, bit }));
            }
        }
    }
}

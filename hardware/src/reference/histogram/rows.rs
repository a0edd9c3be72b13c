//! A frame's rows on their way to the stream: when each shows, which are lost.

use std::collections::VecDeque;

use super::{Ended, HistogramModel};
use crate::reference::coverage::{BinPoint, CoverPoint, Place, StreamPoint};
use crate::reference::exercise::{Counted, Exercised};
use crate::scene::DetectorIndex;
use crate::sensor::histogram::CLOCKS_TO_ROW;

/// One transfer.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Row {
    pub(super) data: u128,
    pub(super) counted: Counted,
}

/// A row that leaves a single memory.
#[derive(Debug, Clone)]
pub(super) struct Arrival {
    /// Clock after whose rising edge it shows, if nothing waits.
    pub(super) clock: u64,
    pub(super) row: Row,
    /// Its number in the frame.
    pub(super) beat: usize,
    pub(super) is_last: bool,
    /// Cover points that the frame proves, with its last row.
    pub(super) proves: Vec<usize>,
}

/// The stream's registers.
#[derive(Debug, Clone, Default)]
pub(super) struct Stream {
    pub(super) row: Row,
    pub(super) is_valid: bool,
    pub(super) is_last: bool,
    pub(super) is_overrun: bool,
    pub(super) is_saturated: bool,
    /// Clock after whose rising edge the first row of the frame that is read shows.
    pub(super) first_shows: Option<u64>,
    pub(super) waiting: VecDeque<Row>,
    /// Those that leave a single memory, one a clock.
    pub(super) arrivals: VecDeque<Arrival>,
    /// Rows of the present frame are lost.
    pub(super) is_cut: bool,
    pub(super) proves: Vec<usize>,
    /// Number of the row that shows, since when, and whether it was left standing.
    pub(super) beat: usize,
    pub(super) shown_at: u64,
    pub(super) first_shown_at: u64,
    pub(super) is_held: bool,
    /// Rows that stood while a frame was lost, and when that was last.
    pub(super) across: Vec<usize>,
    pub(super) lost_at: Option<u64>,
    /// The frame before was lost, or one of its rows.
    pub(super) follows_lost: bool,
    /// The same of the frame before the one that shows, of a single memory.
    pub(super) is_after_lost: bool,
}

impl HistogramModel {
    /// A bin was full; the flag rises at `clock`, if it has not.
    pub(super) fn raise_flag(&mut self, clock: u64, exercise: &mut Exercised) {
        let mut alone = None;
        let mut count = 0;
        while let Some((_, detector, adder)) = self.flags.pop_front_if(|flag| flag.0 == clock) {
            alone = Some((detector, adder));
            count += 1;
        }
        if let Some((detector, adder)) = alone.filter(|_| count == 1 && !self.stream.is_saturated) {
            self.mark(CoverPoint::of(detector, BinPoint::Clamped { adder }), exercise);
        }
        self.stream.is_saturated = true;
    }

    /// Nobody took the row that shows before `clock`.
    pub(super) fn stands_until(&mut self, clock: u64, exercise: &mut Exercised) {
        let stream = &mut self.stream;
        if stream.is_valid && stream.shown_at + 1 < clock && !stream.is_held {
            stream.is_held = true;
            exercise.stalls += 1;
        }
    }

    /// The receiver takes a row at the rising edge of `clock`.
    pub(super) fn take(&mut self, clock: u64, exercise: &mut Exercised) {
        self.stands_until(clock, exercise);
        exercise.results_taken += 1;
        let beat = self.stream.beat;
        if self.stream.is_held {
            self.mark(StreamPoint::Held { beat }, exercise);
        }
        if self.stream.is_last {
            self.end_reading(clock, exercise);
        }
        if self.plan.takes_turns() {
            self.stream.beat += 1;
            self.show_next(clock, exercise);
        } else {
            self.stream.is_valid = false;
        }
    }

    /// A row leaves the single memory: it shows, or is lost if another still waits.
    pub(super) fn come(&mut self, arrival: Arrival, took: bool, exercise: &mut Exercised) {
        let stream = &mut self.stream;
        if arrival.beat == 0 {
            stream.is_cut = false;
            stream.is_after_lost = std::mem::take(&mut stream.follows_lost);
        }
        if stream.is_valid {
            let is_first = !std::mem::replace(&mut stream.is_overrun, true);
            stream.follows_lost = true;
            stream.lost_at = Some(arrival.clock);
            if stream.is_last {
                stream.across = vec![stream.beat];
            }
            if !std::mem::replace(&mut stream.is_cut, true) {
                exercise.overruns += 1;
                let place = Place::Last;
                self.mark(StreamPoint::Lost { place }, exercise);
            }
            if is_first {
                self.mark(StreamPoint::FirstLost { beat: arrival.beat }, exercise);
            }
            return;
        }
        stream.row = arrival.row;
        stream.is_valid = true;
        stream.is_last = arrival.is_last;
        stream.beat = arrival.beat;
        (stream.shown_at, stream.is_held) = (arrival.clock, false);
        if arrival.beat == 0 {
            stream.first_shown_at = arrival.clock;
        }
        let is_whole = arrival.is_last && !stream.is_cut;
        let is_after_lost = stream.is_after_lost;
        exercise.shows(arrival.row.counted, arrival.is_last);
        if took && arrival.beat == 0 {
            self.mark(StreamPoint::BackToBack, exercise);
        }
        if is_whole {
            for point in arrival.proves {
                exercise.covered.mark(point);
            }
            if is_after_lost {
                self.mark(StreamPoint::AfterLost, exercise);
            }
        }
    }

    /// The last row of a frame is taken.
    fn end_reading(&mut self, clock: u64, exercise: &mut Exercised) {
        let last = self.stream.beat;
        for beat in std::mem::take(&mut self.stream.across) {
            self.mark(StreamPoint::HeldAcross { beat }, exercise);
            if beat == last {
                self.mark(StreamPoint::LastHeldAcross, exercise);
            }
        }
        if self.stream.lost_at.take().is_some_and(|lost| lost + 1 == clock) {
            self.mark(StreamPoint::TooLate, exercise);
        }
        if self.stream.first_shown_at + last as u64 + 1 == clock && !self.stream.is_cut {
            self.mark(StreamPoint::Burst, exercise);
        }
    }

    /// The next row, if there is one, comes to the stream at the rising edge of `clock`.
    pub(super) fn show_next(&mut self, clock: u64, exercise: &mut Exercised) {
        let stream = &mut self.stream;
        let Some(row) = stream.waiting.pop_front() else {
            stream.is_valid = false;
            return;
        };
        stream.row = row;
        stream.is_valid = true;
        stream.is_last = stream.waiting.is_empty();
        (stream.shown_at, stream.is_held) = (clock, false);
        exercise.shows(row.counted, stream.is_last);
        if stream.is_last {
            for point in stream.proves.drain(..) {
                exercise.covered.mark(point);
            }
        }
    }

    /// A frame's turn: it is read if nothing of the one before is left, or lost. Out of a
    /// single memory its rows leave in any case.
    pub(super) fn turn(
        &mut self,
        mut ended: Ended,
        clock: u64,
        took: bool,
        exercise: &mut Exercised,
    ) {
        let is_busy = self.stream.is_valid || self.stream.first_shows.is_some();
        self.find_emptied(&mut ended);
        self.find_tops(&mut ended);
        self.memories[self.half] = Some(ended.bins.clone());
        if !self.plan.takes_turns() {
            return self.send(ended, clock);
        }
        if is_busy {
            let stream = &mut self.stream;
            let first_lost_at = match std::mem::replace(&mut stream.is_overrun, true) {
                false => stream.is_valid.then_some(stream.beat),
                true => None,
            };
            stream.follows_lost = true;
            if stream.across.last() != Some(&stream.beat) {
                stream.across.push(stream.beat);
            }
            stream.lost_at = Some(clock);
            exercise.overruns += 1;
            let place = Place::Last;
            self.mark(StreamPoint::Lost { place }, exercise);
            if let Some(beat) = first_lost_at {
                self.mark(StreamPoint::FirstLost { beat }, exercise);
            }
            return;
        }
        if took && ended.is_later {
            self.mark(StreamPoint::BackToBack, exercise);
        }
        self.half ^= 1;
        let rows = self.rows(&ended.bins);
        let stream = &mut self.stream;
        stream.waiting = rows;
        stream.first_shows = Some(clock + u64::from(CLOCKS_TO_ROW));
        stream.beat = 0;
        stream.proves = ended.proves;
        if std::mem::take(&mut stream.follows_lost) {
            let point = self.table.number(StreamPoint::AfterLost);
            self.stream.proves.extend(point);
        }
    }

    /// The rows of a frame leave, one a clock.
    fn send(&mut self, ended: Ended, clock: u64) {
        let rows = self.rows(&ended.bins);
        let (last, mut proves) = (rows.len() - 1, ended.proves);
        let first_clock = clock + u64::from(CLOCKS_TO_ROW);
        let arrivals = rows.into_iter().enumerate().map(|(beat, row)| Arrival {
            clock: first_clock + beat as u64,
            row,
            beat,
            is_last: beat == last,
            proves: match beat == last {
                true => std::mem::take(&mut proves),
                false => Vec::new(),
            },
        });
        self.stream.arrivals.extend(arrivals);
    }

    /// A frame's rows, detector by detector.
    fn rows(&self, bins: &[Vec<u64>]) -> VecDeque<Row> {
        let stride = self.plan.bin_data_bits();
        let row = |detector: DetectorIndex, chip: u8, bins: &[u64]| {
            let (mut data, mut total) = (0u128, 0u64);
            for (&bin, shift) in bins.iter().zip((0..).step_by(stride as usize)) {
                data |= u128::from(bin) << shift;
                total += bin;
            }
            let sum = match chip {
                0 => -total.cast_signed(),
                _ => total.cast_signed(),
            };
            Row { data, counted: Counted::new(detector, sum, total) }
        };
        let detectors = DetectorIndex::all().zip(bins.iter().zip(&self.chips));
        detectors
            .flat_map(|(detector, (bins, chips))| {
                bins.chunks_exact(self.plan.row_bins as usize)
                    .zip(chips)
                    .map(move |(bins, &chip)| row(detector, chip, bins))
            })
            .collect()
    }
}

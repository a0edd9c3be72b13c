//! A frame's rows on their way to the stream: when each shows, which are lost.

use std::collections::VecDeque;

use super::{Ended, HistogramModel};
use crate::reference::axis::{AxiStream, Beat};
use crate::reference::coverage::{BinPoint, CoverPoint, GroupPosition, StreamPoint};
use crate::reference::exercise::CountedHits;
use crate::scene::DetectorIndex;
use crate::sensor::histogram::{CLOCKS_TO_FLAG, CLOCKS_TO_ROW, CLOCKS_TO_TURN};

/// A row that leaves a single memory.
#[derive(Debug, Clone)]
pub(super) struct RowArrival {
    /// Clock after whose rising edge it shows, if nothing waits.
    pub(super) clock: u64,
    pub(super) row: Beat,
    /// Its number in the frame.
    pub(super) beat: usize,
    pub(super) is_last: bool,
    /// Cover points that the frame proves, with its last row.
    pub(super) proves: Vec<usize>,
}

/// A frame that is read out of the memory which does not count.
#[derive(Debug, Clone)]
pub(super) struct FrameReading {
    /// Clock after whose rising edge its first row shows.
    pub(super) clock: u64,
    pub(super) rows: VecDeque<Beat>,
    /// Cover points that it proves.
    pub(super) proves: Vec<usize>,
}

/// What is on its way to the stream.
#[derive(Debug, Clone, Default)]
pub(super) struct Reader {
    pub(super) reading: Option<FrameReading>,
    /// Rows that leave a single memory, one a clock.
    pub(super) arrivals: VecDeque<RowArrival>,
    /// The frame before was lost, or one of its rows.
    follows_lost: bool,
    /// The same of the frame before the one that shows, of a single memory.
    is_after_lost: bool,
}

impl HistogramModel {
    /// A bin was full; the flag rises at `clock`, if it has not.
    pub(super) fn raise_flag(&mut self, clock: u64, axis: &mut AxiStream) {
        let mut alone = None;
        let mut count = 0;
        while let Some((_, detector, lane)) = self.flags.pop_front_if(|flag| flag.0 == clock) {
            alone = Some((detector, lane));
            count += 1;
        }
        if let Some((detector, lane)) = alone.filter(|_| count == 1 && !axis.now.is_saturated) {
            let adder = lane / self.plan.adder_samples;
            axis.mark(CoverPoint::of(detector, BinPoint::Clamped { adder }));
            if let Some((end, memory)) = self.last_end
                && let Some(age) = (end + u64::from(CLOCKS_TO_FLAG)).checked_sub(clock)
            {
                let age = age as u32;
                axis.mark(CoverPoint::of(detector, BinPoint::ClampedAtEnd { age, memory }));
            }
        }
        axis.now.is_saturated = true;
    }

    /// A row leaves the single memory: it shows, or is lost if another still waits.
    pub(super) fn come(&mut self, arrival: RowArrival, took: bool, axis: &mut AxiStream) {
        let RowArrival { clock, row, beat, is_last, proves } = arrival;
        if beat == 0 {
            axis.now.group.is_cut = false;
            self.reader.is_after_lost = std::mem::take(&mut self.reader.follows_lost);
        }
        if axis.now.is_valid {
            let is_first = axis.overruns(clock);
            self.reader.follows_lost = true;
            if axis.now.is_last {
                axis.stands_across();
            }
            if !std::mem::replace(&mut axis.now.group.is_cut, true) {
                axis.exercise.overruns += 1;
                axis.mark(StreamPoint::Lost { place: GroupPosition::Last });
            }
            if is_first {
                axis.mark(StreamPoint::FirstLost { beat });
            }
            return;
        }
        axis.now.group.beat = beat;
        if beat == 0 {
            axis.now.group.shown_at = clock;
        }
        axis.show(row, (is_last, is_last), clock);
        if took && beat == 0 {
            axis.mark(StreamPoint::BackToBack);
        }
        if is_last && !axis.now.group.is_cut {
            for point in proves {
                axis.exercise.covered.mark(point);
            }
            if self.reader.is_after_lost {
                axis.mark(StreamPoint::AfterLost);
            }
        }
    }

    /// A frame's turn: it is read if nothing of the one before is left, or lost. Out of a
    /// single memory its rows leave in any case.
    pub(super) fn turn(&mut self, mut ended: Ended, clock: u64, took: bool, axis: &mut AxiStream) {
        let is_busy = axis.now.is_valid || self.reader.reading.is_some();
        self.last_end = Some((clock - u64::from(CLOCKS_TO_TURN), self.half));
        self.find_emptied(&mut ended);
        self.find_tops(&mut ended);
        self.memories[self.half] = Some(ended.bins.clone());
        if !self.plan.takes_turns() {
            return self.send(ended, clock);
        }
        if is_busy {
            let standing = axis.now.is_valid.then_some(axis.now.group.beat);
            let is_first = axis.overruns(clock);
            self.reader.follows_lost = true;
            axis.stands_across();
            axis.exercise.overruns += 1;
            axis.mark(StreamPoint::Lost { place: GroupPosition::Last });
            if took {
                axis.mark(StreamPoint::LostAsTaken);
            }
            if let Some(beat) = standing.filter(|_| is_first) {
                axis.mark(StreamPoint::FirstLost { beat });
            }
            return;
        }
        if took && ended.is_later {
            axis.mark(StreamPoint::BackToBack);
        }
        self.half ^= 1;
        let mut proves = ended.proves;
        if std::mem::take(&mut self.reader.follows_lost) {
            proves.extend(self.table.number(StreamPoint::AfterLost));
        }
        let clock = clock + u64::from(CLOCKS_TO_ROW);
        self.reader.reading = Some(FrameReading { clock, rows: self.rows(&ended.bins), proves });
    }

    /// The rows of a frame leave, one a clock.
    fn send(&mut self, ended: Ended, clock: u64) {
        let rows = self.rows(&ended.bins);
        let (last, mut proves) = (rows.len() - 1, ended.proves);
        let first_clock = clock + u64::from(CLOCKS_TO_ROW);
        let arrivals = rows.into_iter().enumerate().map(|(beat, row)| RowArrival {
            clock: first_clock + beat as u64,
            row,
            beat,
            is_last: beat == last,
            proves: match beat == last {
                true => std::mem::take(&mut proves),
                false => Vec::new(),
            },
        });
        self.reader.arrivals.extend(arrivals);
    }

    /// A frame's rows, detector by detector.
    fn rows(&self, bins: &[Vec<u64>]) -> VecDeque<Beat> {
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
            Beat { data, counted: CountedHits::new(detector, sum, total) }
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

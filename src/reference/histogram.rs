//! The reference model of a sensor that keeps histograms: what its bins count, when
//! their rows show, which frames are lost.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::bin_points::{BinPoints, Proofs};
use super::canvas::Canvas;
use super::coverage::{BinPoint, CoverPoint, CoverTable, Place};
use super::exercise::{Counted, Exercise};
use super::resets::{PortState, ResetWatch};
use super::stream::Ready;
use crate::scene::DetectorIndex;
use crate::sensor::histogram::{CLOCKS_TO_FLAG, CLOCKS_TO_ROW, CLOCKS_TO_TURN, HistogramPlan};
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Layout, mask};

/// Bins, and the stream of their rows.
#[derive(Debug, Clone)]
pub(super) struct HistogramModel {
    plan: HistogramPlan,
    /// Chips of each detector's reference.
    chips: Vec<Vec<u8>>,
    fields: Fields,
    table: Arc<CoverTable>,
    /// Bins of the present frame, detector by detector.
    bins: Vec<Vec<u64>>,
    /// Cover points that it proves when all of it has shown.
    proves: Proofs,
    /// Those of each detector's bins.
    points: Vec<BinPoints>,
    was_clamped: bool,
    /// Clocks after whose rising edge a bin's flag comes, with detector and adder.
    flags: VecDeque<(u64, DetectorIndex, u32)>,
    /// Frames that have ended and await their turn.
    ended: VecDeque<Ended>,
    stream: Stream,
    /// What the two memories held last, and which of them counts.
    memories: [Option<Vec<Vec<u64>>>; 2],
    half: usize,
}

/// A frame whose last word has been presented.
#[derive(Debug, Clone)]
struct Ended {
    /// Clock at whose rising edge the memories change places.
    turn: u64,
    is_later: bool,
    bins: Vec<Vec<u64>>,
    proves: Vec<usize>,
}

/// Places of the ports; each is (word, shift).
#[derive(Debug, Clone, Copy)]
struct Fields {
    data: (usize, u32),
    tvalid: (usize, u32),
    tlast: (usize, u32),
    overrun: (usize, u32),
    saturated: Option<(usize, u32)>,
}

/// One transfer.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    data: u128,
    counted: Counted,
}

/// A row that leaves a single memory.
#[derive(Debug, Clone)]
struct Arrival {
    /// Clock after whose rising edge it shows, if nothing waits.
    clock: u64,
    row: Row,
    /// Its number in the frame.
    beat: usize,
    is_last: bool,
    /// Cover points that the frame proves, with its last row.
    proves: Vec<usize>,
}

/// The stream's registers.
#[derive(Debug, Clone, Default)]
struct Stream {
    row: Row,
    is_valid: bool,
    is_last: bool,
    is_overrun: bool,
    is_saturated: bool,
    /// Clock after whose rising edge the first row of the frame that is read shows.
    first_shows: Option<u64>,
    waiting: VecDeque<Row>,
    /// Those that leave a single memory, one a clock.
    arrivals: VecDeque<Arrival>,
    /// Rows of the present frame are lost.
    is_cut: bool,
    proves: Vec<usize>,
    /// Number of the row that shows, since when, and whether it was left standing.
    beat: usize,
    shown_at: u64,
    first_shown_at: u64,
    is_held: bool,
    /// Rows that stood while a frame was lost, and when that was last.
    across: Vec<usize>,
    lost_at: Option<u64>,
    /// The frame before was lost, or one of its rows.
    follows_lost: bool,
    /// The same of the frame before the one that shows, of a single memory.
    is_after_lost: bool,
}

impl HistogramModel {
    pub(super) fn new(
        interface: &Interface,
        layout: &Layout,
        table: Arc<CoverTable>,
    ) -> Option<HistogramModel> {
        let plan = interface.histogram?;
        let place = |name| {
            let field = layout.outputs.field(name);
            (field.word, field.shift)
        };
        let detectors = interface.reference_codes.len();
        let codes = interface.reference_codes.iter();
        let points = DetectorIndex::first(detectors);
        Some(HistogramModel {
            plan,
            points: points
                .map(|detector| BinPoints::new(&plan, &table, detector))
                .collect(),
            chips: codes.map(|code| code.chips.clone()).collect(),
            fields: Fields {
                data: place("m_axis_tdata"),
                tvalid: place("m_axis_tvalid"),
                tlast: place("m_axis_tlast"),
                overrun: place("o_overrun"),
                saturated: interface.saturates().then(|| place("o_saturated")),
            },
            table,
            bins: vec![vec![0; plan.bins() as usize]; detectors],
            proves: Proofs::default(),
            was_clamped: false,
            flags: VecDeque::new(),
            ended: VecDeque::new(),
            stream: Stream::default(),
            memories: [None, None],
            half: 0,
        })
    }

    /// What the ports show.
    pub(super) fn state(&self) -> PortState {
        PortState {
            is_waiting: self.stream.is_valid,
            is_overrun: self.stream.is_overrun,
            is_saturated: self.stream.is_saturated,
        }
    }

    /// Reset. What the memories hold stays and is of no consequence, so it is followed no
    /// further.
    pub(super) fn reset(&mut self) {
        self.bins.iter_mut().for_each(|bins| bins.fill(0));
        self.proves.take();
        self.was_clamped = false;
        self.flags.clear();
        self.ended.clear();
        self.stream = Stream::default();
        self.memories = [None, None];
        self.half = 0;
    }

    /// Whether a hit has been counted in the present frame.
    pub(super) fn has_counted(&self) -> bool {
        self.bins.iter().flatten().any(|&bin| bin > 0)
    }

    /// Counts a detector's hits in words of the present frame, whose first sample is
    /// `frame_start`; `first_sample` is that of a code period.
    pub(super) fn count(
        &mut self,
        detector: DetectorIndex,
        hits: &[u64],
        (first_sample, frame_start): (u64, u64),
        resets: &mut ResetWatch,
    ) {
        let lanes = u64::from(self.plan.row_bins);
        let lanes_log2 = lanes.ilog2();
        let (period, width) = (self.plan.bins(), u64::from(self.plan.adder_samples));
        let frame_samples = period * self.plan.periods;
        let limit = mask(self.plan.bin_bits);
        for word in hits.chunk_by(|a, b| a >> lanes_log2 == b >> lanes_log2) {
            let clock = word[0] >> lanes_log2;
            resets.hits_in(clock);
            let mut adders = 0;
            for at_adder in word.chunk_by(|a, b| a % lanes / width == b % lanes / width) {
                // Of several the earliest counts.
                let sample = at_adder[0];
                let adder = (sample % lanes / width) as u32;
                adders += 1;
                let points = &self.points[detector.0];
                if at_adder.len() > 1 {
                    self.proves.add(points.extra[adder as usize]);
                }
                let bin = ((sample - first_sample) % period) as usize;
                let lane = (sample % lanes) as u32;
                let count = self.bins[detector][bin];
                if count == limit {
                    self.was_clamped = true;
                    self.flags
                        .push_back((clock + u64::from(CLOCKS_TO_FLAG), detector, adder));
                    continue;
                }
                self.bins[detector][bin] += 1;
                let later = sample - frame_start >= period;
                self.proves
                    .add(points.hit[lane as usize][usize::from(later)]);
                if (count + 1).is_power_of_two() {
                    let bit = (count + 1).ilog2();
                    self.proves.add(points.carry[adder as usize][bit as usize]);
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
    pub(super) fn end_frame(
        &mut self,
        clock: u64,
        scan: u64,
        resets: &mut ResetWatch,
        exercise: &mut Exercise,
    ) {
        resets.group_ends(clock, true, self.has_counted());
        exercise.phase_steps += self.plan.bins();
        exercise.groups_saturated += u64::from(std::mem::take(&mut self.was_clamped));
        let bins: Vec<Vec<u64>> = self
            .bins
            .iter_mut()
            .map(|bins| std::mem::replace(bins, vec![0; bins.len()]))
            .collect();
        if self.plan.saturates() {
            self.find_full(&bins);
        }
        let mut proves = self.proves.take();
        let is_later = scan > 0;
        let place = Place::Last;
        proves.extend(self.table.number(CoverPoint::Result {
            place,
            later_scan: is_later,
        }));
        proves.append(&mut resets.of_results);
        self.ended.push_back(Ended {
            turn: clock + u64::from(CLOCKS_TO_TURN),
            is_later,
            bins,
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

    /// ORs the stream's ports into the records of a stretch of clocks without reset.
    pub(super) fn predict(
        &mut self,
        clocks: Range<u64>,
        stalls: &[Range<u64>],
        expected: &mut impl Canvas,
        exercise: &mut Exercise,
    ) {
        // Detectors have told theirs one after the other.
        self.flags.make_contiguous().sort_by_key(|flag| flag.0);
        let mut ready = Ready::new(stalls);
        let (mut filled, mut next) = (clocks.start, clocks.start);
        while next < clocks.end {
            let taken = match self.stream.is_valid {
                true => ready.first_from(next),
                false => u64::MAX,
            };
            let turn = self.ended.front().map_or(u64::MAX, |ended| ended.turn);
            let flag = self.flags.front().map_or(u64::MAX, |flag| flag.0);
            let shows = self.stream.first_shows.unwrap_or(u64::MAX);
            let comes = self
                .stream
                .arrivals
                .front()
                .map_or(u64::MAX, |row| row.clock);
            let event = taken.min(turn).min(flag).min(shows).min(comes);
            if event >= clocks.end {
                break;
            }
            self.fill(filled..event, expected);
            (filled, next) = (event, event + 1);
            if flag == event {
                self.raise_flag(event, exercise);
            }
            if shows == event {
                self.stream.first_shows = None;
                self.show_next(event, exercise);
                self.stream.first_shown_at = event;
            } else if taken == event {
                self.take(event, exercise);
            }
            if comes == event
                && let Some(row) = self.stream.arrivals.pop_front()
            {
                self.come(row, taken == event, exercise);
            }
            if turn == event
                && let Some(ended) = self.ended.pop_front()
            {
                self.turn(ended, event, taken == event, exercise);
            }
        }
        self.stands_until(clocks.end, exercise);
        self.fill(filled..clocks.end, expected);
    }

    fn mark(&self, point: CoverPoint, exercise: &mut Exercise) {
        if let Some(number) = self.table.number(point) {
            exercise.covered.mark(number);
        }
    }

    /// A bin was full; the flag rises at `clock`, if it has not.
    fn raise_flag(&mut self, clock: u64, exercise: &mut Exercise) {
        let mut alone = None;
        let mut count = 0;
        while let Some((_, detector, adder)) = self.flags.pop_front_if(|flag| flag.0 == clock) {
            alone = Some((detector, adder));
            count += 1;
        }
        if let Some((detector, adder)) = alone.filter(|_| count == 1 && !self.stream.is_saturated) {
            let point = BinPoint::Clamped { adder };
            self.mark(CoverPoint::Bin { detector, point }, exercise);
        }
        self.stream.is_saturated = true;
    }

    /// Nobody took the row that shows before `clock`.
    fn stands_until(&mut self, clock: u64, exercise: &mut Exercise) {
        let stream = &mut self.stream;
        if stream.is_valid && stream.shown_at + 1 < clock && !stream.is_held {
            stream.is_held = true;
            exercise.results_held += 1;
        }
    }

    /// The receiver takes a row at the rising edge of `clock`.
    fn take(&mut self, clock: u64, exercise: &mut Exercise) {
        self.stands_until(clock, exercise);
        exercise.results_taken += 1;
        let beat = self.stream.beat;
        if self.stream.is_held {
            self.mark(CoverPoint::Held { beat }, exercise);
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
    fn come(&mut self, arrival: Arrival, took: bool, exercise: &mut Exercise) {
        let stream = &mut self.stream;
        if arrival.beat == 0 {
            stream.is_cut = false;
            stream.is_after_lost = std::mem::take(&mut stream.follows_lost);
        }
        if stream.is_valid {
            stream.is_overrun = true;
            stream.follows_lost = true;
            stream.lost_at = Some(arrival.clock);
            if stream.is_last {
                stream.across = vec![stream.beat];
            }
            if !std::mem::replace(&mut stream.is_cut, true) {
                exercise.groups_lost += 1;
                let place = Place::Last;
                self.mark(CoverPoint::Lost { place }, exercise);
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
            self.mark(CoverPoint::BackToBack, exercise);
        }
        if is_whole {
            for point in arrival.proves {
                exercise.covered.mark(point);
            }
            if is_after_lost {
                self.mark(CoverPoint::AfterLost, exercise);
            }
        }
    }

    /// The last row of a frame is taken.
    fn end_reading(&mut self, clock: u64, exercise: &mut Exercise) {
        let last = self.stream.beat;
        for beat in std::mem::take(&mut self.stream.across) {
            self.mark(CoverPoint::HeldAcross { beat }, exercise);
            if beat == last {
                self.mark(CoverPoint::LastHeldAcross, exercise);
            }
        }
        if self
            .stream
            .lost_at
            .take()
            .is_some_and(|lost| lost + 1 == clock)
        {
            self.mark(CoverPoint::TooLate, exercise);
        }
        if self.stream.first_shown_at + last as u64 + 1 == clock && !self.stream.is_cut {
            self.mark(CoverPoint::Burst, exercise);
        }
    }

    /// The next row, if there is one, comes to the stream at the rising edge of `clock`.
    fn show_next(&mut self, clock: u64, exercise: &mut Exercise) {
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
    fn turn(&mut self, mut ended: Ended, clock: u64, took: bool, exercise: &mut Exercise) {
        let is_busy = self.stream.is_valid || self.stream.first_shows.is_some();
        self.find_emptied(&mut ended);
        self.memories[self.half] = Some(ended.bins.clone());
        if !self.plan.takes_turns() {
            return self.send(ended, clock);
        }
        if is_busy {
            let stream = &mut self.stream;
            stream.is_overrun = true;
            stream.follows_lost = true;
            if stream.across.last() != Some(&stream.beat) {
                stream.across.push(stream.beat);
            }
            stream.lost_at = Some(clock);
            exercise.groups_lost += 1;
            let place = Place::Last;
            self.mark(CoverPoint::Lost { place }, exercise);
            return;
        }
        if took && ended.is_later {
            self.mark(CoverPoint::BackToBack, exercise);
        }
        self.half ^= 1;
        let rows = self.rows(&ended.bins);
        let stream = &mut self.stream;
        stream.waiting = rows;
        stream.first_shows = Some(clock + u64::from(CLOCKS_TO_ROW));
        stream.beat = 0;
        stream.proves = ended.proves;
        if std::mem::take(&mut stream.follows_lost) {
            let point = self.table.number(CoverPoint::AfterLost);
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

    /// Lanes with a bin that this frame has no hit in, and that its memory had counts in.
    fn find_emptied(&self, ended: &mut Ended) {
        let Some(before) = &self.memories[self.half] else {
            return;
        };
        let lanes = self.plan.row_bins as usize;
        for (detector, (before, bins)) in DetectorIndex::all().zip(before.iter().zip(&ended.bins)) {
            for lane in 0..lanes {
                let mut pairs = before.iter().zip(bins).skip(lane).step_by(lanes);
                if pairs.any(|(&before, &now)| before > 0 && now == 0) {
                    let lane = lane as u32;
                    let point = BinPoint::Emptied { lane };
                    let point = CoverPoint::Bin { detector, point };
                    ended.proves.extend(self.table.number(point));
                }
            }
        }
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
            Row {
                data,
                counted: Counted::new(detector, sum, total),
            }
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

    /// ORs the ports' present values into a range of clocks.
    fn fill(&self, clocks: Range<u64>, expected: &mut impl Canvas) {
        let (stream, fields) = (&self.stream, &self.fields);
        let mut or = |(word, shift): (usize, u32), value: u64| {
            if value != 0 && !clocks.is_empty() {
                expected.or(clocks.clone(), word, value << shift);
            }
        };
        // A port of at most 64 bits lies within a word, a wider one begins with one.
        let (word, shift) = fields.data;
        or((word, shift), stream.row.data as u64);
        or((word + 1, 0), (stream.row.data >> 64) as u64);
        or(fields.tvalid, u64::from(stream.is_valid));
        or(fields.tlast, u64::from(stream.is_last));
        or(fields.overrun, u64::from(stream.is_overrun));
        if let Some(saturated) = fields.saturated {
            or(saturated, u64::from(stream.is_saturated));
        }
    }
}

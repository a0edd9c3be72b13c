//! The reference model of a sensor that keeps histograms: what its bins count, when
//! their rows show, which frames are lost.

mod counting;
mod rows;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use self::rows::Stream;
use super::bin_points::{BinPoints, Proofs};
use super::canvas::Canvas;
use super::coverage::{CoverPoint, CoverTable};
use super::exercise::Exercised;
use super::resets::PortState;
use super::stream::Ready;
use crate::scene::DetectorIndex;
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::Role;

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
    /// Of each detector the lanes with a bin whose top bit has come to be set: bit n is lane n.
    tops: Vec<u64>,
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
    /// As [`HistogramModel::tops`].
    tops: Vec<u64>,
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

impl HistogramModel {
    pub(super) fn new(
        interface: &Interface,
        layout: &Layout,
        table: Arc<CoverTable>,
    ) -> Option<HistogramModel> {
        let plan = interface.histogram()?;
        let place = |role| layout.outputs.place(role);
        let detectors = interface.reference_codes.len();
        let codes = interface.reference_codes.iter();
        let points = DetectorIndex::first(detectors);
        Some(HistogramModel {
            plan: *plan,
            points: points.map(|detector| BinPoints::new(plan, &table, detector)).collect(),
            chips: codes.map(|code| code.chips.clone()).collect(),
            fields: Fields {
                data: place(Role::Data),
                tvalid: place(Role::Valid),
                tlast: place(Role::Last),
                overrun: place(Role::Overrun),
                saturated: interface.saturates().then(|| place(Role::Saturated)),
            },
            table,
            bins: vec![vec![0; plan.bins() as usize]; detectors],
            proves: Proofs::default(),
            was_clamped: false,
            tops: vec![0; detectors],
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
            row: self.stream.is_valid.then_some(self.stream.beat),
        }
    }

    /// Reset. What the memories hold stays and is of no consequence, so it is followed no
    /// further.
    pub(super) fn reset(&mut self) {
        self.bins.iter_mut().for_each(|bins| bins.fill(0));
        self.proves.take();
        self.was_clamped = false;
        self.tops.fill(0);
        self.flags.clear();
        self.ended.clear();
        self.stream = Stream::default();
        self.memories = [None, None];
        self.half = 0;
    }

    /// ORs the stream's ports into the records of a stretch of clocks without reset.
    pub(super) fn predict(
        &mut self,
        clocks: Range<u64>,
        stalls: &[Range<u64>],
        expected: &mut impl Canvas,
        exercise: &mut Exercised,
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
            let comes = self.stream.arrivals.front().map_or(u64::MAX, |row| row.clock);
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

    fn mark(&self, point: impl Into<CoverPoint>, exercise: &mut Exercised) {
        if let Some(number) = self.table.number(point) {
            exercise.covered.mark(number);
        }
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

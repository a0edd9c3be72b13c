//! The reference model of a sensor that keeps histograms: what its bins count, when
//! their rows show, which frames are lost.

mod counting;
mod rows;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use self::rows::{FrameReading, Reader};
use super::axis::{AxiStream, AxisState};
use super::bin_points::{BinPoints, Proofs};
use super::canvas::Canvas;
use super::coverage::CoverTable;
use super::resets::PortState;
use super::stream::Ready;
use crate::scene::DetectorIndex;
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::Interface;

/// Bins, and the stream of their rows.
#[derive(Debug, Clone)]
pub(super) struct HistogramModel {
    plan: HistogramPlan,
    /// Chips of each detector's reference.
    chips: Vec<Vec<u8>>,
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
    /// Clocks after whose rising edge a bin's flag comes, with detector and lane.
    flags: VecDeque<(u64, DetectorIndex, u32)>,
    /// Frames that have ended and await their turn.
    ended: VecDeque<Ended>,
    reader: Reader,
    /// What the two memories held last, and which of them counts.
    memories: [Option<Vec<Vec<u64>>>; 2],
    half: usize,
    /// The clock of the last frame's last word, and the memory that counted it.
    last_end: Option<(u64, usize)>,
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

impl HistogramModel {
    pub(super) fn new(interface: &Interface, table: Arc<CoverTable>) -> Option<HistogramModel> {
        let plan = interface.histogram()?;
        let detectors = interface.reference_codes.len();
        let codes = interface.reference_codes.iter();
        let points = DetectorIndex::first(detectors);
        Some(HistogramModel {
            plan: *plan,
            points: points.map(|detector| BinPoints::new(plan, &table, detector)).collect(),
            chips: codes.map(|code| code.chips.clone()).collect(),
            table,
            bins: vec![vec![0; plan.bins() as usize]; detectors],
            proves: Proofs::default(),
            was_clamped: false,
            tops: vec![0; detectors],
            flags: VecDeque::new(),
            ended: VecDeque::new(),
            reader: Reader::default(),
            memories: [None, None],
            half: 0,
            last_end: None,
        })
    }

    /// What the ports show.
    pub(super) fn state(axis: &AxiStream) -> PortState {
        PortState { row: axis.now.is_valid.then_some(axis.now.group.beat), ..axis.state() }
    }

    /// Reset. What the memories hold stays and is of no consequence, so it is followed no
    /// further.
    pub(super) fn reset(&mut self, axis: &mut AxiStream) {
        self.bins.iter_mut().for_each(|bins| bins.fill(0));
        self.proves.take();
        self.was_clamped = false;
        self.tops.fill(0);
        self.flags.clear();
        self.ended.clear();
        self.reader = Reader::default();
        axis.now = AxisState::default();
        self.memories = [None, None];
        self.half = 0;
        self.last_end = None;
    }

    /// ORs the stream's ports into the records of a stretch of clocks without reset.
    pub(super) fn predict(
        &mut self,
        clocks: Range<u64>,
        stalls: &[Range<u64>],
        expected: &mut impl Canvas,
        axis: &mut AxiStream,
    ) {
        // Detectors have told theirs one after the other.
        self.flags.make_contiguous().sort_by_key(|flag| flag.0);
        let mut ready = Ready::new(stalls);
        let (mut filled, mut next) = (clocks.start, clocks.start);
        while next < clocks.end {
            let taken = match axis.now.is_valid {
                true => ready.first_from(next),
                false => u64::MAX,
            };
            let turn = self.ended.front().map_or(u64::MAX, |ended| ended.turn);
            let flag = self.flags.front().map_or(u64::MAX, |flag| flag.0);
            let shows = self.reader.reading.as_ref().map_or(u64::MAX, |reading| reading.clock);
            let comes = self.reader.arrivals.front().map_or(u64::MAX, |row| row.clock);
            let event = taken.min(turn).min(flag).min(shows).min(comes);
            if event >= clocks.end {
                break;
            }
            axis.fill(filled..event, expected);
            (filled, next) = (event, event + 1);
            if flag == event {
                self.raise_flag(event, axis);
            }
            if shows == event
                && let Some(FrameReading { rows, proves, .. }) = self.reader.reading.take()
            {
                axis.send(rows, true, proves, event);
            } else if taken == event {
                axis.take(event);
            }
            if comes == event
                && let Some(row) = self.reader.arrivals.pop_front()
            {
                self.come(row, taken == event, axis);
            }
            if turn == event
                && let Some(ended) = self.ended.pop_front()
            {
                self.turn(ended, event, taken == event, axis);
            }
        }
        axis.stands_until(clocks.end);
        axis.fill(filled..clocks.end, expected);
    }
}

//! The counts of groups on the stream: when they arrive, and which are lost.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::axis::{AxiStream, AxisState, Beat};
use super::canvas::Canvas;
use super::coverage::{CoverTable, GroupPosition, StreamPoint};
use super::exercise::CountedHits;
use super::registers::ScanEvent;
use crate::sensor::interface::{Correlator, Interface};
use crate::sensor::layout::{Layout, mask};

/// The counts of groups on their way to the stream.
#[derive(Debug, Clone)]
pub(super) struct StreamModel {
    pub(super) axis: AxiStream,
    /// Bits of the signed count in a beat, and the first of the total above it, if that is sent.
    count_bits: u32,
    first_total_bit: Option<u32>,
    arriving: VecDeque<GroupArrival>,
    /// What the registers are told, and at which clock, if there are any.
    told: Option<Vec<(u64, ScanEvent)>>,
}

/// A group's results on their way through the pipeline.
#[derive(Debug, Clone)]
pub(super) struct GroupArrival {
    /// Clock after whose rising edge the first shows.
    pub(super) clock: u64,
    /// In the order in which they are sent; at least one.
    pub(super) beats: Vec<Beat>,
    /// A count of theirs was saturated.
    pub(super) saturated: bool,
    /// They are the scan's last.
    pub(super) last: bool,
    /// Where their group stands in its scan.
    pub(super) place: GroupPosition,
    /// Cover points that are proven when all of them have shown.
    pub(super) proves: Vec<usize>,
    /// Those that are proven when they arrive, if nothing was saturated before.
    pub(super) proves_if_first: Vec<usize>,
}

impl StreamModel {
    /// An empty stream.
    pub(super) fn new(
        interface: &Interface,
        layout: &Layout,
        table: Arc<CoverTable>,
    ) -> StreamModel {
        StreamModel {
            axis: AxiStream::new(interface, layout, table),
            count_bits: interface.correlator().map_or(0, Correlator::signed_data_bits),
            first_total_bit: interface.total().map(|total| total.first_bit),
            arriving: VecDeque::new(),
            told: interface.registers.as_ref().map(|_| Vec::new()),
        }
    }

    /// What the registers are told of the clocks predicted since the last call.
    pub(super) fn take_told(&mut self) -> Vec<(u64, ScanEvent)> {
        self.told.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Empties it, as reset does.
    pub(super) fn reset(&mut self) {
        self.arriving.clear();
        self.axis.now = AxisState::default();
        self.told.iter_mut().for_each(Vec::clear);
    }

    /// A beat with a count, and with a total if they are sent.
    pub(super) fn beat(&self, count: i64, total: u64, counted: CountedHits) -> Beat {
        let count = u128::from(count as u64 & mask(self.count_bits));
        let total = self.first_total_bit.map_or(0, |first_bit| u128::from(total) << first_bit);
        Beat { data: count | total, counted }
    }

    /// The group whose results arrive next.
    pub(super) fn next_arrival(&self) -> Option<&GroupArrival> {
        self.arriving.front()
    }

    /// Sends a result on its way; results arrive in the order of these calls.
    pub(super) fn push(&mut self, arrival: GroupArrival) {
        self.arriving.push_back(arrival);
    }

    /// ORs the stream's ports into the records of a stretch of clocks without
    /// reset. `stalls` are the clocks at which `m_axis_tready` is low.
    pub(super) fn predict(
        &mut self,
        clocks: Range<u64>,
        stalls: &[Range<u64>],
        expected: &mut impl Canvas,
    ) {
        let mut ready = Ready::new(stalls);
        // Clocks before `filled` carry their result ports already; `next` is
        // the next clock at which something may happen.
        let (mut filled, mut next) = (clocks.start, clocks.start);
        while next < clocks.end {
            let arrival = self.arriving.front().map_or(u64::MAX, |a| a.clock);
            let was_valid = self.axis.now.is_valid;
            let was_last = was_valid && self.axis.now.is_last;
            let taken = if was_valid { ready.first_from(next) } else { u64::MAX };
            let event = arrival.min(taken);
            if event >= clocks.end {
                break;
            }
            self.axis.fill(filled..event, expected);
            (filled, next) = (event, event + 1);
            if taken == event {
                self.axis.take(event);
            }
            if arrival > event {
                continue;
            }
            let Some(mut results) = self.arriving.pop_front() else {
                break;
            };
            // What stands, or has just come up behind what was taken.
            let blocked = self.axis.now.is_valid;
            if was_valid && !blocked {
                let is_after_lost = self.axis.now.is_overrun;
                // What is in time has to show, the last beat too.
                let points = [
                    (true, StreamPoint::BackToBack),
                    (results.last, StreamPoint::LastBackToBack),
                    (was_last, StreamPoint::BehindLastBackToBack),
                    (is_after_lost, StreamPoint::BackToBackAfterLost),
                ];
                let reached = points.into_iter().filter(|(is, _)| *is);
                results.proves.extend(reached.filter_map(|(_, point)| self.axis.number(point)));
            }
            self.arrives(results, event, blocked);
        }
        self.axis.stands_until(clocks.end);
        self.axis.fill(filled..clocks.end, expected);
    }

    /// A group's results arrive at the rising edge of `clock`.
    fn arrives(&mut self, results: GroupArrival, clock: u64, blocked: bool) {
        let axis = &mut self.axis;
        if !axis.now.is_saturated {
            for &point in &results.proves_if_first {
                axis.exercise.covered.mark(point);
            }
        }
        if let Some(told) = &mut self.told {
            let happened = [(results.saturated, ScanEvent::Clamped), (blocked, ScanEvent::Lost)];
            let happened = happened.into_iter().filter(|(is, _)| *is);
            told.extend(happened.map(|(_, what)| (clock + 1, what)));
        }
        axis.now.is_saturated |= results.saturated;
        axis.exercise.saturations += u64::from(results.saturated);
        if blocked {
            axis.overruns(clock);
            axis.stands_across();
            axis.exercise.overruns += 1;
            axis.mark(StreamPoint::Lost { place: results.place });
            return;
        }
        axis.send(results.beats, results.last, results.proves, clock);
    }
}

/// When `m_axis_tready` is high.
pub(super) struct Ready<'a> {
    stalls: &'a [Range<u64>],
}

impl<'a> Ready<'a> {
    pub(super) fn new(stalls: &'a [Range<u64>]) -> Ready<'a> {
        Ready { stalls }
    }

    /// First clock from `clock` on at which it is high. Calls ask for clocks in
    /// order.
    pub(super) fn first_from(&mut self, clock: u64) -> u64 {
        while let Some((_, rest)) = self.stalls.split_first().filter(|(s, _)| s.end <= clock) {
            self.stalls = rest;
        }
        let mut first = clock;
        for stall in self.stalls {
            if stall.start > first {
                break;
            }
            first = first.max(stall.end);
        }
        first
    }
}

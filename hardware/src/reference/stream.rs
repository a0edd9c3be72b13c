//! The result stream: when a count shows, when it is taken, what is lost.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::canvas::Canvas;
use super::coverage::{CoverTable, Place, StreamPoint};
use super::exercise::{Counted, Exercised};
use super::registers::Told;
use super::resets::PortState;
use crate::sensor::interface::{Correlator, Interface};
use crate::sensor::layout::{Layout, mask};
use crate::sensor::port::Role;

/// The AXI4-Stream of results and its sticky flags.
#[derive(Debug, Clone)]
pub(super) struct ResultStream {
    fields: StreamFields,
    arriving: VecDeque<Arrival>,
    axis: AxisState,
    table: Arc<CoverTable>,
    /// What has been on it, resets notwithstanding.
    pub(super) exercise: Exercised,
    /// What the registers are told, and at which clock, if there are any.
    told: Option<Vec<(u64, Told)>>,
}

/// One transfer of the stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Beat {
    /// The signed count.
    pub(super) count: i64,
    /// The total count; not on the stream where totals are left out.
    pub(super) total: u64,
    /// The hits in it.
    pub(super) counted: Counted,
}

/// Places of the result ports; each is (word, shift).
#[derive(Debug, Clone, Copy)]
struct StreamFields {
    /// The signed count, in whole bytes.
    count: (usize, u32),
    count_bits: u32,
    /// The total count above it, if it is sent.
    total: Option<(usize, u32)>,
    tvalid: (usize, u32),
    tlast: (usize, u32),
    overrun: (usize, u32),
    saturated: Option<(usize, u32)>,
}

/// A group's results on their way through the pipeline.
#[derive(Debug, Clone)]
pub(super) struct Arrival {
    /// Clock after whose rising edge the first shows.
    pub(super) clock: u64,
    /// In the order in which they are sent; at least one.
    pub(super) beats: Vec<Beat>,
    /// A count of theirs was saturated.
    pub(super) saturated: bool,
    /// They are the scan's last.
    pub(super) last: bool,
    /// Where their group stands in its scan.
    pub(super) place: Place,
    /// Cover points that are proven when all of them have shown.
    pub(super) proves: Vec<usize>,
    /// Those that are proven when they arrive, if nothing was saturated before.
    pub(super) proves_if_first: Vec<usize>,
}

/// The result stream's registers.
#[derive(Debug, Clone, Default)]
struct AxisState {
    beat: Beat,
    /// Clock after whose rising edge it stood there first.
    shown_at: u64,
    /// It was left standing.
    is_held: bool,
    valid: bool,
    last: bool,
    /// Results behind the one on the stream.
    waiting: VecDeque<Beat>,
    /// They are the scan's last.
    waiting_last: bool,
    overrun: bool,
    saturated: bool,
    /// How the group on the stream fares.
    group: GroupState,
}

/// What has become of the group on the stream.
#[derive(Debug, Clone, Default)]
struct GroupState {
    /// Clock after whose rising edge its first beat showed.
    shown_at: u64,
    /// Number of the beat on the stream.
    beat: usize,
    /// Beats that stood while another group was lost, and when that was last.
    across: Vec<usize>,
    lost_at: Option<u64>,
    /// The scan's last beat was among them.
    last_stood: bool,
    /// Cover points that are proven when its last beat shows.
    proves: Vec<usize>,
}

impl AxisState {
    /// At the rising edge of `clock` the receiver took what was on the stream, or
    /// nothing was: the next result, if any, comes on it.
    fn take(&mut self, clock: u64, exercise: &mut Exercised) {
        self.valid = !self.waiting.is_empty();
        if let Some(beat) = self.waiting.pop_front() {
            self.beat = beat;
            self.last = self.waiting_last && self.waiting.is_empty();
            (self.shown_at, self.is_held) = (clock, false);
            exercise.shows(beat.counted, self.last);
            if self.waiting.is_empty() {
                for point in self.group.proves.drain(..) {
                    exercise.covered.mark(point);
                }
            }
        }
    }

    /// The cover points of a beat that is taken at the rising edge of `clock`.
    fn taken_points(&mut self, clock: u64, mut mark: impl FnMut(StreamPoint)) {
        let group = &mut self.group;
        if self.is_held {
            mark(StreamPoint::Held { beat: group.beat });
        }
        if self.waiting.is_empty() {
            group.across.drain(..).for_each(|beat| mark(StreamPoint::HeldAcross { beat }));
            if group.lost_at.take().is_some_and(|lost| lost + 1 == clock) {
                mark(StreamPoint::TooLate);
            }
            if std::mem::take(&mut group.last_stood) {
                mark(StreamPoint::LastHeldAcross);
            }
            let beats = group.beat as u64 + 1;
            if beats > 1 && group.shown_at + beats == clock {
                mark(StreamPoint::Burst);
            }
        }
        group.beat += 1;
    }

    /// A group is lost at the rising edge of `clock`.
    fn loses(&mut self, clock: u64) {
        let group = &mut self.group;
        if group.across.last() != Some(&group.beat) {
            group.across.push(group.beat);
        }
        group.lost_at = Some(clock);
        group.last_stood |= self.last;
    }

    /// Nobody took what is on the stream before `clock`.
    fn stands_until(&mut self, clock: u64, exercise: &mut Exercised) {
        if self.valid && self.shown_at + 1 < clock && !self.is_held {
            self.is_held = true;
            exercise.stalls += 1;
        }
    }
}

impl ResultStream {
    /// An empty stream.
    pub(super) fn new(
        interface: &Interface,
        layout: &Layout,
        table: Arc<CoverTable>,
    ) -> ResultStream {
        let place = |role| layout.outputs.place(role);
        let data = layout.outputs.field(Role::Data);
        let total = interface.total().map(|total| {
            let bit = data.shift + total.first_bit;
            (data.word + (bit / 64) as usize, bit % 64)
        });
        ResultStream {
            fields: StreamFields {
                count: (data.word, data.shift),
                count_bits: interface.correlator().map_or(0, Correlator::signed_data_bits),
                total,
                tvalid: place(Role::Valid),
                tlast: place(Role::Last),
                overrun: place(Role::Overrun),
                saturated: interface.saturates().then(|| place(Role::Saturated)),
            },
            arriving: VecDeque::new(),
            axis: AxisState::default(),
            table,
            exercise: Exercised::of(interface.reference_codes.len()),
            told: interface.registers.as_ref().map(|_| Vec::new()),
        }
    }

    /// What the registers are told of the clocks predicted since the last call.
    pub(super) fn take_told(&mut self) -> Vec<(u64, Told)> {
        self.told.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// What its ports show.
    pub(super) fn state(&self) -> PortState {
        PortState {
            is_waiting: self.axis.valid,
            is_overrun: self.axis.overrun,
            is_saturated: self.axis.saturated,
            row: None,
        }
    }

    /// Empties it, as reset does.
    pub(super) fn reset(&mut self) {
        self.arriving.clear();
        self.axis = AxisState::default();
        self.told.iter_mut().for_each(Vec::clear);
    }

    /// Sends a result on its way; results arrive in the order of these calls.
    pub(super) fn push(&mut self, arrival: Arrival) {
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
            let taken = if self.axis.valid { ready.first_from(next) } else { u64::MAX };
            let event = arrival.min(taken);
            if event >= clocks.end {
                break;
            }
            self.fill(filled..event, expected);
            filled = event;
            next = event + 1;
            let blocked = self.axis.valid && (taken != event || !self.axis.waiting.is_empty());
            let was_valid = self.axis.valid;
            if self.axis.valid && taken == event {
                self.take(event);
            }
            if arrival > event {
                continue;
            }
            let Some(results) = self.arriving.pop_front() else {
                break;
            };
            if was_valid && !blocked {
                self.mark(StreamPoint::BackToBack);
            }
            self.arrives(results, event, blocked);
        }
        self.axis.stands_until(clocks.end, &mut self.exercise);
        self.fill(filled..clocks.end, expected);
    }

    fn mark(&mut self, point: StreamPoint) {
        if let Some(number) = self.table.number(point) {
            self.exercise.covered.mark(number);
        }
    }

    /// The receiver takes a beat at the rising edge of `clock`.
    fn take(&mut self, clock: u64) {
        self.axis.stands_until(clock, &mut self.exercise);
        self.exercise.results_taken += 1;
        let (table, covered) = (&self.table, &mut self.exercise.covered);
        self.axis.taken_points(clock, |point| {
            if let Some(number) = table.number(point) {
                covered.mark(number);
            }
        });
        self.axis.take(clock, &mut self.exercise);
    }

    /// A group's results arrive at the rising edge of `clock`.
    fn arrives(&mut self, results: Arrival, clock: u64, blocked: bool) {
        if !self.axis.saturated {
            for &point in &results.proves_if_first {
                self.exercise.covered.mark(point);
            }
        }
        if let Some(told) = &mut self.told {
            let happened = [(results.saturated, Told::Clamped), (blocked, Told::Lost)];
            let happened = happened.into_iter().filter(|(is, _)| *is);
            told.extend(happened.map(|(_, what)| (clock + 1, what)));
        }
        self.axis.saturated |= results.saturated;
        self.exercise.saturations += u64::from(results.saturated);
        if blocked {
            self.axis.overrun = true;
            self.exercise.overruns += 1;
            self.axis.loses(clock);
            let place = results.place;
            self.mark(StreamPoint::Lost { place });
            return;
        }
        self.axis.waiting.extend(results.beats);
        self.axis.waiting_last = results.last;
        self.axis.group =
            GroupState { shown_at: clock, proves: results.proves, ..GroupState::default() };
        self.axis.take(clock, &mut self.exercise);
    }

    /// ORs the result ports' present values into a range of clocks.
    fn fill(&self, clocks: Range<u64>, expected: &mut impl Canvas) {
        let (axis, fields) = (&self.axis, &self.fields);
        let mut or = |(word, shift): (usize, u32), value: u64| {
            if value == 0 {
                return;
            }
            expected.or(clocks.clone(), word, value << shift);
            // What a port wider than a word has beyond the word's end.
            let beyond = value.unbounded_shr(64 - shift);
            if beyond != 0 {
                expected.or(clocks.clone(), word + 1, beyond);
            }
        };
        or(fields.count, axis.beat.count as u64 & mask(fields.count_bits));
        if let Some(total) = fields.total {
            or(total, axis.beat.total);
        }
        or(fields.tvalid, u64::from(axis.valid));
        or(fields.tlast, u64::from(axis.last));
        or(fields.overrun, u64::from(axis.overrun));
        if let Some(saturated) = fields.saturated {
            or(saturated, u64::from(axis.saturated));
        }
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

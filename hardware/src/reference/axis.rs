//! The AXI4-Stream of results and its sticky flags: what stands on it, since when, and what that
//! proves.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::canvas::Canvas;
use super::coverage::{CoverPoint, CoverTable, StreamPoint};
use super::exercise::{CountedHits, Exercised};
use super::resets::PortState;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// One transfer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Beat {
    pub(super) data: u128,
    /// The hits in it.
    pub(super) counted: CountedHits,
}

/// Where the ports' bits are in a record; each is (word, shift).
#[derive(Debug, Clone, Copy)]
struct AxisBits {
    data: (usize, u32),
    tvalid: (usize, u32),
    tlast: (usize, u32),
    overrun: (usize, u32),
    saturated: Option<(usize, u32)>,
}

/// The stream.
#[derive(Debug, Clone)]
pub(super) struct AxiStream {
    bits: AxisBits,
    table: Arc<CoverTable>,
    /// What has been on it, resets notwithstanding.
    pub(super) exercise: Exercised,
    pub(super) now: AxisState,
}

/// Its registers, and how they came to be what they are.
#[derive(Debug, Clone, Default)]
pub(super) struct AxisState {
    beat: Beat,
    pub(super) is_valid: bool,
    pub(super) is_last: bool,
    pub(super) is_overrun: bool,
    pub(super) is_saturated: bool,
    /// The beat is its group's last.
    ends_group: bool,
    /// Clock after whose rising edge it stood there first.
    shown_at: u64,
    /// It was left standing.
    is_held: bool,
    /// Those behind it, and whether they are the scan's last.
    waiting: VecDeque<Beat>,
    waiting_last: bool,
    /// How the group on the stream fares.
    pub(super) group: GroupState,
}

/// What has become of the group on the stream.
#[derive(Debug, Clone, Default)]
pub(super) struct GroupState {
    /// Clock after whose rising edge its first beat showed.
    pub(super) shown_at: u64,
    /// Number of the beat on the stream.
    pub(super) beat: usize,
    /// A beat of its own was lost.
    pub(super) is_cut: bool,
    /// Beats that stood while another group was lost, and when something was last.
    across: Vec<usize>,
    lost_at: Option<u64>,
    /// Groups that were lost while the beat on the stream stood, and whether it were two of any.
    lost_meanwhile: u32,
    is_lost_again: bool,
    /// The scan's last beat was among them.
    last_stood: bool,
    /// Cover points that are proven when its last beat shows.
    proves: Vec<usize>,
}

impl AxiStream {
    /// An empty stream.
    pub(super) fn new(interface: &Interface, layout: &Layout, table: Arc<CoverTable>) -> AxiStream {
        let place = |role| layout.outputs.place(role);
        AxiStream {
            bits: AxisBits {
                data: place(PortRole::Data),
                tvalid: place(PortRole::Valid),
                tlast: place(PortRole::Last),
                overrun: place(PortRole::Overrun),
                saturated: interface.saturates().then(|| place(PortRole::Saturated)),
            },
            table,
            exercise: Exercised::of(interface.reference_codes.len()),
            now: AxisState::default(),
        }
    }

    /// What its ports show.
    pub(super) fn state(&self) -> PortState {
        PortState {
            is_waiting: self.now.is_valid,
            is_overrun: self.now.is_overrun,
            is_saturated: self.now.is_saturated,
            row: None,
        }
    }

    /// The number of a cover point, if the table has it.
    pub(super) fn number(&self, point: StreamPoint) -> Option<usize> {
        self.table.number(point)
    }

    /// Marks a cover point, if the table has it.
    pub(super) fn mark(&mut self, point: impl Into<CoverPoint>) {
        if let Some(number) = self.table.number(point) {
            self.exercise.covered.mark(number);
        }
    }

    /// Nobody took what is on the stream before `clock`.
    pub(super) fn stands_until(&mut self, clock: u64) {
        let now = &mut self.now;
        if now.is_valid && now.shown_at + 1 < clock && !now.is_held {
            now.is_held = true;
            self.exercise.stalls += 1;
        }
    }

    /// The receiver takes a beat at the rising edge of `clock`: the next one, if there is one, comes on
    /// the stream.
    pub(super) fn take(&mut self, clock: u64) {
        self.stands_until(clock);
        self.exercise.results_taken += 1;
        let beat = self.now.group.beat;
        if self.now.is_held {
            self.mark(StreamPoint::Held { beat });
        }
        if self.now.ends_group {
            self.end_group(clock);
        }
        self.now.group.beat += 1;
        self.now.is_valid = false;
        self.show_next(clock);
    }

    /// A group's last beat is taken.
    fn end_group(&mut self, clock: u64) {
        let group = &mut self.now.group;
        let (lost_at, last_stood) = (group.lost_at.take(), std::mem::take(&mut group.last_stood));
        let beats = group.beat as u64 + 1;
        let is_lost_again = std::mem::take(&mut group.is_lost_again);
        let is_burst = beats > 1 && group.shown_at + beats == clock && !group.is_cut;
        for beat in std::mem::take(&mut group.across) {
            self.mark(StreamPoint::HeldAcross { beat });
        }
        let is_late = lost_at.is_some_and(|lost| lost + 1 == clock);
        let points = [
            (is_late, StreamPoint::TooLate),
            (last_stood, StreamPoint::LastHeldAcross),
            (is_lost_again, StreamPoint::LostAgain),
            (is_burst, StreamPoint::Burst),
        ];
        points.into_iter().filter(|(is, _)| *is).for_each(|(_, point)| self.mark(point));
    }

    /// Something is lost at the rising edge of `clock`; says whether it is the first since reset.
    pub(super) fn overruns(&mut self, clock: u64) -> bool {
        self.now.group.lost_at = Some(clock);
        !std::mem::replace(&mut self.now.is_overrun, true)
    }

    /// What stands on the stream stands across the loss of a group.
    pub(super) fn stands_across(&mut self) {
        let is_last = self.now.is_valid && self.now.is_last;
        let group = &mut self.now.group;
        if group.across.last() != Some(&group.beat) {
            group.across.push(group.beat);
            group.lost_meanwhile = 0;
        }
        group.lost_meanwhile += 1;
        group.is_lost_again |= group.lost_meanwhile == 2;
        group.last_stood |= is_last;
    }

    /// A group comes on the empty stream at the rising edge of `clock`.
    pub(super) fn send(
        &mut self,
        beats: impl IntoIterator<Item = Beat>,
        is_last: bool,
        proves: Vec<usize>,
        clock: u64,
    ) {
        self.now.waiting.extend(beats);
        self.now.waiting_last = is_last;
        self.now.group = GroupState { shown_at: clock, proves, ..GroupState::default() };
        self.show_next(clock);
    }

    fn show_next(&mut self, clock: u64) {
        let Some(beat) = self.now.waiting.pop_front() else {
            return;
        };
        let ends_group = self.now.waiting.is_empty();
        self.show(beat, (self.now.waiting_last && ends_group, ends_group), clock);
        if ends_group {
            for point in self.now.group.proves.drain(..) {
                self.exercise.covered.mark(point);
            }
        }
    }

    /// A beat shows after the rising edge of `clock`, which may be the last of its scan, and of its
    /// group.
    pub(super) fn show(&mut self, beat: Beat, (is_last, ends_group): (bool, bool), clock: u64) {
        let now = &mut self.now;
        (now.beat, now.is_valid, now.is_last) = (beat, true, is_last);
        (now.ends_group, now.shown_at, now.is_held) = (ends_group, clock, false);
        if is_last && now.is_overrun {
            self.mark(StreamPoint::LastAfterOverrun);
        }
        self.exercise.shows(beat.counted, is_last);
    }

    /// ORs the ports' present values into a range of clocks.
    pub(super) fn fill(&self, clocks: Range<u64>, expected: &mut impl Canvas) {
        let (now, bits) = (&self.now, &self.bits);
        let mut or = |(word, shift): (usize, u32), value: u64| {
            if value != 0 && !clocks.is_empty() {
                expected.or(clocks.clone(), word, value << shift);
            }
        };
        // A port of at most 64 bits lies within a word, a wider one begins with one.
        let (word, shift) = bits.data;
        or((word, shift), now.beat.data as u64);
        or((word + 1, 0), (now.beat.data >> 64) as u64);
        or(bits.tvalid, u64::from(now.is_valid));
        or(bits.tlast, u64::from(now.is_last));
        or(bits.overrun, u64::from(now.is_overrun));
        if let Some(saturated) = bits.saturated {
            or(saturated, u64::from(now.is_saturated));
        }
    }
}

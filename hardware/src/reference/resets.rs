//! What a reset comes upon, and which cover points that makes.

use std::ops::Range;

use super::coverage::{CoverTable, ResetPoint, ResetState};
use crate::sensor::interface::Interface;

/// Watches what is in the pipelines when a reset comes.
#[derive(Debug, Clone)]
pub(super) struct ResetWatch {
    /// Clocks that a hit takes to the total.
    depth: u64,
    /// Clocks that no pipeline is longer than.
    longest: u64,
    /// Clock of the last word of the last group, if it counted anything.
    group_end: Option<u64>,
    /// That of a scan's last group.
    scan_end: Option<u64>,
    /// The last words with a counted hit.
    hit: Option<u64>,
    hit_before: Option<u64>,
    /// The last reset came upon a result that waited, and nobody was ready to take one since.
    pub(super) is_stalled: bool,
    /// Points that the first results after the last reset prove.
    pub(super) of_results: Vec<usize>,
    /// Points that the first peak after it proves.
    pub(super) of_peaks: Vec<usize>,
}

/// The result ports when a reset comes.
#[derive(Debug, Clone, Copy)]
pub(super) struct PortState {
    pub(super) is_waiting: bool,
    pub(super) is_overrun: bool,
    pub(super) is_saturated: bool,
    /// The row of a frame that waits.
    pub(super) row: Option<usize>,
}

/// What a reset comes upon.
#[derive(Debug, Clone, Copy)]
pub(super) struct Upon {
    /// The pause between two scans.
    pub(super) in_pause: bool,
    /// A hit in the word of its first clock.
    pub(super) has_hit: bool,
    pub(super) ports: PortState,
}

impl ResetWatch {
    pub(super) fn of(interface: &Interface) -> ResetWatch {
        let peak = interface.peak_latency_clocks();
        ResetWatch {
            depth: u64::from(interface.clocks_of_hit()),
            longest: u64::from(interface.result_latency_clocks.max(peak)),
            group_end: None,
            scan_end: None,
            hit: None,
            hit_before: None,
            is_stalled: false,
            of_results: Vec::new(),
            of_peaks: Vec::new(),
        }
    }

    /// The word of a clock had hits that were counted.
    pub(super) fn hits_in(&mut self, clock: u64) {
        if self.hit != Some(clock) {
            self.hit_before = self.hit.replace(clock);
        }
    }

    /// A group's last word was presented at `clock`.
    pub(super) fn group_ends(&mut self, clock: u64, is_scans: bool, is_counted: bool) {
        self.group_end = is_counted.then_some(clock);
        if is_scans {
            self.scan_end = Some(clock);
        }
    }

    /// A reset begins.
    pub(super) fn enters(&mut self, reset: &Range<u64>, upon: Upon, table: &CoverTable) {
        let ports = upon.ports;
        let age = |clock: Option<u64>| clock.map(|clock| reset.start - 1 - clock);
        let length = reset.end - reset.start;
        self.of_results.clear();
        self.of_peaks.clear();
        self.is_stalled = ports.is_waiting;
        let states = [
            (length == 1, ResetState::OneClock),
            (length == 2, ResetState::TwoClocks),
            (length > self.longest, ResetState::Long),
            (ports.is_waiting, ResetState::Waiting),
            (ports.is_overrun, ResetState::Overrun),
            (ports.is_saturated, ResetState::Saturated),
            (upon.in_pause, ResetState::Pause),
            (length == 1 && upon.has_hit, ResetState::Hit),
        ];
        for (_, state) in states.into_iter().filter(|(is, _)| *is) {
            self.of_results.extend(table.number(ResetPoint::In { state }));
        }
        if length == 1 {
            let row = ports.row.and_then(|beat| table.number(ResetPoint::AtRow { beat }));
            self.of_results.extend(row);
            if let Some(age) = age(self.group_end) {
                let age = u32::try_from(age).unwrap_or(u32::MAX);
                self.of_results.extend(table.number(ResetPoint::Age { age }));
            }
            let is_lone = age(self.hit_before).is_none_or(|age| age >= self.depth);
            if let Some(age) = age(self.hit).filter(|_| is_lone) {
                let age = u32::try_from(age).unwrap_or(u32::MAX);
                self.of_results.extend(table.number(ResetPoint::Hit { age }));
            }
            if let Some(age) = age(self.scan_end) {
                let age = u32::try_from(age).unwrap_or(u32::MAX);
                self.of_peaks.extend(table.number(ResetPoint::Peak { age }));
            }
        }
        (self.group_end, self.scan_end) = (None, None);
        (self.hit, self.hit_before) = (None, None);
    }
}

//! One target: acquired, followed, and taken away.

use super::windows::Windows;
use crate::photons::random::scatter;
use crate::reference::tracking::{Follower, WindowSums};
use crate::sensor::track::FRACTION_BITS;

/// Scans that look for a target before it is given up.
const MOST_SCANS: u32 = 3;
/// Windows that a target which was taken away may go on in.
const MOST_WINDOWS_TO_TELL: u32 = 64;

/// The times of a sensor that follows a target, in chips, and where the target is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// First phase step of the scan that looks for it, and how many there are.
    pub first_step: u64,
    pub steps: u64,
    pub window_steps: u64,
    pub integration_chips: u64,
    /// From a scan's last chip to the first one of the window behind it, and from a window's.
    pub search_turn_chips: u64,
    pub turn_chips: u64,
    pub steps_per_period: u64,
    /// Phase step at which the light's peak is at the first scan's start, and how many it goes on in a chip.
    pub place: f64,
    pub steps_per_chip: f64,
}

impl Course {
    /// Where the peak is at a time, in phase steps.
    pub fn place_at(&self, chips: f64) -> f64 {
        self.place + self.steps_per_chip * chips
    }

    /// Chips from the first of a scan to that of the first window.
    pub fn search_pitch_chips(&self) -> u64 {
        self.steps * self.integration_chips + self.search_turn_chips
    }

    /// How far a position is from that, the shorter way round the code period.
    pub fn error(&self, position: f64, chips: f64) -> f64 {
        let period = self.steps_per_period as f64;
        let error = position - self.place_at(chips);
        error - period * (error / period).round()
    }

    /// Chips of a window.
    pub fn window_chips(&self) -> u64 {
        self.window_steps * self.integration_chips
    }

    /// Chips from one window's first to the next one's.
    pub fn pitch_chips(&self) -> u64 {
        self.window_chips() + self.turn_chips
    }
}

/// A scan that looked for a target, or a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrackedScan {
    /// Chips from the target's first scan's first one to its own.
    pub chips: u64,
    /// Phase steps, and those of them that had the target's light.
    pub steps: u64,
    pub lit: u64,
    /// What followed.
    pub after: TargetState,
}

/// Where a target is thought to be, as a host reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TargetState {
    /// Phase step, in parts of 2^-8; none without a target.
    pub position: Option<u64>,
    pub is_locked: bool,
    /// Whether it has just been lost.
    pub is_lost: bool,
}

/// What became of a target.
#[derive(Debug, Clone, Default)]
pub(super) struct TrackOutcome {
    /// Scans and windows, one after another.
    pub scans: Vec<TrackedScan>,
    /// Chips from the first scan's first to the end of the first window that had its light; none without one.
    pub locked_chips: Option<u64>,
    /// How far the position was off after each update that was asked for, in steps.
    pub errors: Vec<f64>,
    /// Windows since then with all of its light, and those of them that said they had not.
    pub lit_windows: u64,
    pub false_alarms: u64,
    /// Whether it was lost though it was there.
    pub was_lost: bool,
    /// Updates from when it was taken away until that was told; none if it was not.
    pub updates_to_tell: Option<u32>,
}

/// A run under way.
pub(super) struct TrackRun<'m> {
    course: Course,
    windows: Windows<'m>,
    follower: Follower,
    /// Whether positions are as a host reads them, to 2^-8 of a step; or as they are.
    is_read: bool,
    /// First chip of the next scan.
    chips: u64,
    scans: Vec<TrackedScan>,
}

impl<'m> TrackRun<'m> {
    pub fn new(course: Course, windows: Windows<'m>, follower: Follower) -> TrackRun<'m> {
        TrackRun { course, windows, follower, is_read: false, chips: 0, scans: Vec::new() }
    }

    /// The same with positions as a host reads them.
    pub fn read(self) -> TrackRun<'m> {
        TrackRun { is_read: true, ..self }
    }

    /// A target that a scan has to find, then is followed for `settling` and `updates` windows, and then taken away in
    /// a phase step that `random` chooses.
    pub fn acquire_and_follow(mut self, settling: u64, updates: u64, random: u64) -> TrackOutcome {
        let outcome = self.outcome(settling, updates, random);
        TrackOutcome { scans: self.scans, ..outcome }
    }

    fn outcome(&mut self, settling: u64, updates: u64, random: u64) -> TrackOutcome {
        let mut outcome = TrackOutcome::default();
        let locks = (0..MOST_SCANS).any(|_| {
            self.look();
            // As many windows as patience has, until it has the light or has given up.
            while self.follower.window().is_some() {
                self.window(u64::MAX);
                if self.follower.is_locked() {
                    return true;
                }
            }
            false
        });
        if !locks {
            return outcome;
        }
        outcome.locked_chips = Some(self.chips - self.course.turn_chips);
        for update in 0..settling + updates {
            let error = self.window(u64::MAX);
            outcome.lit_windows += 1;
            outcome.false_alarms += u64::from(!self.follower.is_locked());
            let Some(error) = error else {
                outcome.was_lost = true;
                return outcome;
            };
            if update >= settling {
                outcome.errors.push(error);
            }
        }
        outcome.updates_to_tell = self.take_away(random);
        outcome
    }

    /// A target that is where a scan has just found it. Whether it is held for so many windows.
    pub fn holds(mut self, count: i64, windows: u64) -> bool {
        let place = self.course.place_at(0.5 * self.course.window_chips() as f64);
        let period = self.course.steps_per_period as i64;
        self.follower.found((place.round() as i64).rem_euclid(period) as u64, count);
        (0..windows).all(|_| self.window(u64::MAX).is_some())
    }

    /// A scan that looks for a target.
    fn look(&mut self) {
        let Course { first_step, steps, steps_per_period, .. } = self.course;
        let counts = self.windows.scan(first_step, steps, self.chips, u64::MAX);
        // The first of equal ones, as the hardware's peak.
        let mut peak = (0, i64::MIN);
        for (step, &count) in counts.iter().enumerate() {
            if count > peak.1 {
                peak = (step as u64, count);
            }
        }
        self.follower.found((first_step + peak.0) % steps_per_period, peak.1);
        self.end_scan(steps, steps, false);
        self.chips += self.course.search_pitch_chips();
    }

    /// A window, whose first `lit` steps have light. How far the position is off afterwards, of where the target was
    /// in the middle of the window; none if it has none.
    fn window(&mut self, lit: u64) -> Option<f64> {
        let first = self.follower.window()?;
        let counts = self.windows.scan(first, self.course.window_steps, self.chips, lit);
        let middle = self.chips as f64 + 0.5 * self.course.window_chips() as f64;
        let is_lost = self.follower.counted(WindowSums::of(&counts, self.course.window_steps / 2));
        self.end_scan(self.course.window_steps, lit, is_lost);
        self.chips += self.course.pitch_chips();
        let steps = match self.is_read {
            true => self.follower.position()? as f64 / f64::from(1 << FRACTION_BITS),
            false => self.follower.position_steps()?,
        };
        Some(self.course.error(steps, middle))
    }

    fn end_scan(&mut self, steps: u64, lit: u64, is_lost: bool) {
        let position = self.follower.position();
        let after = TargetState { position, is_locked: self.follower.is_locked(), is_lost };
        self.scans.push(TrackedScan { chips: self.chips, steps, lit, after });
    }

    /// The light goes off in the middle of some window. Updates until the last of them had no light: the first is that
    /// of the window in which it goes off.
    fn take_away(&mut self, random: u64) -> Option<u32> {
        let mut lit = scatter(random, 0) % self.course.window_steps;
        for update in 1..=MOST_WINDOWS_TO_TELL {
            let _ = self.window(lit);
            if !self.follower.is_locked() {
                return Some(update);
            }
            lit = 0;
        }
        None
    }
}

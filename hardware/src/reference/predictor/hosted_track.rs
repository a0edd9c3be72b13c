//! A target that is followed, from scan to scan of hardware whose host has turned that on.

use crate::reference::coverage::{Extreme, TrackNumber, TrackPoint};
use crate::reference::registers::{RegisterModel, Rival, ScanEvent};
use crate::reference::tracking::{Follower, WindowSums};
use crate::sensor::registers::Settings;
use crate::sensor::track::{CLOCKS_FROM_PEAK, MOST_PATIENCE, SHARE_BITS, TrackPlan, TrackSetting};

/// The most halvings of a share.
const MOST_HALVINGS: u32 = (1 << SHARE_BITS) - 1;

/// What follows a target.
#[derive(Debug, Clone)]
pub(super) struct HostedTrack {
    plan: TrackPlan,
    follower: Follower,
    /// There is a target for the next scan to follow.
    follows: bool,
    /// The present scan is a window.
    is_window: bool,
    /// First phase step of the present scan.
    first_step: u64,
    /// Counts of the present scan so far.
    pub(super) counts: Vec<i64>,
    /// The clock at which the present scan's last count is there, once that is known: a peak before it is of
    /// another scan.
    counted_at: Option<u64>,
    waits: Waits,
    /// Cover points that the next scan proves when its last result shows.
    points: Vec<TrackPoint>,
}

/// Whether what follows of the present scan is still to come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Waits {
    /// It is.
    Yes,
    /// Until after this clock.
    Until(u64),
    No,
}

impl HostedTrack {
    pub(super) fn new(plan: TrackPlan) -> HostedTrack {
        HostedTrack {
            plan,
            follower: Follower::new(plan, plan.setting),
            follows: false,
            is_window: false,
            first_step: 0,
            counts: Vec::new(),
            counted_at: None,
            waits: Waits::No,
            points: Vec::new(),
        }
    }

    pub(super) fn reset(&mut self) {
        *self = HostedTrack::new(self.plan);
    }

    /// Where the target is that is followed, in phase steps, and whether the last window had its light.
    pub(super) fn target(&self) -> Option<(f64, bool)> {
        let position = self.follower.position_steps().filter(|_| self.follows)?;
        Some((position, self.follower.is_locked()))
    }

    /// Whether no scan may begin at a clock.
    pub(super) fn waits(&self, clock: u64) -> bool {
        match self.waits {
            Waits::Yes => true,
            Waits::Until(last) => clock <= last,
            Waits::No => false,
        }
    }

    /// No scans are wanted at a clock: a target that was found by then is left alone.
    pub(super) fn stops(&mut self, clock: u64) {
        let is_to_come = matches!(self.waits, Waits::Until(last) if clock < last);
        self.follows &= is_to_come;
    }

    /// Whether the present scan is a window.
    pub(super) fn is_window(&self) -> bool {
        self.is_window
    }

    /// Settings are taken over.
    pub(super) fn begins(&mut self) {
        self.is_window = self.follows;
        self.counts.clear();
        self.counted_at = None;
    }

    /// What was decided before the scan that begins now.
    pub(super) fn take_points(&mut self) -> Vec<TrackPoint> {
        std::mem::take(&mut self.points)
    }

    /// They have been; a window has some of its own.
    pub(super) fn takes(&mut self, settings: &mut Settings) {
        let setting = settings.track.unwrap_or(self.plan.setting);
        self.follower.setting = setting;
        if let Some(first) = self.follower.window().filter(|_| self.is_window) {
            settings.groups = self.plan.window_steps();
            settings.first_step = first;
        }
        self.first_step = settings.first_step;
        let waits = setting.is_on || self.is_window;
        self.waits = if waits { Waits::Yes } else { Waits::No };
    }

    /// They do not fit.
    pub(super) fn refused(&mut self) {
        self.waits = Waits::No;
    }

    /// A scan's last count is there at a clock.
    pub(super) fn window_ends(&mut self, clock: u64, registers: &mut RegisterModel) {
        let counts = std::mem::take(&mut self.counts);
        self.counted_at = Some(clock);
        if !self.is_window || self.waits != Waits::Yes {
            return;
        }
        let setting = self.follower.setting;
        let sums = WindowSums::of(&counts, self.plan.half_steps());
        let before = self.follower.clone();
        let is_lost = self.follower.counted(sums);
        self.points = points(&self.follower, sums, before.window(), is_lost);
        let done = clock + u64::from(self.plan.decision_clocks());
        self.follows = setting.is_on && !is_lost;
        let position = self.follower.position().filter(|_| self.follows);
        registers.tell(
            done,
            ScanEvent::Tracked {
                position: position.map(|position| position as u32),
                locked: self.follows && self.follower.is_locked(),
            },
        );
        if setting.is_on {
            registers.tell(done + 1, ScanEvent::Decided(rivals(&before, sums)));
        }
        if setting.is_on && is_lost {
            registers.tell(done + 1, ScanEvent::TargetLost);
        }
        self.waits = Waits::Until(done);
    }

    /// A scan's peak, its step from the scan's first on and its count, shows after a clock.
    pub(super) fn scan_found(
        &mut self,
        clock: u64,
        (step, count): (u64, i64),
        registers: &mut RegisterModel,
    ) {
        let is_own = self.counted_at.is_some_and(|counted_at| clock > counted_at);
        if self.is_window || self.waits != Waits::Yes || !is_own {
            return;
        }
        let done = clock + u64::from(CLOCKS_FROM_PEAK);
        self.follower.found((self.first_step + step) % self.plan.period_steps, count);
        self.follows = self.follower.window().is_some();
        self.points = vec![if self.follows { TrackPoint::Found } else { TrackPoint::Nothing }];
        let position = self.follower.position().map(|position| position as u32);
        registers.tell(done, ScanEvent::Tracked { position, locked: false });
        self.waits = Waits::Until(done);
    }
}

/// What a window's decision shows of the rule.
fn points(
    follower: &Follower,
    sums: WindowSums,
    before: Option<u64>,
    is_lost: bool,
) -> Vec<TrackPoint> {
    if !follower.is_locked() {
        return vec![if is_lost { TrackPoint::Lost } else { TrackPoint::Missed }];
    }
    let mut points = vec![TrackPoint::Lit];
    if sums.slope.abs() >= sums.all {
        points.push(TrackPoint::Most);
    }
    if let (Some(before), Some(after)) = (before, follower.window()) {
        if before != after {
            points.push(TrackPoint::Moved { back: sums.slope < 0 });
        }
        if before.abs_diff(after) > follower.period_steps() / 2 {
            points.push(TrackPoint::OverTheEnd);
        }
    }
    points
}

/// What would be told of a window's decision if a number at an end of its range were the one next to it.
fn rivals(before: &Follower, sums: WindowSums) -> Vec<Rival> {
    let TrackSetting { gain_halvings, threshold_halvings, patience, .. } = before.setting;
    let of_share = |halvings| match halvings {
        0 => Some((Extreme::Most, 1)),
        MOST_HALVINGS => Some((Extreme::Least, MOST_HALVINGS - 1)),
        _ => None,
    };
    let of_patience = match patience {
        // Without patience a target is lost with the first window, too.
        0 | 1 => Some((Extreme::Least, 2)),
        MOST_PATIENCE => Some((Extreme::Most, MOST_PATIENCE - 1)),
        _ => None,
    };
    let others = [
        (TrackNumber::Gain, of_share(gain_halvings)),
        (TrackNumber::Threshold, of_share(threshold_halvings)),
        (TrackNumber::Patience, of_patience),
    ];
    let rival = |(number, other): (TrackNumber, Option<(Extreme, u32)>)| {
        let (extreme, value) = other?;
        let mut after = before.clone();
        match number {
            TrackNumber::Gain => after.setting.gain_halvings = value,
            TrackNumber::Threshold => after.setting.threshold_halvings = value,
            TrackNumber::Patience => after.setting.patience = value,
        }
        let lost = after.counted(sums);
        // That of a lost target stays.
        let position = after.position().or(before.position())? as u32;
        let point = TrackPoint::Number { number, extreme };
        Some(Rival { point, position, locked: after.is_locked(), lost })
    };
    others.into_iter().filter_map(rival).collect()
}

//! How a target is followed: an early-late rule in whole numbers, as the hardware reckons.
//!
//! A window has two chips of phase steps, 2 S. Round the peak of a code's autocorrelation counts fall by h / S a step on
//! both sides, to nothing after a chip, so that with the peak d steps behind the window's middle
//!
//! A = sum of all counts = S h, D = later half less earlier half = 2 h d, d = S D / (2 A),
//!
//! exactly as long as |d| is at most half a step. D weighs each step by the sign of its slope: with the same noise at all
//! steps that is the weighing of least variance. What all steps have in common cancels in D; in A it does not, and
//! changes the gain.
//!
//! The position is where the peak is thought to be, moves by a share g of the distance, and has a fraction of 15 bits. A
//! window begins at a whole step: its middle is a step before or behind the position in turns, such that it is at the position on
//! average (a sigma-delta modulator of the first order). So it is only that the peak is in the middle that a mean
//! position rests on, and not on the gain, which counts that all steps have in common would change from one window to the next.

use crate::sensor::track::{FRACTION_BITS, HIDDEN_BITS, LIGHT_HALVINGS, TrackPlan, TrackSetting};

/// Bits of a position's fraction.
const POSITION_BITS: u32 = FRACTION_BITS + HIDDEN_BITS;
/// Half a step, and all of a step but the whole.
const HALF_STEP: i64 = 1 << (POSITION_BITS - 1);
const FRACTION: i64 = (1 << POSITION_BITS) - 1;

/// What follows a target from scan to scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Follower {
    plan: TrackPlan,
    /// How it does.
    pub setting: TrackSetting,
    target: Option<Target>,
}

/// A target that is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Target {
    /// Phase step of its peak, in parts of 2^-15.
    position: i64,
    /// What the windows' middles owe to the positions so far, in the same parts, of one step.
    owed: i64,
    /// Steps from the position's whole step to the first one of the window's later half.
    ahead: i64,
    /// The sum of a window's counts that is expected.
    light: i64,
    /// Windows without it, one after another.
    missed: u32,
    /// Whether the last window had it.
    is_locked: bool,
}

/// The sums of a window's counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WindowSums {
    /// Of all of them.
    pub all: i64,
    /// Of the later half, less the earlier half.
    pub slope: i64,
}

impl WindowSums {
    /// Of a window's counts, of which so many are the earlier half; behind a shorter scan, of those that are
    /// there.
    pub fn of(counts: &[i64], half_steps: u64) -> WindowSums {
        let (early, late) = counts.split_at(counts.len().min(half_steps as usize));
        let [early, late] = [early, late].map(|half| half.iter().sum::<i64>());
        WindowSums { all: early + late, slope: late - early }
    }
}

impl Follower {
    /// One that has no target yet.
    pub fn new(plan: TrackPlan, setting: TrackSetting) -> Follower {
        Follower { plan, setting, target: None }
    }

    /// The first phase step of the next window; without a target there is none, and a scan looks for one.
    pub fn window(&self) -> Option<u64> {
        let target = self.target?;
        let later = (target.position >> POSITION_BITS) + target.ahead;
        let first = later - self.plan.half_steps() as i64;
        Some(first.rem_euclid(self.plan.period_steps as i64) as u64)
    }

    /// Where the peak of the target is thought to be, in phase steps.
    pub fn position_steps(&self) -> Option<f64> {
        Some(self.target?.position as f64 / f64::from(1 << POSITION_BITS))
    }

    /// The same as a host reads it: in parts of 2^-8.
    pub fn position(&self) -> Option<u64> {
        Some((self.target?.position >> HIDDEN_BITS) as u64)
    }

    /// Phase steps of the code period.
    pub fn period_steps(&self) -> u64 {
        self.plan.period_steps
    }

    /// Whether the last window had the target's light.
    pub fn is_locked(&self) -> bool {
        self.target.is_some_and(|target| target.is_locked)
    }

    /// A scan has ended whose largest count was at a phase step. A count that is not positive is not a target.
    pub fn found(&mut self, phase_step: u64, count: i64) {
        let found = Target {
            position: (phase_step as i64) << POSITION_BITS,
            owed: 0,
            ahead: 0,
            light: count << self.plan.sample_bits,
            missed: 0,
            is_locked: false,
        };
        self.target = (count > 0).then(|| found.placed());
    }

    /// A window has ended. Returns whether the target has been lost with it, so that a scan has to look for it.
    pub fn counted(&mut self, sums: WindowSums) -> bool {
        let Some(target) = &mut self.target else {
            return false;
        };
        let least = target.light >> self.setting.threshold_halvings;
        target.is_locked = sums.all > 0 && sums.all >= least;
        if !target.is_locked {
            target.missed += 1;
            let is_lost = target.missed >= self.setting.patience;
            self.target = self.target.filter(|_| !is_lost).map(Target::placed);
            return is_lost;
        }
        target.missed = 0;
        target.light += (sums.all - target.light) >> LIGHT_HALVINGS;
        let offset = offset(&self.plan, sums);
        let way = (offset << HIDDEN_BITS) + (target.ahead << POSITION_BITS)
            - HALF_STEP
            - (target.position & FRACTION);
        let moved = target.position + (way >> self.setting.gain_halvings);
        target.position = moved.rem_euclid((self.plan.period_steps as i64) << POSITION_BITS);
        *target = target.placed();
        false
    }
}

impl Target {
    /// The same with the next window in its place: the middle is half a step before the first step of the later half.
    fn placed(self) -> Target {
        let place = (self.position & FRACTION) + HALF_STEP + self.owed;
        Target { ahead: place >> POSITION_BITS, owed: place & FRACTION, ..self }
    }
}

/// How far behind a window's middle the peak is, in parts of 2^-8 of a step; at most half a chip.
fn offset(plan: &TrackPlan, sums: WindowSums) -> i64 {
    let bits = plan.offset_bits();
    let slope = sums.slope.unsigned_abs();
    let all = sums.all.unsigned_abs();
    let most = (1u64 << bits) - 1;
    let size = match slope < all {
        true => ((u128::from(slope) << bits) / u128::from(all)) as u64,
        false => most,
    };
    if sums.slope < 0 { -(size as i64) } else { size as i64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of codes of 31 chips of 8 samples.
    fn plan() -> TrackPlan {
        let setting =
            TrackSetting { is_on: true, gain_halvings: 0, threshold_halvings: 1, patience: 3 };
        TrackPlan { sample_bits: 3, step_bits: 8, period_steps: 248, count_bits: 16, setting }
    }

    /// A window's counts of a triangle that stands at a place, 8000 high.
    fn counts(first: u64, place: f64) -> Vec<i64> {
        let count = |step: u64| {
            let away = (step as f64 - place + 124.0).rem_euclid(248.0) - 124.0;
            (8000.0 * (1.0 - away.abs() / 8.0)).max(0.0).round() as i64
        };
        (first..first + 16).map(count).collect()
    }

    fn following(setting: TrackSetting, phase_step: u64) -> Follower {
        let mut follower = Follower::new(plan(), setting);
        follower.found(phase_step, 8000);
        follower
    }

    fn follow(follower: &mut Follower, place: f64) -> bool {
        let first = follower.window().expect("there is a target");
        follower.counted(WindowSums::of(&counts(first, place), 8))
    }

    /// Within half a step the triangle's place follows from the sums exactly: to 2^-8 of a step, and no nearer. The first
    /// window's middle is half a step before the step that was found.
    #[test]
    fn with_gain_1_a_window_in_its_place_gives_the_peaks_place() {
        for place in [99.0, 99.1, 99.25, 99.5, 99.77, 99.99] {
            let mut follower = following(plan().setting, 100);
            assert!(!follow(&mut follower, place));
            let found = follower.position_steps().expect("there is a target");
            assert!((found - place).abs() < 1.5 / 256.0, "{place}: {found}");
            assert!(follower.is_locked());
        }
    }

    /// A loop of the first order: what is left after n windows is (1 - g)^n of the distance, as long as that is
    /// below half a step.
    #[test]
    fn a_gain_of_a_quarter_leaves_three_quarters_of_the_distance() {
        let mut follower = following(TrackSetting { gain_halvings: 2, ..plan().setting }, 100);
        for n in 1..20 {
            follow(&mut follower, 100.4);
            let left = 100.4 - follower.position_steps().expect("there is a target");
            let expected = 0.4 * 0.75_f64.powi(n);
            assert!((left - expected).abs() < 0.06, "{n}: {left}, expected {expected}");
        }
    }

    /// A target at a constant speed is followed (1 - g) / g windows' way behind.
    #[test]
    fn the_lag_is_that_of_a_loop_of_the_first_order() {
        for (halvings, speed) in [(0, 0.3), (1, 0.2), (2, -0.1)] {
            let setting = TrackSetting { gain_halvings: halvings, ..plan().setting };
            let mut follower = following(setting, 100);
            let mut place = 100.0;
            let mut lags = 0.0;
            for n in 0..200 {
                place += speed;
                follow(&mut follower, place);
                if n >= 100 {
                    lags += (place - follower.position_steps().expect("there is a target")) / 100.0;
                }
            }
            let gain = 0.5_f64.powi(halvings as i32);
            let expected = speed * (1.0 - gain) / gain;
            assert!((lags - expected).abs() < 0.06, "{gain}: {lags}, expected {expected}");
        }
    }

    /// Before step 0 is the last of the code period, whichever way the target goes.
    #[test]
    fn a_target_is_followed_over_the_ends_of_the_code_period() {
        for speed in [0.5, -0.5] {
            let mut follower = following(plan().setting, 2);
            for n in 1..1000 {
                let place = (2.0 + speed * f64::from(n)).rem_euclid(248.0);
                let first = follower.window().expect("there is a target");
                let counts: Vec<i64> =
                    (0..16).map(|step| counts((first + step) % 248, place)[0]).collect();
                assert!(!follower.counted(WindowSums::of(&counts, 8)));
                let found = follower.position_steps().expect("there is a target");
                let error = (found - place + 124.0).rem_euclid(248.0) - 124.0;
                assert!(error.abs() < 0.25, "{n}: {found}, {place}");
                assert!((0.0..248.0).contains(&found));
            }
        }
    }

    #[test]
    fn a_window_without_light_unlocks_and_as_many_as_patience_lose_the_target() {
        let mut follower = following(plan().setting, 100);
        assert!(!follower.is_locked(), "no window has had its light yet");
        follow(&mut follower, 100.5);
        assert!(follower.is_locked());
        let (position, dark) = (follower.position(), WindowSums::default());
        for _ in 0..2 {
            assert!(!follower.counted(dark));
            assert!(!follower.is_locked());
            assert_eq!(follower.position(), position, "it stays where it was");
        }
        // Light again: patience begins anew.
        assert!(!follow(&mut follower, 100.5));
        assert!(follower.is_locked());
        assert!(!follower.counted(dark) && !follower.counted(dark));
        assert!(follower.counted(dark));
        assert_eq!((follower.window(), follower.position()), (None, None));
        assert!(!follower.is_locked());
    }

    /// Light may go down by more than half as long as that takes some windows.
    #[test]
    fn the_light_that_is_expected_follows_the_windows() {
        let mut follower = following(plan().setting, 100);
        let mut light = 64_000;
        while light > 1000 {
            assert!(!follower.counted(WindowSums { all: light, slope: 0 }));
            assert!(follower.is_locked(), "{light}");
            light -= light / 64;
        }
        follower.counted(WindowSums { all: light / 3, slope: 0 });
        assert!(!follower.is_locked());
    }

    #[test]
    fn a_scan_without_a_positive_count_finds_no_target() {
        let mut follower = Follower::new(plan(), plan().setting);
        for count in [0, -5] {
            follower.found(7, count);
            assert_eq!(follower.window(), None);
        }
        follower.found(7, 1);
        assert_eq!(follower.window(), Some(247));
        // Eight steps before step 3, over the period's end.
        follower.found(3, 1);
        assert_eq!(follower.window(), Some(243));
    }

    /// Counts that all steps have in common change the gain, which at one place would turn the position to where the window
    /// happens to be: on average it stays where the peak is, to what the corner of the triangle makes of that.
    #[test]
    fn what_all_steps_have_in_common_leaves_the_mean_position_as_it_is() {
        for common in [-600, 600] {
            for place in [100.0, 100.2, 100.5, 100.8] {
                let mut follower =
                    following(TrackSetting { gain_halvings: 3, ..plan().setting }, 100);
                let (mut sum, mut middles) = (0.0, 0.0);
                for n in 0..1100 {
                    let first = follower.window().expect("there is a target");
                    let counts: Vec<i64> =
                        counts(first, place).iter().map(|count| count + common).collect();
                    follower.counted(WindowSums::of(&counts, 8));
                    if n >= 100 {
                        sum += follower.position_steps().expect("there is a target") / 1000.0;
                        middles += (first as f64 + 7.5) / 1000.0;
                    }
                }
                assert!((sum - place).abs() < 0.03, "{common} {place}: {sum}");
                assert!((middles - sum).abs() < 0.01, "{common} {place}: {middles} {sum}");
            }
        }
    }

    /// A slope that is as large as the sum, or larger, is half a chip.
    #[test]
    fn no_window_moves_by_more_than_half_a_chip() {
        for (all, slope, expected) in
            [(100, 100, 1023), (100, -250, -1023), (100, 99, 1013), (3, -1, -341), (1, 0, 0)]
        {
            assert_eq!(offset(&plan(), WindowSums { all, slope }), expected, "{all} {slope}");
        }
    }
}

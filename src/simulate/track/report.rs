//! What is said of targets that were tracked, beside what theory expects.

use serde::Serialize;
use statrs::distribution::{Binomial, DiscreteCDF as _};

use super::bound::Information;
use super::run::{Course, TrackOutcome};
use super::{DETECTOR, Fastest, Tier, TrackError, Tracking};
use crate::response::MeanResponseError;

/// Standard errors within which a measured value bears an expectation out.
const MOST_ERRORS: f64 = 5.0;
/// Speeds and times are those expected within this share: speeds are tried at 12, of eight targets each.
const ABOUT: f64 = 0.25;
/// Smaller shares of false alarms are not known: tails of counts are not normal.
const LEAST_SHARE: f64 = 1e-6;
/// More false alarms than this share of runs has contradict what is expected.
const SIGNIFICANCE: f64 = 1e-4;
/// What theory leaves out, as a share of a standard deviation: for `expectation_holds`.
const THEORY_SHARE: f64 = 0.1;
/// Updates after a target was taken away by which that has to be told.
const UPDATES_TO_TELL: u32 = 2;

/// How a simulated target was acquired and tracked; distances are those of the target in the middle of a window's time.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct TrackReport {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How counts were got from photons.
    pub fidelity: Tier,
    /// Share of its distance from the peak by which the window moves.
    #[serde(rename = "gain_fraction")]
    pub gain: f64,
    /// Share of the followed light below which a window has lost it.
    #[serde(rename = "threshold_fraction")]
    pub threshold: f64,
    /// Phase steps of a window.
    pub window_steps: u64,
    /// Updates a second.
    pub update_rate_hz: f64,
    /// Targets, each in a run of its own.
    pub targets: u64,
    /// Updates of each, after those in which it settles.
    pub updates: u64,
    /// Those that were acquired.
    pub acquired: u64,
    /// From the first scan's start to the end of the first window with the target's light; mean over the targets.
    pub time_to_lock_s: Option<f64>,
    /// The longest.
    pub longest_time_to_lock_s: Option<f64>,
    /// One scan and one window.
    pub expected_time_to_lock_s: f64,
    /// Speed of the target.
    pub velocity_m_per_s: f64,
    /// Mean error of the position.
    pub bias_m: Option<f64>,
    /// Its standard error.
    pub bias_std_error_m: Option<f64>,
    /// What the exact mean counts lead to: the lag of a target that moves; none of one too fast.
    pub expected_bias_m: Option<f64>,
    /// Standard deviation of the position.
    pub std_m: Option<f64>,
    /// Its standard error.
    pub std_std_error_m: Option<f64>,
    /// What the counts' variance leads to, and the shape of their peak where the window lags behind it; none of a
    /// target that is too fast.
    pub expected_std_m: Option<f64>,
    /// Cramer-Rao bound of a distance from the signed counts of one window, at the middles that windows have.
    pub window_bound_m: f64,
    /// The same if the window had total counts, too.
    pub window_bound_with_totals_m: f64,
    /// The first of the position: of windows that are weighed with (1 - gain)^n.
    pub bound_m: f64,
    /// Standard deviation over that.
    pub std_over_bound: Option<f64>,
    /// Windows of targets that were there, after the first that had their light.
    pub lit_windows: u64,
    /// Those of them that said they had not.
    pub false_alarms: u64,
    /// Their expected share, of a target in the windows' middle.
    pub expected_false_alarm_fraction: f64,
    /// Targets that were lost though they were there.
    pub lost: u64,
    /// Targets that were taken away.
    pub taken_away: u64,
    /// Of these those that were told within two updates, that of the window in which it happened included.
    pub told_in_time: u64,
    /// Most updates that it took; none if some were never told.
    pub most_updates_to_tell: Option<u32>,
    /// Fastest target that was held, with every slower one: of eight each, at 12 speeds.
    pub fastest_m_per_s: f64,
    /// What theory lets one expect.
    pub expected_fastest_m_per_s: f64,
    /// Whether nothing that was measured contradicts what is expected.
    pub expectation_holds: bool,
    /// Wall time.
    pub run_time_s: f64,
}

impl Tracking<'_> {
    pub(super) fn report(
        &self,
        course: &Course,
        outcomes: &[TrackOutcome],
        updates: u64,
        fastest: Fastest,
    ) -> Result<TrackReport, TrackError> {
        let gain = fastest.gain;
        let pitch = course.pitch_chips() as f64;
        let way = course.steps_per_chip * pitch;
        let locks: Vec<f64> =
            outcomes.iter().filter_map(|o| o.locked_chips).map(|c| c as f64).collect();
        let steady = Steady::of(outcomes);
        let expected = match course.steps_per_chip == 0.0 {
            true => self.peak.at_rest(course.place, self.plan),
            false => self.peak.moving(way, Tracking::share_of_step(course), gain),
        };
        let information = self.information(course)?;
        let window_bound_m = self.metres(1.0 / information.signed.sqrt());
        let bound_m = window_bound_m * (gain / (2.0 - gain)).sqrt();
        let threshold = Tracking::gain_of(self.plan.setting.threshold_halvings);
        let metres = |steps: Option<f64>| steps.map(|steps| self.metres(steps));
        let told: Vec<Option<u32>> = outcomes
            .iter()
            .filter(|outcome| outcome.locked_chips.is_some() && !outcome.was_lost)
            .map(|outcome| outcome.updates_to_tell)
            .collect();
        let mut report = TrackReport {
            scene: self.sensor.scene().name.clone(),
            seed: self.seed,
            fidelity: self.tier,
            gain,
            threshold,
            window_steps: course.window_steps,
            update_rate_hz: 1.0 / self.seconds(pitch),
            targets: outcomes.len() as u64,
            updates,
            acquired: locks.len() as u64,
            time_to_lock_s: (!locks.is_empty())
                .then(|| self.seconds(locks.iter().sum::<f64>() / locks.len() as f64)),
            longest_time_to_lock_s: locks.iter().copied().reduce(f64::max).map(|c| self.seconds(c)),
            expected_time_to_lock_s: self
                .seconds((course.search_pitch_chips() + course.window_chips()) as f64),
            velocity_m_per_s: self.velocity(),
            bias_m: metres(steady.map(|steady| steady.bias.0)),
            bias_std_error_m: metres(steady.map(|steady| steady.bias.1)),
            expected_bias_m: metres(expected.map(|expected| expected.bias)),
            std_m: metres(steady.map(|steady| steady.std.0)),
            std_std_error_m: metres(steady.map(|steady| steady.std.1)),
            expected_std_m: metres(expected.map(|expected| expected.std)),
            window_bound_m,
            window_bound_with_totals_m: self.metres(1.0 / information.with_totals.sqrt()),
            bound_m,
            std_over_bound: metres(steady.map(|steady| steady.std.0)).map(|std_m| std_m / bound_m),
            lit_windows: outcomes.iter().map(|outcome| outcome.lit_windows).sum(),
            false_alarms: outcomes.iter().map(|outcome| outcome.false_alarms).sum(),
            expected_false_alarm_fraction: self.peak.false_alarms(threshold),
            lost: outcomes.iter().filter(|outcome| outcome.was_lost).count() as u64,
            taken_away: told.len() as u64,
            told_in_time: told
                .iter()
                .filter(|told| told.is_some_and(|updates| updates <= UPDATES_TO_TELL))
                .count() as u64,
            most_updates_to_tell: told
                .iter()
                .copied()
                .collect::<Option<Vec<u32>>>()
                .and_then(|told| told.into_iter().max()),
            fastest_m_per_s: fastest.held_m_per_s[0],
            expected_fastest_m_per_s: fastest.expected_m_per_s,
            expectation_holds: true,
            run_time_s: 0.0,
        };
        report.expectation_holds = report.holds();
        Ok(report)
    }

    /// What a window tells of a target at rest, on average over the two middles next to it that windows have.
    fn information(&self, course: &Course) -> Result<Information, MeanResponseError> {
        let still = self.sensor.still_at(0.0);
        let before = (course.place - 0.5).floor();
        let of = |middle: f64| {
            let first = (middle + 0.5) as i64 - self.plan.half_steps() as i64;
            let first = first.rem_euclid(course.steps_per_period as i64) as u64;
            Information::of_window(&still, DETECTOR, self.counting(), first, course.window_steps)
        };
        let (near, far) = (of(before + 0.5)?, of(before + 1.5)?);
        let share = course.place - 0.5 - before;
        let mean = |near: f64, far: f64| (1.0 - share) * near + share * far;
        Ok(Information {
            signed: mean(near.signed, far.signed),
            with_totals: mean(near.with_totals, far.with_totals),
        })
    }
}

/// Mean and standard deviation of the error, each with its standard error, in steps.
#[derive(Debug, Clone, Copy)]
struct Steady {
    bias: (f64, f64),
    std: (f64, f64),
}

impl Steady {
    /// Of the updates of targets that were held. Those of one target follow from one another, those of different targets do
    /// not: standard errors are from what differs from target to target. None with fewer than two.
    fn of(outcomes: &[TrackOutcome]) -> Option<Steady> {
        let targets: Vec<&[f64]> = outcomes
            .iter()
            .filter(|outcome| !outcome.was_lost && !outcome.errors.is_empty())
            .map(|outcome| &outcome.errors[..])
            .collect();
        if targets.len() < 2 {
            return None;
        }
        let of_each = |of: &dyn Fn(f64) -> f64| -> (f64, f64) {
            let means = targets.iter().map(|errors| {
                errors.iter().map(|error| of(*error)).sum::<f64>() / errors.len() as f64
            });
            let means: Vec<f64> = means.collect();
            let count = means.len() as f64;
            let mean = means.iter().sum::<f64>() / count;
            let variance =
                means.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (count - 1.0);
            (mean, (variance / count).sqrt())
        };
        let bias = of_each(&|error| error);
        let square = of_each(&|error| (error - bias.0).powi(2));
        let std = square.0.sqrt();
        Some(Steady { bias, std: (std, 0.5 * square.1 / std) })
    }
}

impl TrackReport {
    /// Whether nothing that was measured contradicts what is expected.
    pub(super) fn holds(&self) -> bool {
        let is_near = |measured: Option<f64>, error: Option<f64>, expected: Option<f64>| {
            let known = measured.zip(error).zip(expected).zip(self.expected_std_m);
            known.is_none_or(|(((measured, error), expected), std_m)| {
                (measured - expected).abs() <= MOST_ERRORS * error + THEORY_SHARE * std_m
            })
        };
        let is_about = |measured: f64, expected: f64| (measured / expected - 1.0).abs() <= ABOUT;
        // Some need a second scan.
        let locks = self.time_to_lock_s.is_some_and(|s| s <= 1.5 * self.expected_time_to_lock_s);
        // Of few updates there is no scatter, and nothing to contradict.
        let is_followed = self.bias_m.is_some() || self.lost < self.acquired;
        locks
            && is_followed
            && self.told_in_time == self.taken_away
            && self.alarms_hold()
            && is_about(self.fastest_m_per_s, self.expected_fastest_m_per_s)
            && is_near(self.bias_m, self.bias_std_error_m, self.expected_bias_m)
            && is_near(self.std_m, self.std_std_error_m, self.expected_std_m)
    }

    /// Whether so many false alarms are no more than expected. Of a target that moves the window is not in the middle
    /// of its light, and the share is not known.
    fn alarms_hold(&self) -> bool {
        if self.velocity_m_per_s != 0.0 || self.false_alarms == 0 {
            return true;
        }
        let share = self.expected_false_alarm_fraction.clamp(LEAST_SHARE, 1.0);
        let law = Binomial::new(share, self.lit_windows);
        law.is_ok_and(|law| law.sf(self.false_alarms - 1) > SIGNIFICANCE)
    }
}

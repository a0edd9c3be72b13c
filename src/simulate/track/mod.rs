//! A target that is acquired and then tracked: the rule of the hardware, in whole numbers, or the hardware, with simulated
//! photons in its loop, beside what theory says of it.

mod bound;
mod hardware;
mod plot;
mod run;
mod text;
mod theory;
mod windows;

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{Binomial, DiscreteCDF as _};

use self::bound::Information;
pub use self::hardware::Differs;
use self::hardware::Targets;
use self::run::{Course, Outcome, Run, Scan};
use self::theory::Peak;
use self::windows::Windows;
use super::effort::{self, TooMuch};
use super::scans::{Prepared, ScansError};
use super::{SimulateOptions, Tier};
use crate::cosim::engine::Engine;
use crate::document::Body;
use crate::estimate::coverage::steps_outside;
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m};
use crate::photons::DetectorModel;
use crate::photons::random::scatter;
use crate::reference::predictor::ReferenceError;
use crate::reference::tracking::Follower;
use crate::response::MeanResponseError;
use crate::scene::{DetectorIndex, Movement, PathIndex};
use crate::sensor::Sensor;
use crate::sensor::track::{TrackPlan, TrackSetting};

/// The one detector: scenes that follow targets have no other.
const DETECTOR: DetectorIndex = DetectorIndex(0);
/// Speeds that are tried, as shares of the fastest that theory lets one expect.
const SPEEDS: [f64; 12] = [0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2];
/// Targets of each speed, all of which have to be held.
const TARGETS: u64 = 8;
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

/// Why tracking is not simulated.
#[derive(Debug, thiserror::Error)]
pub enum TrackError {
    /// The scene says nothing of it.
    #[error(
        "the scene follows no target; write track = true, registers = \"axi4-lite\" and peak_detector = true in \
         [hardware]"
    )]
    NotInScene,
    /// A tier without photons.
    #[error(
        "a window goes where its own photons lead it; write --fidelity events, sampled or rtl, not {0}"
    )]
    NotOfTier(Tier),
    /// What is to be followed is not one target.
    #[error(
        "one target is followed, and {0} paths of the reference's own light lead to the detector"
    )]
    NotOnePath(usize),
    /// It is not where the scan looks.
    #[error(
        "the target is {target_m:.3} m away, and the scan looks from {from_m:.3} m to {to_m:.3} m; write another \
         path.distance or scan.steps"
    )]
    OutsideScan {
        /// The target's distance at the first scan's start.
        target_m: f64,
        /// The scan's first phase step.
        from_m: f64,
        /// Its last one.
        to_m: f64,
    },
    /// A path that trembles.
    #[error(
        "the path fluctuates, and what is expected of a window holds at a constant speed; leave out path.fluctuation"
    )]
    Fluctuates,
    /// Expected counts cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// It would take too long.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The hardware could not be clocked.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// It is not modelled.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// It does something else.
    #[error(transparent)]
    Differs(#[from] Differs),
}

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

impl Body for TrackReport {
    const NAME: &'static str = "track";
}

/// The fastest target that is held with one gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fastest {
    /// Share of its distance from the peak by which the window moves.
    pub gain: f64,
    /// Measured, and the next speed, at which some were lost.
    pub held_m_per_s: [f64; 2],
    /// As theory lets one expect.
    pub expected_m_per_s: f64,
}

/// A sensor whose hardware follows a target, ready to be simulated.
pub struct Tracking<'s> {
    sensor: &'s Sensor,
    plan: TrackPlan,
    path: PathIndex,
    tier: Tier,
    engine: Engine,
    seed: u64,
    /// Round its peak at the start of a scan.
    peak: Peak,
}

impl<'s> Tracking<'s> {
    /// Of a sensor.
    ///
    /// # Errors
    /// When its hardware follows nothing, when there is not one target at a constant speed, or where the tier has no
    /// photons.
    pub fn new(sensor: &'s Sensor, options: &SimulateOptions) -> Result<Tracking<'s>, TrackError> {
        let scene = sensor.scene();
        let correlator = sensor.interface().correlator().ok_or(TrackError::NotInScene)?;
        let plan = TrackPlan::of(&scene.hardware, sensor.timing(), correlator.count_bits);
        let plan = plan.ok_or(TrackError::NotInScene)?;
        let tier = options.fidelity;
        if !matches!(tier, Tier::Events | Tier::Sampled | Tier::Rtl) {
            return Err(TrackError::NotOfTier(tier));
        }
        let own: Vec<PathIndex> = scene.own_paths(DETECTOR).collect();
        let &[path] = &own[..] else {
            return Err(TrackError::NotOnePath(own.len()));
        };
        if scene.paths[path].movement.is_some_and(|movement| movement.fluctuation.is_some()) {
            return Err(TrackError::Fluctuates);
        }
        let peak = Peak::new(&sensor.still_at(0.0), DETECTOR, path, tier.counting())?;
        let (engine, seed) = (options.engine, options.seed);
        let tracking = Tracking { sensor, plan, path, tier, engine, seed, peak };
        tracking.check_scan()?;
        Ok(tracking)
    }

    /// Whether the scan comes by the target.
    fn check_scan(&self) -> Result<(), TrackError> {
        let Course { first_step, steps, place, .. } = self.course(0.0);
        let offset_ps = calibration_offset_ps(self.sensor, DETECTOR, self.counting());
        let measured_ps = place * self.sensor.clock().sample_period_ps();
        if steps_outside(self.sensor, measured_ps) == 0.0 {
            return Ok(());
        }
        let of_step = |step: u64| self.metres(step as f64) - distance_m(offset_ps);
        Err(TrackError::OutsideScan {
            target_m: self.metres(place) - distance_m(offset_ps),
            from_m: of_step(first_step),
            to_m: of_step(first_step + steps - 1),
        })
    }

    fn gain_of(halvings: u32) -> f64 {
        0.5_f64.powi(halvings as i32)
    }

    fn setting(&self) -> TrackSetting {
        TrackSetting { is_on: true, ..self.plan.setting }
    }

    fn counting(&self) -> CountingTier {
        self.tier.counting()
    }

    fn metres(&self, steps: f64) -> f64 {
        distance_m(steps * self.sensor.clock().sample_period_ps())
    }

    fn seconds(&self, chips: f64) -> f64 {
        self.sensor.clock().ps(chips) * 1e-12
    }

    fn course(&self, velocity_m_per_s: f64) -> Course {
        let (clock, scan) = (self.sensor.clock(), self.sensor.timing().scan);
        let interface = self.sensor.interface();
        let window_steps = self.plan.window_steps();
        let offset_ps = calibration_offset_ps(self.sensor, DETECTOR, self.counting());
        let delay_ps = self.sensor.scene().paths[self.path].delay_ps + offset_ps;
        Course {
            first_step: scan.first_step,
            steps: scan.steps,
            window_steps,
            integration_chips: scan.integration_chips,
            search_turn_chips: interface.search_turn_chips(),
            turn_chips: interface.window_turn_chips(&self.plan),
            steps_per_period: scan.steps_per_period,
            place: delay_ps / clock.sample_period_ps(),
            steps_per_chip: velocity_m_per_s * self.seconds(1.0) / self.metres(1.0),
        }
    }

    fn velocity(&self) -> f64 {
        self.sensor.scene().paths[self.path].movement.map_or(0.0, |m| m.velocity_m_per_s)
    }

    /// Speed of a target that goes so many steps from window to window.
    fn speed(&self, course: &Course, way: f64) -> f64 {
        self.metres(way) / self.seconds(course.pitch_chips() as f64)
    }

    /// Of what goes from window to window the share that falls into one phase step.
    fn share_of_step(course: &Course) -> f64 {
        course.integration_chips as f64 / course.pitch_chips() as f64
    }

    /// Follows `targets` targets for `updates` updates each.
    ///
    /// # Errors
    /// When that would take too long.
    pub fn track(&self, targets: u64, updates: u64) -> Result<TrackReport, TrackError> {
        let started = Instant::now();
        let setting = self.setting();
        let gain = Tracking::gain_of(setting.gain_halvings);
        let course = self.course(self.velocity());
        // What is left of the scan's distance is (1 - gain)^settling: below a hundredth.
        let settling = (5.0 / gain).ceil() as u64;
        let steps = course.steps + (settling + updates) * course.window_steps;
        self.check_effort(self.tier, targets, steps)?;
        let model = DetectorModel::new(self.sensor, DETECTOR);
        let photons = |number| Windows::new(&model, self.counting(), self.seed, number);
        let outcomes: Vec<Outcome> = (0..targets)
            .into_par_iter()
            .map(|number| {
                let run = Run::new(course, photons(number), Follower::new(self.plan, setting));
                let run = if self.tier == Tier::Rtl { run.read() } else { run };
                run.acquire_and_follow(settling, updates, scatter(self.seed, number))
            })
            .collect();
        if self.tier == Tier::Rtl {
            let scans: Vec<Vec<Scan>> =
                outcomes.iter().map(|outcome| outcome.scans.clone()).collect();
            self.follow_in_verilog(setting, &scans, &photons)?;
        }
        let fastest = self.fastest(setting.gain_halvings)?;
        let report = self.report(&course, &outcomes, updates, fastest)?;
        Ok(TrackReport { run_time_s: started.elapsed().as_secs_f64(), ..report })
    }

    /// Whether the Verilog follows targets with the same photons through the same scans to the same places.
    fn follow_in_verilog<'m>(
        &'m self,
        setting: TrackSetting,
        scans: &'m [Vec<Scan>],
        photons: &'m dyn Fn(u64) -> Windows<'m>,
    ) -> Result<(), TrackError> {
        let interface = self.sensor.interface();
        let registers = interface.registers.as_deref().ok_or(TrackError::NotInScene)?;
        let following = (self.plan, setting);
        let mut targets = Targets::new((interface, registers), following, scans, photons)?;
        let clocks = targets.clocks();
        let prepared = Prepared::new(self.sensor, self.tier, self.engine)?;
        prepared.beside_reference(self.sensor, &mut targets, clocks)?;
        Ok(targets.end()?)
    }

    /// Whether so many runs of so many phase steps are not too much.
    fn check_effort(&self, tier: Tier, runs: u64, steps: u64) -> Result<(), TooMuch> {
        let scans = (runs as f64 * steps as f64 / self.sensor.timing().scan.steps as f64).ceil();
        effort::check(self.sensor, DETECTOR, tier, scans as u64)
    }

    /// The fastest target that is held with a gain of so many halvings.
    ///
    /// # Errors
    /// When it would take too long to find it.
    pub fn fastest(&self, gain_halvings: u32) -> Result<Fastest, TooMuch> {
        let setting = TrackSetting { gain_halvings, ..self.setting() };
        let gain = Tracking::gain_of(gain_halvings);
        let course = self.course(0.0);
        // A lag takes some of the loop's own time to build up.
        let updates = 12 + (12.0 / gain) as u64;
        // Of the Verilog it would take hours, and its windows count what sampled ones do.
        let tier = if self.tier == Tier::Rtl { Tier::Sampled } else { self.tier };
        let runs = SPEEDS.len() as u64 * TARGETS;
        self.check_effort(tier, runs, updates * course.window_steps)?;
        let sign = if self.velocity() < 0.0 { -1.0 } else { 1.0 };
        let threshold = Tracking::gain_of(setting.threshold_halvings);
        let share = Tracking::share_of_step(&course);
        let way = self.peak.fastest(sign, share, gain, threshold);
        let expected = self.speed(&course, way);
        let is_held = |speed: f64| {
            let velocity = sign * speed;
            let sensor = self.sensor.with(|scene| {
                scene.paths[self.path].movement =
                    Some(Movement { velocity_m_per_s: velocity, fluctuation: None });
            });
            let model = DetectorModel::new(&sensor, DETECTOR);
            (0..TARGETS).into_par_iter().all(|number| {
                let windows = Windows::new(&model, self.counting(), self.seed, number);
                let run =
                    Run::new(self.course(velocity), windows, Follower::new(self.plan, setting));
                run.holds(self.peak.height().round() as i64, updates)
            })
        };
        let mut held = [0.0, SPEEDS[0] * expected];
        for share in SPEEDS {
            held[1] = share * expected;
            if !is_held(share * expected) {
                break;
            }
            held[0] = share * expected;
        }
        Ok(Fastest { gain, held_m_per_s: held, expected_m_per_s: expected })
    }

    fn report(
        &self,
        course: &Course,
        outcomes: &[Outcome],
        updates: u64,
        fastest: Fastest,
    ) -> Result<TrackReport, TrackError> {
        let gain = fastest.gain;
        let pitch = course.pitch_chips() as f64;
        let way = course.steps_per_chip * pitch;
        let locks: Vec<f64> =
            outcomes.iter().filter_map(|o| o.locked_chips).map(|c| c as f64).collect();
        let steady = Steady::of(outcomes);
        let expected_bias = match course.steps_per_chip == 0.0 {
            true => Some(self.peak.bias_at_rest(course.place, gain)),
            false => self.peak.lag(way, Tracking::share_of_step(course), gain),
        };
        let expected_std = self.peak.position_std(way, Tracking::share_of_step(course), gain);
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
                .seconds((course.steps * course.integration_chips) as f64 + pitch),
            velocity_m_per_s: self.velocity(),
            bias_m: metres(steady.map(|steady| steady.bias.0)),
            bias_std_error_m: metres(steady.map(|steady| steady.bias.1)),
            expected_bias_m: metres(expected_bias),
            std_m: metres(steady.map(|steady| steady.std.0)),
            std_std_error_m: metres(steady.map(|steady| steady.std.1)),
            expected_std_m: metres(expected_std),
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
    fn of(outcomes: &[Outcome]) -> Option<Steady> {
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
    fn holds(&self) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor(velocity: &str) -> Sensor {
        let scene = "tests/scenes/tracking.toml";
        Sensor::load_with(scene, &[format!("path.velocity={velocity}").parse().expect("a setting")])
            .expect("the scene is valid")
    }

    /// Each against theory. Scatter is told from the exact covariance of counts: at rest, and where the target's way from
    /// window to window is half a step, which makes a window lag by two.
    #[test]
    fn targets_are_tracked_as_theory_says() {
        for (velocity, tier) in [("0 m/s", Tier::Events), ("40 m/s", Tier::Sampled)] {
            let sensor = sensor(velocity);
            let tracking = Tracking::new(&sensor, &tier.scans(1)).expect("it can be simulated");
            let report = tracking.track(24, 64).expect("it is little");
            assert_eq!((report.acquired, report.lost), (24, 0), "{report:#?}");
            assert!(report.expectation_holds, "{velocity} {tier}: {report:#?}");
            // 24 targets by 64 updates, a seventh of which are new: 5 % of a standard deviation.
            let std = report.std_m.zip(report.expected_std_m).expect("it is held");
            assert!((0.85..1.15).contains(&(std.0 / std.1)), "{velocity} {tier}: {report:#?}");
            assert_eq!(report.told_in_time, 24, "{report:#?}");
            assert_eq!(report.false_alarms, 0, "{report:#?}");
            let fastest = report.fastest_m_per_s / report.expected_fastest_m_per_s;
            assert!((0.8..=1.2).contains(&fastest), "{report:#?}");
        }
    }

    /// With gain 1 each window stands for itself: of 1,600 the standard deviation is known to 2 %. The bound knows nothing of
    /// the rule.
    #[test]
    fn a_window_scatters_as_the_bound_of_its_counts() {
        let gain = "hardware.track_gain=\"1\"".parse().expect("a setting");
        let settings = [gain, "path.velocity=0 m/s".parse().expect("a setting")];
        let sensor =
            Sensor::load_with("tests/scenes/tracking.toml", &settings).expect("the scene is valid");
        let tracking =
            Tracking::new(&sensor, &Tier::Sampled.scans(1)).expect("it can be simulated");
        let report = tracking.track(16, 100).expect("it is little");
        let ratio = report.std_over_bound.expect("it was followed");
        assert!((0.95..1.1).contains(&ratio), "{report:#?}");
        assert_eq!(report.bound_m, report.window_bound_m);
        assert!(report.window_bound_with_totals_m < report.window_bound_m, "{report:#?}");
    }

    /// The Verilog beside the reference model, with the same photons, and a host that reads: with gain 1 a host's 2^-8 of a step are
    /// all that it leaves out of the positions. That nothing is left of a place that is another one shows that they are compared.
    #[test]
    fn the_verilog_follows_the_same_targets_to_the_same_places() {
        let setting = |text: &str| text.parse().expect("a setting");
        let settings = [
            setting("path.velocity=40 m/s"),
            setting("hardware.track_gain=\"1\""),
            setting("scan.integration=\"16.376 us\""),
            setting("source.mean_power=\"25 pW\""),
        ];
        let sensor =
            Sensor::load_with("tests/scenes/tracking.toml", &settings).expect("the scene is valid");
        let of = |tier: Tier| {
            let tracking = Tracking::new(&sensor, &tier.scans(1)).expect("it can be simulated");
            tracking.track(2, 6).unwrap_or_else(|error| panic!("{error}"))
        };
        let (sampled, rtl) = (of(Tier::Sampled), of(Tier::Rtl));
        assert_eq!((rtl.acquired, rtl.lost, rtl.told_in_time), (2, 0, 2), "{rtl:#?}");
        assert_eq!(rtl.time_to_lock_s, sampled.time_to_lock_s);
        let step_m = distance_m(1000.0);
        let (read, exact) = rtl.bias_m.zip(sampled.bias_m).expect("it was followed");
        assert!((0.0..step_m / 256.0).contains(&(exact - read)), "{read} {exact}");

        let tracking = Tracking::new(&sensor, &Tier::Rtl.scans(1)).expect("it can be simulated");
        let model = DetectorModel::new(&sensor, DETECTOR);
        let photons = |number| Windows::new(&model, CountingTier::Sampled, tracking.seed, number);
        let follower = Follower::new(tracking.plan, tracking.setting());
        let run = Run::new(tracking.course(40.0), photons(0), follower).read();
        let mut scans = run.acquire_and_follow(1, 1, 0).scans;
        let place = scans[2].after.position.as_mut().expect("it is followed");
        *place += 1;
        let refused = tracking.follow_in_verilog(tracking.setting(), &[scans], &photons);
        let said = refused.expect_err("another place is told").to_string();
        assert!(said.starts_with("target 0, scan 2: the hardware shows"), "{said}");
    }

    /// A report contradicts itself where a target at rest is lost in one window of ten, or is never followed, or takes
    /// three scans to be found.
    #[test]
    fn what_theory_does_not_expect_does_not_hold() {
        let tracking = sensor("0 m/s");
        let tracking =
            Tracking::new(&tracking, &Tier::Events.scans(1)).expect("it can be simulated");
        let report = tracking.track(8, 16).expect("it is little");
        assert!(report.holds(), "{report:#?}");
        let lost = TrackReport { false_alarms: report.lit_windows / 10, ..report.clone() };
        let slow = TrackReport {
            time_to_lock_s: report.time_to_lock_s.map(|s| 3.0 * s),
            ..report.clone()
        };
        let nowhere = TrackReport { bias_m: None, lost: report.acquired, ..report.clone() };
        let few = TrackReport { bias_m: None, ..report.clone() };
        assert!(few.holds(), "{few:#?}");
        let faster =
            TrackReport { fastest_m_per_s: 2.0 * report.fastest_m_per_s, ..report.clone() };
        let unknown = TrackReport { expected_fastest_m_per_s: f64::NAN, ..report.clone() };
        for wrong in [lost, slow, nowhere, faster, unknown] {
            assert!(!wrong.holds(), "{wrong:#?}");
        }
    }

    #[test]
    fn what_is_not_simulated_is_refused_by_name() {
        let refused = |sensor: &Sensor, tier: Tier| match Tracking::new(sensor, &tier.scans(1)) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        };
        let moving = sensor("1 m/s");
        assert!(
            refused(&moving, Tier::Counts)
                .contains("--fidelity events, sampled or rtl, not counts")
        );
        let far = moving.with(|scene| scene.paths[0].delay_ps += 100e3);
        assert!(refused(&far, Tier::Events).contains("and the scan looks from"));
        let none = moving.with(|scene| scene.hardware.track = false);
        assert!(refused(&none, Tier::Events).contains("track = true"));
        let two = moving.with(|scene| scene.paths.push(scene.paths[0].clone()));
        assert!(refused(&two, Tier::Events).contains("2 paths"));
    }
}

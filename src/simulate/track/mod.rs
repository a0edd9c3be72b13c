//! A target that is acquired and then tracked: the rule of the hardware, in whole numbers, or the hardware, with simulated
//! photons in its loop, beside what theory says of it.

mod bound;
mod hardware;
mod plot;
mod report;
mod run;
mod text;
mod theory;
mod windows;

use std::time::Instant;

use rayon::prelude::*;

pub use self::hardware::Differs;
use self::hardware::Targets;
pub use self::report::TrackReport;
use self::run::{Course, TrackOutcome, TrackRun, TrackedScan};
use self::theory::MeanPeak;
use self::windows::{TargetLight, Windows};
use super::effort::{self, TooMuch};
use super::scans::{PreparedTier, ScansError};
use super::{SimulateOptions, Tier};
use crate::cosim::engine::Engine;
use crate::estimate::coverage::steps_outside;
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m};
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

/// Share of the first windows behind a scan that may be taken for dark, or ten times the share of later ones.
const MOST_FIRST_DARK: f64 = 0.01;

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
    /// Windows behind a scan are taken for dark.
    #[error(
        "behind a scan the first window is expected to add up to the samples of a chip times the peak's count, of which \
         it has {light:.2} (beside its peak an interleaved code counts down): {:.1} % of first windows are taken for dark \
         at a hardware.track_threshold of {threshold}; write a smaller one, or source.code.interleave = 0", 100.0 * share
    )]
    FirstWindowDark {
        /// Light of a window with the target in its middle, over what is expected of it.
        light: f64,
        /// Share of that below which a window is dark.
        threshold: f64,
        /// Share of the windows that are.
        share: f64,
    },
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
    peak: MeanPeak,
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
        let peak = MeanPeak::new(&sensor.still_at(0.0), DETECTOR, path, tier.counting(sensor))?;
        let (engine, seed) = (options.engine, options.seed);
        let tracking = Tracking { sensor, plan, path, tier, engine, seed, peak };
        tracking.check_scan()?;
        tracking.check_first_window()?;
        Ok(tracking)
    }

    /// Whether the first window behind a scan is taken for dark hardly more often than others are.
    fn check_first_window(&self) -> Result<(), TrackError> {
        let threshold = Tracking::gain_of(self.plan.setting.threshold_halvings);
        let (share, light) = self.peak.first_alarms(threshold);
        match share > (10.0 * self.peak.false_alarms(threshold)).max(MOST_FIRST_DARK) {
            true => Err(TrackError::FirstWindowDark { light, threshold, share }),
            false => Ok(()),
        }
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
        self.tier.counting(self.sensor)
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
        let light = TargetLight::of(self.sensor, DETECTOR);
        let counters = light.counters();
        let photons = |number| Windows::new(&counters, self.counting(), self.seed, number);
        let outcomes: Vec<TrackOutcome> = (0..targets)
            .into_par_iter()
            .map(|number| {
                let run = TrackRun::new(course, photons(number), Follower::new(self.plan, setting));
                let run = if self.tier == Tier::Rtl { run.read() } else { run };
                run.acquire_and_follow(settling, updates, scatter(self.seed, number))
            })
            .collect();
        if self.tier == Tier::Rtl {
            let scans: Vec<Vec<TrackedScan>> =
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
        scans: &'m [Vec<TrackedScan>],
        photons: &'m dyn Fn(u64) -> Windows<'m>,
    ) -> Result<(), TrackError> {
        let interface = self.sensor.interface();
        let registers = interface.registers.as_deref().ok_or(TrackError::NotInScene)?;
        let following = (self.plan, setting);
        let mut targets = Targets::new((interface, registers), following, scans, photons)?;
        let clocks = targets.clocks();
        let prepared = PreparedTier::new(self.sensor, self.tier, self.engine)?;
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
            let light = TargetLight::of(&sensor, DETECTOR);
            let counters = light.counters();
            (0..TARGETS).into_par_iter().all(|number| {
                let windows = Windows::new(&counters, self.counting(), self.seed, number);
                let run = TrackRun::new(
                    self.course(velocity),
                    windows,
                    Follower::new(self.plan, setting),
                );
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
            let targets = optics_support::repeated(12, 24);
            let report = tracking.track(targets, 64).expect("it is little");
            assert_eq!((report.acquired, report.lost), (targets, 0), "{report:#?}");
            assert!(report.expectation_holds, "{velocity} {tier}: {report:#?}");
            // 12 targets by 64 updates, a seventh of which are new: 7 % of a standard deviation.
            let std = report.std_m.zip(report.expected_std_m).expect("it is held");
            assert!((0.85..1.15).contains(&(std.0 / std.1)), "{velocity} {tier}: {report:#?}");
            assert_eq!(report.told_in_time, targets, "{report:#?}");
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

    /// In bright light the order of the windows' middles is fixed, and no noise: taken for noise, the scatter was told to be 3.45 mm,
    /// where 64 targets of 100 updates have 4.07 +- 0.04.
    #[test]
    fn a_bright_target_at_rest_scatters_as_expected() {
        let settings = ["path.velocity=0 m/s", "source.mean_power=80 pW"];
        let settings = settings.map(|text| text.parse().expect("a setting"));
        let sensor =
            Sensor::load_with("tests/scenes/tracking.toml", &settings).expect("the scene is valid");
        let tracking =
            Tracking::new(&sensor, &Tier::Sampled.scans(1)).expect("it can be simulated");
        let expected = tracking.peak.at_rest(tracking.course(0.0).place, tracking.plan);
        let expected_mm = 1e3 * tracking.metres(expected.expect("it is held").std);
        assert!((3.95..4.19).contains(&expected_mm), "{expected_mm}");
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
        let light = TargetLight::of(&sensor, DETECTOR);
        let counters = light.counters();
        let photons =
            |number| Windows::new(&counters, CountingTier::Sampled, tracking.seed, number);
        let follower = Follower::new(tracking.plan, tracking.setting());
        let run = TrackRun::new(tracking.course(40.0), photons(0), follower).read();
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

    /// Beside the peak of a code that is interleaved once counts fall by 3/2 of it a chip: the mean over two chips is a
    /// quarter of the peak, half of a triangle's. That is the threshold, so that half of first windows are taken for dark.
    #[test]
    fn an_interleaved_codes_first_windows_need_a_lower_threshold() {
        let of = |threshold: &str| {
            let settings = [
                "path.velocity=0 m/s",
                "source.code={ family = \"gold\", degree = 7, index = 3, interleave = 1 }",
                "source.mean_power=25 pW",
                "scan.integration=5.08 us",
                &format!("hardware.track_threshold=\"{threshold}\""),
            ]
            .map(|setting| setting.parse().expect("a setting"));
            let sensor = Sensor::load_with("tests/scenes/tracking.toml", &settings);
            let sensor = sensor.expect("the scene is valid");
            Tracking::new(&sensor, &Tier::Events.scans(1)).map(|_| ())
        };
        let refused = of("1/2").expect_err("half of first windows");
        let TrackError::FirstWindowDark { light, share, .. } = refused else { panic!("{refused}") };
        assert!((light - 0.5).abs() < 0.05 && (0.05..0.95).contains(&share), "{light} {share}");
        assert!(of("1/4").is_ok());
    }
}

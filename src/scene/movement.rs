//! Paths whose length changes in time (eq. 7).

use super::read::Clock;
use super::reader::{Bounds, Section};
use super::source::round_trip_ps;
use super::units::Quantity;
use super::{Path, Scene};
use crate::SPEED_OF_LIGHT_M_PER_S;

/// How the distance of a path changes: a constant speed, a random fluctuation,
/// or both. Every scan starts at the path's own distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Movement {
    /// Change of the distance; positive is away from the sensor.
    pub velocity_m_per_s: f64,
    /// What the distance does at random beside that.
    pub fluctuation: Option<Fluctuation>,
}

/// A stationary Gaussian fluctuation of the distance whose correlation decays
/// exponentially (an Ornstein-Uhlenbeck process).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluctuation {
    /// Standard deviation of the distance.
    pub std_m: f64,
    /// Time after which the correlation is 1/e.
    pub correlation_time_ps: f64,
}

/// Largest speed, as a share of the speed of light.
const LARGEST_SPEED_SHARE: f64 = 1e-3;
/// Largest ratio of a fluctuation's standard deviation and correlation time, as
/// a share of the speed of light: light must not overtake itself.
const LARGEST_FLUCTUATION_SHARE: f64 = 1e-5;
/// A fluctuation is followed from chip to chip, and needs some of them.
const LEAST_CORRELATION_CHIPS: f64 = 16.0;
/// Longer than this a fluctuation stands still.
const MOST_CORRELATION_CHIPS: f64 = (1_u64 << 50) as f64;
/// A fluctuating path is at least so many standard deviations long.
const LEAST_DISTANCE_SIGMAS: f64 = 6.0;

impl Movement {
    /// Whether nothing moves.
    pub fn is_neutral(&self) -> bool {
        self.velocity_m_per_s == 0.0 && self.fluctuation.is_none_or(|f| f.std_m == 0.0)
    }
}

impl Path {
    /// Change of the mean time of flight per time, 2 v / c.
    pub fn delay_rate(&self) -> f64 {
        self.movement
            .map_or(0.0, |m| 2.0 * m.velocity_m_per_s / SPEED_OF_LIGHT_M_PER_S)
    }

    /// Mean time of flight at a time after the start of a scan: without the
    /// fluctuation.
    pub fn delay_ps_at(&self, time_ps: f64) -> f64 {
        self.delay_ps + self.delay_rate() * time_ps
    }

    /// Standard deviation of the time of flight.
    pub fn delay_std_ps(&self) -> f64 {
        let fluctuation = self.movement.and_then(|movement| movement.fluctuation);
        fluctuation.map_or(0.0, |f| round_trip_ps(f.std_m))
    }
}

impl Scene {
    /// The scene with every path standing still where it is, without its
    /// fluctuation, at a time after the start of a scan.
    pub fn still_at(&self, time_ps: f64) -> Scene {
        let mut still = self.clone();
        for path in &mut still.paths {
            path.delay_ps = path.delay_ps_at(time_ps);
            path.movement = None;
        }
        still
    }

    /// Time from the start of a scan to the middle of its step number `step`, or
    /// of the group of `parallel` steps that it belongs to.
    pub fn middle_of_step_ps(&self, step: u64) -> f64 {
        let group = step / u64::from(self.hardware.parallel);
        (group as f64 + 0.5) * self.step_duration_ps()
    }

    /// Integration time of a phase step, in whole chips.
    pub fn step_duration_ps(&self) -> f64 {
        self.scan.integration_chips as f64 * self.chip_period_ps
    }

    /// Duration of a scan.
    pub(super) fn scan_duration_ps(&self) -> f64 {
        let groups = self.scan.steps.div_ceil(u64::from(self.hardware.parallel));
        groups as f64 * self.step_duration_ps()
    }
}

/// The movement of a path; `None` for one that stands still.
pub(super) fn read(path: &Section, clock: Option<Clock>) -> Option<Movement> {
    let velocity = path.quantity("velocity", Quantity::Speed, Bounds::Any, "1.5 m/s");
    let limit = LARGEST_SPEED_SHARE * SPEED_OF_LIGHT_M_PER_S;
    if velocity.is_some_and(|velocity| velocity.abs() > limit) {
        let message = format!(
            "more than a thousandth of the speed of light; write at most \"{:.0} km/s\"",
            (limit / 1e3).floor()
        );
        path.report("velocity", &message);
    }
    let movement = Movement {
        velocity_m_per_s: velocity.unwrap_or(0.0),
        fluctuation: read_fluctuation(path, clock),
    };
    (!movement.is_neutral()).then_some(movement)
}

fn read_fluctuation(path: &Section, clock: Option<Clock>) -> Option<Fluctuation> {
    const EXAMPLE: &str = "{ std = \"2 mm\", correlation_time = \"1 ms\" }";
    const TIME: &str = "correlation_time";
    let section = path.section("fluctuation", EXAMPLE)?;
    section.require("std", "\"2 mm\"");
    section.require(TIME, "\"1 ms\"");
    let std_m = section.quantity("std", Quantity::Distance, Bounds::NotNegative, "2 mm");
    let time_ps = section.quantity(TIME, Quantity::Time, Bounds::Positive, "1 ms");
    if let (Some(time_ps), Some(clock)) = (time_ps, clock) {
        let chips = time_ps / clock.chip_period_ps;
        if !(LEAST_CORRELATION_CHIPS..=MOST_CORRELATION_CHIPS).contains(&chips) {
            let message = format!(
                "{chips:.3e} chip periods; a fluctuation is followed with \
                 {LEAST_CORRELATION_CHIPS} to {MOST_CORRELATION_CHIPS:.1e}"
            );
            section.report(TIME, &message);
        }
    }
    if let (Some(std_m), Some(time_ps)) = (std_m, time_ps) {
        let speed = std_m / (time_ps * 1e-12);
        let limit = LARGEST_FLUCTUATION_SHARE * SPEED_OF_LIGHT_M_PER_S;
        if speed > limit {
            let message = format!(
                "so large a fluctuation in the correlation time is {:.3e} m/s; \
                 at most {limit:.0} m/s are followed",
                speed
            );
            section.report("std", &message);
        }
    }
    section.finish();
    Some(Fluctuation {
        std_m: std_m?,
        correlation_time_ps: time_ps?,
    })
}

/// Reports paths that come to the sensor, or behind it, within a scan.
pub(super) fn check_distances(sections: &[Section], scene: &Scene) {
    let scan_s = scene.scan_duration_ps() * 1e-12;
    for (section, path) in sections.iter().zip(&scene.paths) {
        let Some(movement) = path.movement else {
            continue;
        };
        let start_m = path.distance_m();
        let end_m = start_m + movement.velocity_m_per_s * scan_s;
        if end_m < 0.0 {
            let message = format!(
                "the target reaches the sensor after {:.4} s, before the scan of {scan_s:.4} s \
                 ends; start farther away, or scan fewer steps",
                -start_m / movement.velocity_m_per_s
            );
            section.report("velocity", &message);
            continue;
        }
        let least_m = LEAST_DISTANCE_SIGMAS * movement.fluctuation.map_or(0.0, |f| f.std_m);
        let nearest_m = start_m.min(end_m);
        if nearest_m < least_m {
            let message = format!(
                "the path comes as near as {nearest_m:.4} m within a scan; with this fluctuation \
                 it must keep {LEAST_DISTANCE_SIGMAS} standard deviations, {least_m:.4} m"
            );
            section.report("fluctuation", &message);
        }
    }
}

//! Paths whose length changes in time (eq. 7).

use super::keys::declare::*;
use super::{Path, Scene};
use crate::light::{SPEED_OF_LIGHT_M_PER_S, round_trip_ps};
use crate::scan::Clock;

/// How the distance of a path changes: a constant speed, a random fluctuation,
/// or both. Every scan starts at the path's own distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Movement {
    /// Change of the distance; positive is away from the sensor.
    pub velocity_m_per_s: f64,
    /// What the distance does at random beside that.
    pub fluctuation: Option<Fluctuation>,
}

tables! {
    /// A stationary Gaussian fluctuation of the distance whose correlation decays
    /// exponentially (an Ornstein-Uhlenbeck process).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Fluctuation {}
    of FLUCTUATION = "path.fluctuation" {
        std => std_m: f64 = quantity(Distance, "0 m", "1000 km"), Needed, "2 mm";
            "standard deviation of the distance"
            "light must not overtake itself: see what depends on several keys";
        correlation_time => correlation_time_ps: f64 = quantity(Time, "16 ps", "10000 h"), Needed, "1 ms";
            "time after which the correlation is 1/e"
            "16 of the shortest chips; a year";
    }
}

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
        self.movement.map_or(0.0, |m| 2.0 * m.velocity_m_per_s / SPEED_OF_LIGHT_M_PER_S)
    }

    /// Mean time of flight at a time after the start of a scan: eq. 7 without the
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
}

const TIME: &str = "correlation_time";

/// The movement of a path; `None` for one that stands still.
pub(super) fn read(path: &Section, clock: Option<Clock>) -> Option<Movement> {
    let velocity = path.quantity("velocity");
    let fluctuation = read_fluctuation(path, clock);
    let movement = Movement { velocity_m_per_s: velocity?, fluctuation };
    (!movement.is_neutral()).then_some(movement)
}

/// Reports a value that is out of range; `advice` is a right one.
fn refuse(section: &Section, key: &'static str, what: &str, advice: &str) {
    if let Some(value) = section.get(key) {
        let message = format!("{} is {what}; write {advice}", section.excerpt(value));
        section.report_at(key, value, &message);
    }
}

fn read_fluctuation(path: &Section, clock: Option<Clock>) -> Option<Fluctuation> {
    let section = path.section("fluctuation")?;
    let fluctuation = Fluctuation::keys(&section);
    if let Some(Fluctuation { std_m, correlation_time_ps }) = fluctuation {
        if let Some(clock) = clock {
            check_time(&section, correlation_time_ps, clock);
        }
        let most_m =
            LARGEST_FLUCTUATION_SHARE * SPEED_OF_LIGHT_M_PER_S * correlation_time_ps * 1e-12;
        if std_m > most_m {
            let what = "too much for so short a correlation time";
            let advice =
                format!("at most \"{:.0} um\", or a longer `{TIME}`", (most_m * 1e6).floor());
            refuse(&section, "std", what, &advice);
        }
    }
    section.finish();
    fluctuation
}

/// Reports a correlation time that cannot be followed from chip to chip.
fn check_time(section: &Section, correlation_time_ps: f64, clock: Clock) {
    let chips = clock.chips(correlation_time_ps);
    if chips < LEAST_CORRELATION_CHIPS {
        let least_ns = clock.ps(LEAST_CORRELATION_CHIPS) / 1e3;
        let what = format!("shorter than {LEAST_CORRELATION_CHIPS} chips");
        refuse(section, TIME, &what, &format!("at least \"{} ns\"", least_ns.ceil()));
    } else if chips > MOST_CORRELATION_CHIPS {
        let most_h = clock.ps(MOST_CORRELATION_CHIPS) / 3600e12;
        let advice = format!("at most \"{:.0} h\"", most_h.floor());
        refuse(section, TIME, "longer than 2^50 chips", &advice);
    }
}

/// Reports paths that come to the sensor, or behind it, within a scan.
pub(super) fn check_distances(sections: &[Section], scene: &Scene) {
    let scan_s = scene.timing().scan_duration_ps() * 1e-12;
    let ms = |seconds: f64| seconds * 1e3;
    for (section, path) in sections.iter().zip(&scene.paths) {
        let Some(movement) = path.movement else {
            continue;
        };
        let start_m = path.distance_m();
        let end_m = start_m + movement.velocity_m_per_s * scan_s;
        if end_m < 0.0 {
            let message = format!(
                "the target reaches the sensor after {:.3} ms, before the scan of {:.3} ms \
                 ends; start farther away, or scan fewer steps",
                ms(-start_m / movement.velocity_m_per_s),
                ms(scan_s)
            );
            section.report("velocity", &message);
            continue;
        }
        let least_m = LEAST_DISTANCE_SIGMAS * movement.fluctuation.map_or(0.0, |f| f.std_m);
        let nearest_m = start_m.min(end_m);
        if nearest_m < least_m {
            let message = format!(
                "the path comes as near as {nearest_m:.4} m within a scan; with this fluctuation \
                 it must keep {LEAST_DISTANCE_SIGMAS} standard deviations, {least_m:.4} m; write a \
                 std of at most \"{:.0} um\", or start farther away",
                (nearest_m / LEAST_DISTANCE_SIGMAS * 1e6).floor()
            );
            section.report("fluctuation", &message);
        }
    }
}

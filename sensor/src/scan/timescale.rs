//! Whole numbers of a unit of time for the edges of a clock, as simulators and
//! waveforms want them.

use std::fmt;

use super::timing::Clock;

/// Femtoseconds of the units that simulators know, from the longest that is of use; any
/// of them may be taken once, ten or a hundred times.
const UNITS_FS: [(&str, u64); 4] =
    [("us", 1_000_000_000), ("ns", 1_000_000), ("ps", 1000), ("fs", 1)];
const MULTIPLES: [u64; 3] = [100, 10, 1];
/// Whole numbers up to here are the same in a double.
const MOST_EXACT: f64 = 9_007_199_254_740_992.0;

/// The unit in which the time of a clock's edges is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timescale {
    /// How often the unit: 1, 10 or 100.
    pub multiple: u32,
    /// The unit: `us`, `ns`, `ps` or `fs`.
    pub unit: &'static str,
    /// Clock periods in it.
    period: f64,
    /// Whether half a period is a whole number of it.
    is_exact: bool,
}

impl Timescale {
    /// The longest unit of which half a chip period is a whole number; if there is none,
    /// or the end of `clocks` clocks would be beyond what viewers count to, the shortest
    /// in which that end can be told.
    pub fn of(clock: Clock, clocks: u64) -> Timescale {
        let exact = Timescale::all(clock).find(|scale| scale.is_exact && scale.reaches(clocks));
        let rounded = || {
            let mut shortest = Timescale::all(clock).filter(|scale| scale.multiple == 1);
            let longest = shortest.next();
            shortest.filter(|scale| scale.reaches(clocks)).last().or(longest)
        };
        exact.or_else(rounded).unwrap_or(Timescale {
            multiple: 1,
            unit: "fs",
            period: clock.chip_period_ps * 1e3,
            is_exact: false,
        })
    }

    /// From the longest to the shortest.
    fn all(clock: Clock) -> impl Iterator<Item = Timescale> {
        let period_fs = clock.chip_period_ps * 1e3;
        UNITS_FS.iter().flat_map(move |&(unit, fs)| {
            MULTIPLES.iter().map(move |&multiple| {
                let period = period_fs / (fs * multiple) as f64;
                Timescale {
                    multiple: multiple as u32,
                    unit,
                    period,
                    is_exact: (period / 2.0).fract() == 0.0 && period >= 2.0,
                }
            })
        })
    }

    fn reaches(&self, clocks: u64) -> bool {
        (clocks as f64 + 1.0) * self.period < MOST_EXACT
    }

    /// Whether every edge is at a whole number of the unit, and not rounded to it.
    pub fn is_exact(&self) -> bool {
        self.is_exact
    }

    /// Clock periods in the unit, rounded to a whole number.
    pub fn period(&self) -> u64 {
        self.period.round() as u64
    }

    /// The time after so many halves of a clock period, rounded to a whole number.
    pub fn after_halves(&self, halves: u64) -> u64 {
        // Exact up to 2^53, and times end there.
        (halves as f64 * (self.period / 2.0)).round() as u64
    }
}

impl fmt::Display for Timescale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.multiple, self.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(chip_period_ps: f64, clocks: u64) -> Timescale {
        let clock = Clock { chip_period_ps, samples_per_chip: 1 };
        Timescale::of(clock, clocks)
    }

    #[test]
    fn half_a_period_is_a_whole_number_of_the_longest_unit_that_can() {
        for (period_ps, unit, half) in [
            (8000.0, "1 ns", 4),
            (10_000.0, "1 ns", 5),
            (20_000.0, "10 ns", 1),
            (5000.0, "100 ps", 25),
            (8001.0, "100 fs", 40_005),
            (1.0, "100 fs", 5),
            (0.002, "1 fs", 1),
            (1e10, "100 us", 50),
            (2500.5, "10 fs", 125_025),
        ] {
            let scale = scale(period_ps, 1 << 20);
            assert_eq!(scale.to_string(), unit, "{period_ps}");
            assert!(scale.is_exact());
            let halves = [0, 1, 2, 3, 1_000_001];
            assert_eq!(
                halves.map(|n| scale.after_halves(n)),
                halves.map(|n| n * half),
                "{period_ps}"
            );
        }
    }

    #[test]
    fn what_is_no_whole_number_is_rounded_and_does_not_drift() {
        // 300 MHz.
        let period = scale(1e4 / 3.0, 1000);
        assert_eq!(period.to_string(), "1 fs");
        assert!(!period.is_exact());
        assert_eq!(period.period(), 3_333_333);
        assert_eq!(period.after_halves(1), 1_666_667);
        assert_eq!(period.after_halves(6), 10_000_000);
        assert_eq!(period.after_halves(6_000_000), 10_000_000_000_000);
    }

    #[test]
    fn a_long_run_is_told_in_a_unit_that_reaches_its_end() {
        for (period_ps, clocks) in [(1e4 / 3.0, 1 << 50), (8001.0, 1 << 50), (1.0, 1 << 50)] {
            let scale = scale(period_ps, clocks);
            let end = scale.after_halves(2 * clocks);
            assert!(end < 1 << 53, "{period_ps}: {end}");
            assert!(end > 1 << 30, "{period_ps}: {end}");
        }
    }
}

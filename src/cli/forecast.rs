//! Run time forecasts of long jobs.

use std::time::Instant;

use super::output::CommandOutput;

/// Anything longer is announced.
const LONG_S: f64 = 10.0;
/// A rate is measured over so long.
const TRIAL_S: f64 = 0.3;

/// Announces a job of `seconds`, if that is long.
pub(super) fn announce(output: &CommandOutput, what: &str, seconds: f64) {
    if seconds > LONG_S {
        output.note(&format!("{what} will take about {}", duration(seconds)));
    }
}

/// Forecasts a job from the rate of its first parts.
pub(super) struct Forecast<'o> {
    output: &'o CommandOutput,
    what: &'static str,
    started: Instant,
    trial: Trial,
}

impl<'o> Forecast<'o> {
    pub fn new(output: &'o CommandOutput, what: &'static str) -> Forecast<'o> {
        Forecast { output, what, started: Instant::now(), trial: Trial::NotBegun }
    }

    /// `done` parts `of` all are done.
    pub fn progress(&mut self, done: u64, of: u64) {
        let now_s = self.started.elapsed().as_secs_f64();
        if let Some(seconds) = self.trial.seconds_in_all(now_s, done, of) {
            announce(self.output, self.what, seconds);
        }
    }
}

/// Rate of the first parts. Time before the first, as of building a model, does not count.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Trial {
    NotBegun,
    Since { at_s: f64, done: u64 },
    Told,
}

impl Trial {
    /// How long all takes, once, when it is known.
    fn seconds_in_all(&mut self, now_s: f64, done: u64, of: u64) -> Option<f64> {
        match *self {
            Trial::NotBegun if done > 0 => *self = Trial::Since { at_s: now_s, done },
            Trial::Since { at_s, done: before } if now_s - at_s >= TRIAL_S && done > before => {
                *self = Trial::Told;
                return Some((now_s - at_s) * of as f64 / (done - before) as f64);
            }
            _ => {}
        }
        None
    }
}

/// A duration for people.
fn duration(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        ..7200.0 => format!("{:.0} min", seconds / 60.0),
        ..172_800.0 => format!("{:.0} h", seconds / 3600.0),
        ..6.3e7 => format!("{:.0} days", seconds / 86_400.0),
        _ => format!("{:.0} years", seconds / 31_557_600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model that takes a minute to build clocks 1 % in a second, from its first block on.
    #[test]
    fn what_comes_before_the_first_part_is_not_forecast() {
        let mut trial = Trial::NotBegun;
        assert_eq!(trial.seconds_in_all(0.0, 0, 1000), None);
        assert_eq!(trial.seconds_in_all(60.0, 10, 1000), None);
        assert_eq!(trial.seconds_in_all(60.2, 12, 1000), None);
        assert_eq!(trial.seconds_in_all(61.0, 20, 1000), Some(100.0));
        assert_eq!(trial.seconds_in_all(62.0, 30, 1000), None);
    }

    #[test]
    fn durations_are_in_the_unit_that_people_use() {
        for (seconds, text) in [
            (12.4, "12 s"),
            (600.0, "10 min"),
            (7_300.0, "2 h"),
            (864_000.0, "10 days"),
            (1e10, "317 years"),
        ] {
            assert_eq!(duration(seconds), text);
        }
    }
}

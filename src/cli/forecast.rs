//! Says how long something will take, where that is long.

use std::time::Instant;

use super::output::Output;

/// Anything longer is announced.
const LONG_S: f64 = 10.0;
/// What has run for so long tells how long it will.
const TRIAL_S: f64 = 0.3;

/// Announces something that takes `seconds`, if that is long.
pub(super) fn announce(output: &Output, what: &str, seconds: f64) {
    if seconds > LONG_S {
        output.note(&format!("{what} will take about {}", duration(seconds)));
    }
}

/// Announces something by the rate of its first part.
pub(super) struct Forecast<'o> {
    output: &'o Output,
    what: &'static str,
    started: Instant,
    told: bool,
}

impl<'o> Forecast<'o> {
    pub fn new(output: &'o Output, what: &'static str) -> Forecast<'o> {
        Forecast { output, what, started: Instant::now(), told: false }
    }

    /// `done` parts `of` all are done.
    pub fn progress(&mut self, done: u64, of: u64) {
        let elapsed_s = self.started.elapsed().as_secs_f64();
        if self.told || done == 0 || elapsed_s < TRIAL_S {
            return;
        }
        self.told = true;
        announce(self.output, self.what, elapsed_s * of as f64 / done as f64);
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

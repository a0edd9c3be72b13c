//! What a dead time makes of a rate, and back.

use crate::scene::Detector;

/// Most of the time that a detector is taken to be blind: beyond it a detected rate hardly tells
/// the primary one.
const MOST_BLIND: f64 = 0.95;

/// A dead time, in the unit of time that rates are of, under light that does not change within it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadTime {
    /// How long it is.
    pub length: f64,
    /// Whether each arrival within it begins it anew (paralyzable).
    pub is_prolonged: bool,
}

impl DeadTime {
    /// That of a detector, which in the unit of time that is wanted is as long as `length`.
    pub fn of(spad: &Detector, length: f64) -> DeadTime {
        DeadTime { length, is_prolonged: spad.is_paralyzable() }
    }

    /// Share of the time in which a detector of a `detected` rate is ready.
    pub fn ready_share(self, detected: f64) -> f64 {
        let in_dead_time = detected * self.length;
        match self.is_prolonged {
            false => 1.0 - in_dead_time.min(MOST_BLIND),
            true => (-primary_in_dead_time(in_dead_time)).exp(),
        }
    }

    /// Rate that is detected of a `primary` one: r / (1 + r D), or, where arrivals prolong it,
    /// r exp(-r D).
    pub fn detected(self, primary: f64) -> f64 {
        let in_dead_time = primary * self.length;
        match self.is_prolonged {
            false => primary / (1.0 + in_dead_time),
            true => primary * (-in_dead_time).exp(),
        }
    }

    /// Share by which the mean slope of [`DeadTime::detected`], which is what further light adds, differs from the slope at a
    /// mean `primary` rate that varies: half of the slope's curvature over it times the variance, to the second order.
    pub fn slope_changed_by(self, primary: f64, variance: f64) -> f64 {
        let in_dead_time = primary * self.length;
        let curvature = match self.is_prolonged {
            false => 3.0 / (1.0 + in_dead_time).powi(2),
            true => 0.5 * (3.0 - in_dead_time) / (1.0 - in_dead_time),
        };
        // No light that varies changes anything, even where the slope is none.
        if variance > 0.0 { curvature * variance * self.length * self.length } else { 0.0 }
    }

    /// The primary rate of a `detected` one, the inverse of [`DeadTime::detected`]: the lower one
    /// of two where arrivals prolong the dead time, and 1 / D for more than can be detected.
    pub fn primary(self, detected: f64) -> f64 {
        match self.is_prolonged {
            false => detected / self.ready_share(detected),
            true => primary_in_dead_time(detected * self.length) / self.length,
        }
    }
}

/// The x <= 1 of x exp(-x) = `detected` in a dead time, which is at most 1 / e.
fn primary_in_dead_time(detected: f64) -> f64 {
    if detected >= (-1.0_f64).exp() {
        return 1.0;
    }
    // Halving gets near x = 1, where Newton's steps would not.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let between: f64 = 0.5 * (low + high);
        if between * (-between).exp() < detected {
            low = between;
        } else {
            high = between;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::DeadTime;

    /// 50 million per second and 14 ns: blind for 0.7 of 1.7.
    #[test]
    fn rates_lead_there_and_back() {
        let dead_time = DeadTime { length: 14e-9, is_prolonged: false };
        let detected = dead_time.detected(50e6);
        assert!((detected - 50e6 / 1.7).abs() < 1e-3);
        assert!((dead_time.ready_share(detected) - 1.0 / 1.7).abs() < 1e-12);
        assert!((dead_time.primary(detected) - 50e6).abs() < 1e-3);
        // A rate that no such detector has.
        assert!((dead_time.primary(1e9) - 20e9).abs() < 1.0);
    }

    /// Light that is 1 % brighter and darker in turns, against slopes by finite differences.
    #[test]
    fn light_in_turns_adds_as_much_as_its_slopes_say() {
        for is_prolonged in [false, true] {
            let dead_time = DeadTime { length: 14e-9, is_prolonged };
            let slope = |rate: f64| {
                (dead_time.detected(1.0001 * rate) - dead_time.detected(0.9999 * rate))
                    / (2e-4 * rate)
            };
            for rate in [10e6, 50e6, 150e6] {
                let in_turns = 0.5 * (slope(1.01 * rate) + slope(0.99 * rate));
                let changed = dead_time.slope_changed_by(rate, (0.01 * rate).powi(2));
                let expected = in_turns / slope(rate) - 1.0;
                assert!(
                    (changed - expected).abs() < 0.02 * expected.abs() + 1e-7,
                    "{rate:e}: {changed} {expected}"
                );
            }
        }
    }

    /// The same of a dead time that arrivals prolong: ready for exp(-0.7) of the time. 120 million
    /// per second are beyond 1 / D, and detected as often as some 37.8 million.
    #[test]
    fn prolonged_rates_lead_back_to_the_lower_one() {
        let dead_time = DeadTime { length: 14e-9, is_prolonged: true };
        let detected = dead_time.detected(50e6);
        assert!((detected - 50e6 * (-0.7_f64).exp()).abs() < 1e-3);
        assert!((dead_time.ready_share(detected) - (-0.7_f64).exp()).abs() < 1e-12);
        assert!((dead_time.primary(detected) - 50e6).abs() < 1e-3);
        let folded = dead_time.primary(dead_time.detected(120e6));
        let ratio: f64 = folded / 120e6;
        // x exp(-x) alike at both: ln(ratio) = (ratio - 1) 1.68.
        assert!(folded < 1.0 / 14e-9 && (ratio.ln() - (ratio - 1.0) * 1.68).abs() < 1e-12);
        assert!((dead_time.primary(1e9) * 14e-9 - 1.0).abs() < 1e-12);
    }
}

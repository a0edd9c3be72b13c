//! What a non-paralyzable dead time makes of a rate, and back.

/// Most of the time that a detector is taken to be blind: beyond it a detected rate hardly tells
/// the primary one.
const MOST_BLIND: f64 = 0.95;

/// A non-paralyzable dead time, in the unit of time that rates are of, under light that does not
/// change within it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadTime(pub f64);

impl DeadTime {
    /// Share of the time in which a detector of a `detected` rate is ready.
    pub fn ready_share(self, detected: f64) -> f64 {
        1.0 - (detected * self.0).min(MOST_BLIND)
    }

    /// Rate that is detected of a `primary` one: r / (1 + r D).
    pub fn detected(self, primary: f64) -> f64 {
        primary / (1.0 + primary * self.0)
    }

    /// The primary rate of a `detected` one, the inverse of [`DeadTime::detected`].
    pub fn primary(self, detected: f64) -> f64 {
        detected / self.ready_share(detected)
    }
}

#[cfg(test)]
mod tests {
    use super::DeadTime;

    /// 50 million per second and 14 ns: blind for 0.7 of 1.7.
    #[test]
    fn rates_lead_there_and_back() {
        let dead_time = DeadTime(14e-9);
        let detected = dead_time.detected(50e6);
        assert!((detected - 50e6 / 1.7).abs() < 1e-3);
        assert!((dead_time.ready_share(detected) - 1.0 / 1.7).abs() < 1e-12);
        assert!((dead_time.primary(detected) - 50e6).abs() < 1e-3);
        // A rate that no such detector has.
        assert!((dead_time.primary(1e9) - 20e9).abs() < 1.0);
    }
}

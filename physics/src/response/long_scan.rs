//! Second moments of a long scan, which are known at some phases of every chip.

/// Second moments of one phase step, for each expected detection.
#[derive(Clone, Copy)]
pub struct PerDetection {
    pub variance: f64,
    /// Covariance of r and N, less the mean of r.
    pub excess_covariance: f64,
}

/// Second moments of some phases of every chip of the reference's code.
pub struct LongScan {
    /// Delay of the light for which they were worked out.
    pub delay_chips: f64,
    /// By how much the reference comes later in each phase than in the first, in chips, and in the first of the
    /// next chip.
    pub phases: Vec<f64>,
    /// Of each phase of each chip.
    pub per_detection: Vec<PerDetection>,
}

impl LongScan {
    /// Those of a reference that comes so many chips later, straight between the phases.
    pub fn at(&self, chips: f64) -> PerDetection {
        let whole = chips.floor();
        let within = chips - whole;
        let late = self.phases.partition_point(|&phase| phase <= within);
        let late = late.clamp(1, self.phases.len() - 1);
        let [before, after] = [late - 1, late].map(|phase| self.phases[phase]);
        let share = (within - before) / (after - before);
        let first = whole as i64 * (self.phases.len() as i64 - 1);
        let [early, late] = [late - 1, late].map(|phase| {
            let number = (first + phase as i64).rem_euclid(self.per_detection.len() as i64);
            self.per_detection[number as usize]
        });
        let between = |a: f64, b: f64| a + share * (b - a);
        PerDetection {
            variance: between(early.variance, late.variance),
            excess_covariance: between(early.excess_covariance, late.excess_covariance),
        }
    }
}

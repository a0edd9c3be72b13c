//! Means of counts against closed forms.

use crate::photons::StepCount;
use crate::scene::Scene;

/// How many of some counts have counted anything.
pub(super) fn seen(counts: &[StepCount]) -> usize {
    counts.iter().filter(|count| count.total > 0).count()
}

/// How many counts of two runs differ.
pub(super) fn differing(a: &[StepCount], b: &[StepCount]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len())
}

/// Integration time per phase step.
pub(super) fn step_s(scene: &Scene) -> f64 {
    scene.timing().integration_ps() * 1e-12
}

/// Mean and variance of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub number: f64,
    pub mean: f64,
    pub variance: f64,
}

impl Sample {
    pub fn of(values: impl IntoIterator<Item = f64>) -> Sample {
        let values: Vec<f64> = values.into_iter().collect();
        let number = values.len() as f64;
        let mean = values.iter().sum::<f64>() / number;
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Sample { number, mean, variance: squares / (number - 1.0) }
    }

    /// Total counts.
    pub fn of_totals(counts: &[StepCount]) -> Sample {
        Sample::of(counts.iter().map(|count| count.total as f64))
    }

    pub fn standard_error(&self) -> f64 {
        (self.variance / self.number).sqrt()
    }

    /// Standard errors from an expected mean.
    pub fn z(&self, expected: f64) -> f64 {
        (self.mean - expected) / self.standard_error()
    }

    /// Standard errors from an expected variance, of a nearly normal sample.
    pub fn variance_z(&self, expected: f64) -> f64 {
        (self.variance / expected - 1.0) / (2.0 / (self.number - 1.0)).sqrt()
    }
}

/// The value of largest magnitude; NaN if one is NaN, or there is none.
pub(super) fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    values.into_iter().map(f64::abs).reduce(larger).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_value_is_the_largest_or_undefined() {
        assert_eq!(worst([0.5, -2.0, 1.0]), 2.0);
        assert!(worst([0.5, f64::NAN, 1.0]).is_nan());
        assert!(worst([]).is_nan() && worst([f64::NAN, 1.0]).is_nan());
    }

    #[test]
    fn a_sample_is_held_against_its_expectation() {
        let sample = Sample::of([1.0, 3.0, 5.0, 7.0]);
        // Deviations 3, 1, 1, 3: 20 / 3; its quarter's root.
        assert_eq!(sample.mean, 4.0);
        assert_eq!(sample.variance, 20.0 / 3.0);
        assert!((sample.z(3.0) - (3.0f64 / 5.0).sqrt()).abs() < 1e-15);
    }
}

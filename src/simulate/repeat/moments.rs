//! Mean and scatter of a sample.

use crate::math::SampleStatistics;

/// Mean and scatter; what the sample is too small for is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanMoments {
    pub mean: Option<f64>,
    pub std: Option<f64>,
    /// Standard error of the mean.
    pub std_error: Option<f64>,
    /// Standard error of the standard deviation: for normal values, or larger where
    /// their fourth moment says so.
    pub std_std_error: Option<f64>,
}

impl ScanMoments {
    /// Moments of nothing.
    pub const NONE: ScanMoments =
        ScanMoments { mean: None, std: None, std_error: None, std_std_error: None };

    pub fn of(values: &[f64]) -> ScanMoments {
        let sample = SampleStatistics::of(values.iter().copied());
        let SampleStatistics { number: n, variance, .. } = sample;
        let spread = (values.len() > 1).then(|| {
            // Variance of the variance is (m4 - m2^2) / n, 2 m2^2 / (n - 1) if normal.
            let normal = variance / (2.0 * (n - 1.0)).sqrt();
            let by_fourth = 0.5 * ((sample.fourth - variance * variance).max(0.0) / n).sqrt();
            let std = variance.sqrt();
            (std, normal.max(by_fourth) / std.max(f64::MIN_POSITIVE))
        });
        ScanMoments {
            mean: (!values.is_empty()).then_some(sample.mean),
            std: spread.map(|(std, _)| std),
            std_error: spread.map(|(std, _)| std / n.sqrt()),
            std_std_error: spread.map(|(_, error)| error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_sample_is_too_small_for_is_not_there() {
        assert_eq!(ScanMoments::of(&[]), ScanMoments::NONE);
        let one = ScanMoments::of(&[2.0]);
        assert_eq!((one.mean, one.std), (Some(2.0), None));
        // 1, 3: mean 2, squared deviations 1 + 1 over n - 1 = 1.
        let two = ScanMoments::of(&[1.0, 3.0]);
        assert_eq!((two.mean, two.std), (Some(2.0), Some(2.0f64.sqrt())));
        assert_eq!(two.std_error, Some(1.0));
    }

    #[test]
    fn outliers_make_the_standard_deviation_less_sure() {
        // 1 of 100 at 10, the others at -1 and 1: m2 about 2, m4 about 101.
        let mut values: Vec<f64> = (0..99).map(|i| f64::from(i % 2 * 2 - 1)).collect();
        let error = |values: &[f64]| ScanMoments::of(values).std_std_error.unwrap();
        let normal = ScanMoments::of(&values).std.unwrap() / (2.0 * 98.0_f64).sqrt();
        assert!((error(&values) - normal).abs() < 1e-12);
        values.push(10.0);
        let (m2, m4) = (1.99_f64 - 0.01, 101.0 - 4.0 * 0.1 * 10.0);
        let expected = ((m4 - m2 * m2) / 100.0).sqrt() / (2.0 * m2.sqrt());
        assert!((error(&values) / expected - 1.0).abs() < 0.1);
    }
}

//! Confidence intervals, all at 95 %.

use crate::math::{NORMAL_95, SampleStatistics, binomial_interval};
use crate::report::table::WithInterval;

/// A measured value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Measured {
    /// A value with a standard error, for normal errors.
    pub fn normal(value: f64, standard_error: f64) -> Measured {
        Measured {
            value,
            low: value - NORMAL_95 * standard_error,
            high: value + NORMAL_95 * standard_error,
        }
    }

    /// In another unit, `factor` (positive) of which make one of this.
    pub fn scaled(self, factor: f64) -> Measured {
        Measured { value: self.value * factor, low: self.low * factor, high: self.high * factor }
    }

    /// One less this, a share.
    pub fn complement(self) -> Measured {
        Measured { value: 1.0 - self.value, low: 1.0 - self.high, high: 1.0 - self.low }
    }

    /// Standard error of a normal interval.
    pub fn standard_error(self) -> f64 {
        (self.high - self.low) / (2.0 * NORMAL_95)
    }

    /// Both ends.
    pub fn interval(self) -> [f64; 2] {
        [self.low, self.high]
    }
}

/// A share with its interval, in percent.
pub fn in_percent(share: Measured) -> String {
    let Measured { value, low, high } = share.scaled(100.0);
    format!("{value:.1} % ({low:.1} to {high:.1})")
}

impl WithInterval for Measured {
    fn spread(self) -> [Option<f64>; 3] {
        [self.value, self.low, self.high].map(Some)
    }
}

/// 10 log10 of the ratio of two independent standard deviations, with the error
/// of each carried to first order.
pub fn decibels(over: Measured, under: Measured) -> Measured {
    let relative = |m: Measured| m.standard_error() / m.value;
    let error = relative(over).hypot(relative(under));
    Measured::normal(
        10.0 * (over.value / under.value).log10(),
        10.0 / std::f64::consts::LN_10 * error,
    )
}

/// Mean of independent measurements, each with the same weight.
pub fn mean(values: &[Measured]) -> Measured {
    let n = values.len() as f64;
    let squares: f64 = values.iter().map(|m| m.standard_error().powi(2)).sum();
    Measured::normal(values.iter().map(|m| m.value).sum::<f64>() / n, squares.sqrt() / n)
}

/// Mean and its standard error of a sample of two or more.
pub fn sample_mean(sum: f64, sum_of_squares: f64, n: u64) -> Measured {
    let n = n as f64;
    let mean = sum / n;
    let variance = (sum_of_squares / n - mean * mean).max(0.0) * n / (n - 1.0);
    Measured::normal(mean, (variance / n).sqrt())
}

/// The same from the sample itself.
pub fn sample_mean_of(values: &[f64]) -> Measured {
    let sample = SampleStatistics::of(values.iter().copied());
    Measured::normal(sample.mean, sample.standard_error())
}

/// Standard deviation of a sample of two or more. Its standard error is by the
/// sample's own fourth moment, since distances are not normal where a coarse stage
/// wavers between two steps.
pub fn sample_std(values: &[f64]) -> Measured {
    let SampleStatistics { number: n, variance, fourth, .. } =
        SampleStatistics::of(values.iter().copied());
    if variance == 0.0 {
        return Measured::normal(0.0, 0.0);
    }
    let of_variance = (fourth - variance * variance * (n - 3.0) / (n - 1.0)) / n;
    let std = variance.sqrt();
    Measured::normal(std, of_variance.max(0.0).sqrt() / (2.0 * std))
}

/// Root of the mean square of independent measurements: the standard deviation of
/// as many samples of each, round its own mean.
pub fn root_mean_square(values: &[Measured]) -> Measured {
    let n = values.len() as f64;
    let square = values.iter().map(|m| m.value.powi(2)).sum::<f64>() / n;
    let errors = values.iter().map(|m| 2.0 * m.value * m.standard_error());
    let of_square = errors.map(|error| error.powi(2)).sum::<f64>().sqrt() / n;
    let root = square.sqrt();
    Measured::normal(root, of_square / (2.0 * root.max(f64::MIN_POSITIVE)))
}

/// A rate with the exact binomial interval.
pub fn rate(successes: u64, trials: u64) -> Measured {
    let [low, high] = binomial_interval(successes, trials);
    Measured { value: successes as f64 / trials as f64, low, high }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_standard_deviation_is_that_of_its_distribution() {
        // Evenly spread over -1..1: variance 1 / 3, fourth moment 1 / 5, so that the
        // variance of s^2 is (1 / 5 - 1 / 9) / n, and of s a quarter of that over 1 / 3.
        let n = 10_000;
        let even: Vec<f64> =
            (0..n).map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0).collect();
        let std = sample_std(&even);
        assert!((std.value - (1.0_f64 / 3.0).sqrt()).abs() < 1e-4);
        let expected = (4.0 / 45.0 / f64::from(n) / (4.0 / 3.0)).sqrt();
        assert!((std.standard_error() / expected - 1.0).abs() < 1e-3);
        // Two values, half of the sample each: s hardly scatters at all.
        let two: Vec<f64> = (0..n).map(|i| f64::from(i % 2)).collect();
        assert!(sample_std(&two).standard_error() < 1e-4);
        // As many of either: the mean of the variances.
        let both = root_mean_square(&[Measured::normal(3.0, 0.1), Measured::normal(4.0, 0.2)]);
        assert!((both.value - 12.5_f64.sqrt()).abs() < 1e-12);
        // d(s) = (s1 d1 + s2 d2) / (2 s), independent.
        let expected = 0.3_f64.hypot(0.8) / (2.0 * 12.5_f64.sqrt());
        assert!((both.standard_error() - expected).abs() < 1e-12);
    }

    #[test]
    fn a_factor_of_two_is_three_decibels_with_the_errors_of_both() {
        let db = decibels(Measured::normal(2.0, 0.02), Measured::normal(1.0, 0.0));
        assert!((db.value - 3.0103).abs() < 1e-4);
        // d(10 log10 x) = 10 / ln 10 dx / x = 4.3429 x 1 %.
        assert!((db.standard_error() - 0.043_429).abs() < 1e-6);
    }

    #[test]
    fn means_carry_the_error_of_the_mean() {
        // 1 and 3: mean 2, variance 2, standard error 1.
        let sample = sample_mean(4.0, 10.0, 2);
        assert!(
            (sample.value - 2.0).abs() < 1e-12 && (sample.standard_error() - 1.0).abs() < 1e-12
        );
        let same = sample_mean_of(&[1.0, 3.0]);
        assert!((same.value - 2.0).abs() < 1e-12 && (same.standard_error() - 1.0).abs() < 1e-12);
        let both = mean(&[Measured::normal(1.0, 0.3), Measured::normal(2.0, 0.4)]);
        assert!((both.value - 1.5).abs() < 1e-12 && (both.standard_error() - 0.25).abs() < 1e-12);
    }
}

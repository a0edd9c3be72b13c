//! Mean and scatter of a sample.

use crate::math::NORMAL_95;

/// Mean and scatter; what the sample is too small for is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    pub mean: Option<f64>,
    pub std: Option<f64>,
    /// Standard error of the mean.
    pub std_error: Option<f64>,
    /// Standard error of the standard deviation: for normal values, or larger where
    /// their fourth moment says so.
    pub std_std_error: Option<f64>,
}

impl Moments {
    /// Moments of nothing.
    pub const NONE: Moments =
        Moments { mean: None, std: None, std_error: None, std_std_error: None };

    pub fn of(values: &[f64]) -> Moments {
        let n = values.len() as f64;
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / n);
        let spread = mean.filter(|_| values.len() > 1).map(|mean| {
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            let fourths: f64 = values.iter().map(|v| (v - mean).powi(4)).sum();
            let variance = squares / (n - 1.0);
            // Variance of the variance is (m4 - m2^2) / n, 2 m2^2 / (n - 1) if normal.
            let normal = variance / (2.0 * (n - 1.0)).sqrt();
            let by_fourth = 0.5 * ((fourths / n - variance * variance).max(0.0) / n).sqrt();
            let std = variance.sqrt();
            (std, normal.max(by_fourth) / std.max(f64::MIN_POSITIVE))
        });
        Moments {
            mean,
            std: spread.map(|(std, _)| std),
            std_error: spread.map(|(std, _)| std / n.sqrt()),
            std_std_error: spread.map(|(_, error)| error),
        }
    }
}

/// 95 % interval of a share, `count` of `trials` (Wilson 1927).
pub fn share_interval(count: u64, trials: u64) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let n = trials as f64;
    let share = count as f64 / n;
    let z2 = NORMAL_95 * NORMAL_95;
    let middle = (share + 0.5 * z2 / n) / (1.0 + z2 / n);
    let half =
        NORMAL_95 * (share * (1.0 - share) / n + 0.25 * z2 / (n * n)).sqrt() / (1.0 + z2 / n);
    [(middle - half).clamp(0.0, share), (middle + half).clamp(share, 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_sample_is_too_small_for_is_not_there() {
        assert_eq!(Moments::of(&[]), Moments::NONE);
        let one = Moments::of(&[2.0]);
        assert_eq!((one.mean, one.std), (Some(2.0), None));
        // 1, 3: mean 2, squared deviations 1 + 1 over n - 1 = 1.
        let two = Moments::of(&[1.0, 3.0]);
        assert_eq!((two.mean, two.std), (Some(2.0), Some(2.0f64.sqrt())));
        assert_eq!(two.std_error, Some(1.0));
    }

    #[test]
    fn outliers_make_the_standard_deviation_less_sure() {
        // 1 of 100 at 10, the others at -1 and 1: m2 about 2, m4 about 101.
        let mut values: Vec<f64> = (0..99).map(|i| f64::from(i % 2 * 2 - 1)).collect();
        let error = |values: &[f64]| Moments::of(values).std_std_error.unwrap();
        let normal = Moments::of(&values).std.unwrap() / (2.0 * 98.0_f64).sqrt();
        assert!((error(&values) - normal).abs() < 1e-12);
        values.push(10.0);
        let (m2, m4) = (1.99_f64 - 0.01, 101.0 - 4.0 * 0.1 * 10.0);
        let expected = ((m4 - m2 * m2) / 100.0).sqrt() / (2.0 * m2.sqrt());
        assert!((error(&values) / expected - 1.0).abs() < 0.1);
    }

    #[test]
    fn shares_have_the_tabulated_intervals() {
        // Wilson 1927 for 5 of 10: 0.2366 to 0.7634; for none of n: 0 to z^2 / (n + z^2).
        let half = share_interval(5, 10);
        assert!((half[0] - 0.2366).abs() < 1e-4 && (half[1] - 0.7634).abs() < 1e-4);
        let none = share_interval(0, 10);
        assert_eq!(none[0], 0.0);
        assert!((none[1] - 3.8415 / 13.8415).abs() < 1e-4);
        assert_eq!(share_interval(0, 0), [0.0, 1.0]);
    }
}

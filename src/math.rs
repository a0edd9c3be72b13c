//! Distributions and factors that several rooms need.

use std::f64::consts::SQRT_2;

use nalgebra::{Cholesky, DMatrix};
#[cfg(feature = "plots")]
use statrs::distribution::{Beta, ContinuousCDF};
use statrs::distribution::{Continuous, Normal};

/// Two-sided 95 % quantile of the standard normal distribution.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// P(z < x) for a standard normal z, to a few units in the last place (statrs has its
/// own complementary error function to 10^-11 only).
pub fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

/// Density of the standard normal distribution.
pub fn normal_density(x: f64) -> f64 {
    Normal::standard().pdf(x)
}

/// Density of the sum of an exponential number, whose mean is `mean`, and a normal one
/// of mean 0 and standard deviation `sigma`.
pub fn exponential_normal_density(x: f64, mean: f64, sigma: f64) -> f64 {
    if sigma <= 0.0 {
        return if x < 0.0 { 0.0 } else { (-x / mean).exp() / mean };
    }
    let z = (sigma / mean - x / sigma) / SQRT_2;
    if z < 5.0 {
        let exponent = 0.5 * (sigma / mean).powi(2) - x / mean;
        return 0.5 / mean * exponent.exp() * libm::erfc(z);
    }
    // exp(exponent) erfc(z) = exp(-x^2 / 2 sigma^2) exp(z^2) erfc(z), whose last two factors
    // are the asymptotic series 1 / (z sqrt(pi)) (1 - 1 / 2z^2 + 3 / 4z^4 - ..).
    let square = 1.0 / (2.0 * z * z);
    let series = 1.0 - square * (1.0 - 3.0 * square * (1.0 - 5.0 * square * (1.0 - 7.0 * square)));
    0.5 / mean * (-0.5 * (x / sigma).powi(2)).exp() * series / (z * std::f64::consts::PI.sqrt())
}

/// The exact binomial interval of a share at 95 % (Clopper and Pearson 1934):
/// quantiles of beta distributions.
#[cfg(feature = "plots")]
pub fn binomial_interval(successes: u64, trials: u64) -> [f64; 2] {
    let quantile = |a: u64, b: u64, p: f64| {
        Beta::new(a as f64, b as f64).map_or(f64::NAN, |beta| beta.inverse_cdf(p))
    };
    let failures = trials - successes;
    [
        match successes {
            0 => 0.0,
            _ => quantile(successes, failures + 1, 0.025),
        },
        match failures {
            0 => 1.0,
            _ => quantile(successes + 1, failures, 0.975),
        },
    ]
}

/// Rows of the lower triangle L with L L^T = `covariance`, whose lower triangle is
/// read: L z has that covariance if z is of independent standard normal numbers.
///
/// A number that the ones before it determine has nothing of its own; where rounding
/// leaves it less than nothing, it gets 10^-12 of the largest variance.
pub fn correlating(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = covariance.len();
    let largest = (0..n).map(|i| covariance[i][i]).fold(0.0, f64::max);
    let lower = |row: usize, column: usize| covariance[row.max(column)][row.min(column)];
    let factor = Cholesky::new_with_substitute(DMatrix::from_fn(n, n, lower), 1e-12 * largest);
    let entry = |row: usize, column: usize| match &factor {
        Some(factor) => factor.l_dirty()[(row, column)],
        // Nothing varies.
        None => 0.0,
    };
    (0..n).map(|row| (0..=row).map(|column| entry(row, column)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_distribution_has_its_tabulated_values() {
        // Abramowitz and Stegun, table 26.1.
        for (x, p) in [
            (0.0, 0.5),
            (1.0, 0.841_344_746_068_543),
            (2.0, 0.977_249_868_051_821),
            (3.0, 0.998_650_101_968_370),
            (-1.0, 0.158_655_253_931_457),
        ] {
            assert!((normal_cdf(x) - p).abs() < 1e-14, "{x}");
        }
        assert!((normal_cdf(NORMAL_95) - 0.975).abs() < 1e-14);
        assert!((normal_density(1.0) - 0.241_970_724_519_143).abs() < 1e-14);
    }

    #[test]
    fn exact_binomial_intervals_have_their_closed_forms_at_the_ends() {
        // With no success in n the upper end solves (1 - p)^n = 0.025.
        for n in [1_u64, 10, 300, 100_000] {
            let expected = 1.0 - 0.025_f64.powf(1.0 / n as f64);
            let [low, high] = binomial_interval(0, n);
            assert!((high - expected).abs() < 1e-10, "{n}: {high} {expected}");
            assert_eq!(low, 0.0);
            let [low, high] = binomial_interval(n, n);
            assert!((low - (1.0 - expected)).abs() < 1e-10, "{n}: {low}");
            assert_eq!(high, 1.0);
        }
        // 5 of 10, in every table of Clopper-Pearson limits: 0.1871 to 0.8129.
        let [low, high] = binomial_interval(5, 10);
        assert!((low - 0.1871).abs() < 5e-5 && (high - 0.8129).abs() < 5e-5);
    }

    #[test]
    fn a_triangle_times_itself_is_the_covariance() {
        // A number, its double, and one that half follows them; then nothing at all.
        let dependent = vec![vec![4.0], vec![8.0, 16.0], vec![2.0, 4.0, 3.0]];
        for covariance in [dependent, vec![vec![0.0], vec![0.0, 0.0]]] {
            let factor = correlating(&covariance);
            for (i, row) in covariance.iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    let pairs = factor[i].iter().zip(&factor[j]);
                    let found: f64 = pairs.map(|(a, b)| a * b).sum();
                    assert!((found - expected).abs() < 1e-9, "{i} {j}: {found}");
                }
            }
        }
    }
}

//! Distributions and factors that several rooms need.

use std::f64::consts::SQRT_2;

use nalgebra::{DMatrix, SymmetricEigen};
use statrs::distribution::{Beta, ContinuousCDF};
use statrs::distribution::{Continuous, Normal};

/// Iterations after which eigenvalues are given up; some per row are usual.
const EIGEN_ITERATIONS: usize = 100_000;

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

/// The upper end of what is left of a range after so many halvings, in which something is so below
/// a number, and not so above.
pub fn bisected(mut range: [f64; 2], halvings: u32, is_so: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (range[0] + range[1]);
        range[usize::from(!is_so(middle))] = middle;
    }
    range[1]
}

/// A normal law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalLaw {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// The numbers of a normal law within an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartOfNormal {
    /// Share of all numbers.
    pub share: f64,
    /// Mean and standard deviation of these.
    pub part: NormalLaw,
}

impl NormalLaw {
    /// The part of it between two numbers (Johnson, Kotz and Balakrishnan 1994, 13.10.1).
    pub fn within(self, low: f64, high: f64) -> PartOfNormal {
        let std = self.std.max(f64::MIN_POSITIVE);
        let [low, high] = [low, high].map(|end| (end - self.mean) / std);
        // From the nearer tail, whose digits are not lost beside one.
        let share = match low > 0.0 {
            true => normal_cdf(-low) - normal_cdf(-high),
            false => normal_cdf(high) - normal_cdf(low),
        };
        let share = share.max(f64::MIN_POSITIVE);
        let [at_low, at_high] = [low, high].map(normal_density);
        let mean = (at_low - at_high) / share;
        let variance = 1.0 + (low * at_low - high * at_high) / share - mean * mean;
        PartOfNormal {
            share,
            part: NormalLaw { mean: self.mean + std * mean, std: std * variance.max(0.0).sqrt() },
        }
    }
}

/// Mean and scatter of a sample.
#[derive(Debug, Clone, Copy)]
pub struct SampleStatistics {
    /// How many values there are.
    pub number: f64,
    /// Their mean; not a number of none.
    pub mean: f64,
    /// Their variance; not a number of fewer than two.
    pub variance: f64,
    /// Their fourth central moment.
    pub fourth: f64,
}

impl SampleStatistics {
    /// Of these values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> SampleStatistics {
        let values: Vec<f64> = values.into_iter().collect();
        let number = values.len() as f64;
        let mean = values.iter().sum::<f64>() / number;
        let power = |p: i32| values.iter().map(|v| (v - mean).powi(p)).sum::<f64>();
        SampleStatistics {
            number,
            mean,
            variance: power(2) / (number - 1.0),
            fourth: power(4) / number,
        }
    }

    /// Standard error of the mean.
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

/// The interval of a share at 95 %, `count` of `trials` (Wilson 1927).
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

/// Rows of the lower triangle L with L L^T = `covariance`, whose lower triangle is read,
/// less `rounding_variance` in every direction, or what a direction has if that is
/// less: L z has that covariance if z is of independent standard normal numbers.
///
/// Numbers that determine one another have directions in which nothing varies; rounding
/// and approximations leave these a variance about zero, of either sign, which is taken for
/// none. `None` if an entry is not a finite number.
pub fn correlating(covariance: &[Vec<f64>], rounding_variance: f64) -> Option<Vec<Vec<f64>>> {
    let n = covariance.len();
    let lower = |row: usize, column: usize| covariance[row.max(column)][row.min(column)];
    let matrix = DMatrix::from_fn(n, n, lower);
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let SymmetricEigen { eigenvectors, eigenvalues } =
        SymmetricEigen::try_new(matrix, f64::EPSILON, EIGEN_ITERATIONS)?;
    let null = null_variance(eigenvalues.as_slice());
    let scales = eigenvalues.map(|variance| match variance > null {
        true => (variance - rounding_variance).max(0.0).sqrt(),
        false => 0.0,
    });
    // With B = V D^(1/2) the covariance is B B^T, and of B^T = Q R it is R^T R.
    let transposed = DMatrix::from_diagonal(&scales) * eigenvectors.transpose();
    let upper = transposed.qr().r();
    // R's rows are known up to their signs.
    let entry = |row, column| upper[(column, row)] * upper[(column, column)].signum();
    Some((0..n).map(|row| (0..=row).map(|column| entry(row, column)).collect()).collect())
}

/// Variances up to this are rounding beside the others of the same matrix.
fn null_variance(variances: &[f64]) -> f64 {
    let largest = variances.iter().fold(0.0, |most: f64, variance| most.max(variance.abs()));
    1e-13 * variances.len() as f64 * largest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of a normal law, a symmetric part of it (standard deviation 0.5396 between -1 and 1),
    /// all of it, and a slice so thin that it is even.
    #[test]
    fn parts_of_a_normal_law_have_the_known_moments() {
        let law = NormalLaw { mean: 5.0, std: 2.0 };
        for (low, high, share, mean, std) in [
            (5.0, 1e3, 0.5, 5.0 + 2.0 * 0.797_885, 2.0 * 0.602_810),
            (3.0, 7.0, 0.682_689, 5.0, 2.0 * 0.539_560),
            (-95.0, 105.0, 1.0, 5.0, 2.0),
            (8.999, 9.001, 0.002 * 0.026_995, 9.0, 0.002 / 12.0_f64.sqrt()),
        ] {
            let found = law.within(low, high);
            assert!((found.share - share).abs() < 1e-6, "{low} {high}: {found:?}");
            assert!((found.part.mean - mean).abs() < 1e-5, "{low} {high}: {found:?}");
            assert!((found.part.std - std).abs() < 1e-5, "{low} {high}: {found:?}");
        }
    }

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
            let found = product(&correlating(&covariance, 0.0).expect("finite numbers"));
            for (i, row) in covariance.iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    assert!((found[i][j] - expected).abs() < 1e-9, "{i} {j}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_sample_is_held_against_its_expectation() {
        let sample = SampleStatistics::of([1.0, 3.0, 5.0, 7.0]);
        // Deviations 3, 1, 1, 3: 20 / 3; its quarter's root.
        assert_eq!((sample.mean, sample.variance), (4.0, 20.0 / 3.0));
        assert_eq!(sample.fourth, (81.0 + 1.0) / 2.0);
        assert!((sample.z(3.0) - (3.0f64 / 5.0).sqrt()).abs() < 1e-15);
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

    fn product(factor: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let entry = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum();
        factor.iter().map(|a| factor.iter().map(|b| entry(a, b)).collect()).collect()
    }

    /// Steps that count the same Poisson numbers with signs of their own: where there
    /// are more steps than numbers, most directions are null.
    #[test]
    fn null_directions_of_many_steps_stay_null() {
        let numbers = [1000.0, 30.0, 0.02];
        let sign = |step: usize, number: usize| f64::from(u8::from(step >> number & 1 == 1));
        let steps = 40;
        let covariance_of = |taken: f64| -> Vec<Vec<f64>> {
            let entry = |a: usize, b: usize| -> f64 {
                (0..3).map(|n| (numbers[n] - taken) * sign(a, n) * sign(b, n)).sum()
            };
            (0..steps).map(|a| (0..=a).map(|b| entry(a, b)).collect()).collect()
        };
        // Approximate covariances: off by a millionth of the largest, as integrals are.
        let mut covariance = covariance_of(0.0);
        for (number, row) in covariance.iter_mut().enumerate() {
            row[number] += 1e-3 * (number as f64).sin();
        }
        let found = product(&correlating(&covariance, 1.0 / 12.0).expect("finite numbers"));
        for (i, row) in covariance.iter().enumerate() {
            assert!((found[i][i] - row[i]).abs() < 0.2, "{i}: {} {}", found[i][i], row[i]);
            for (j, expected) in row.iter().enumerate() {
                assert!((found[i][j] - expected).abs() < 0.2, "{i} {j}: {}", found[i][j]);
            }
        }
    }

    #[test]
    fn rounding_is_taken_off_where_there_is_as_much() {
        let found = product(&correlating(&[vec![2.0], vec![0.0, 0.05]], 0.1).expect("finite"));
        assert!((found[0][0] - 1.9).abs() < 1e-12, "{found:?}");
        assert!(found[1][1].abs() < 1e-12 && found[0][1].abs() < 1e-12, "{found:?}");
        assert_eq!(correlating(&[vec![f64::NAN]], 0.0), None);
    }
}

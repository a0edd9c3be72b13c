//! Averages of the normal distribution.

use crate::math::{normal_cdf, normal_density};

/// Beyond this many standard deviations the probability, 10^-9, is below half a
/// step of the 31-bit numbers that it is compared with.
pub const NORMAL_REACH: f64 = 6.0;

/// P(u + s z < 0), averaged over u in from..to, for s >= 0.
pub fn mean_below_zero(from: f64, to: f64, s: f64) -> f64 {
    if s == 0.0 {
        return ((-from).max(0.0) - (-to).max(0.0)) / (to - from);
    }
    // Antiderivative of the cumulative distribution.
    let integral = |x: f64| x * normal_cdf(x) + normal_density(x);
    (integral(-from / s) - integral(-to / s)) * s / (to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_agree_with_a_sum_over_the_range() {
        for (from, to, s) in [(-1.0, 2.0, 0.7), (-3.0, -2.5, 1.0), (-0.25, 0.75, 0.0)] {
            let points = 100_000;
            let sum: f64 = (0..points)
                .map(|i| {
                    let u = from + (to - from) * (f64::from(i) + 0.5) / f64::from(points);
                    if s > 0.0 { normal_cdf(-u / s) } else { f64::from(u < 0.0) }
                })
                .sum();
            let found = mean_below_zero(from, to, s);
            assert!((found - sum / f64::from(points)).abs() < 1e-9, "{found}");
        }
    }
}

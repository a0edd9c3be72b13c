//! The normal distribution.

use std::f64::consts::{PI, SQRT_2};

/// Beyond this many standard deviations the probability, 10^-9, is below half a
/// step of the 31-bit numbers that it is compared with.
pub const NORMAL_REACH: f64 = 6.0;

/// P(z < x) for a standard normal z, within 10^-15: the series of Marsaglia,
/// "Evaluating the normal distribution", J. Stat. Softw. 11 (2004).
pub fn cumulative(x: f64) -> f64 {
    if x.abs() > 9.0 {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    let (mut sum, mut term, mut n) = (x, x, 1.0);
    loop {
        n += 2.0;
        term *= x * x / n;
        let next = sum + term;
        if next == sum {
            return 0.5 + sum * density(x);
        }
        sum = next;
    }
}

/// Density of the standard normal distribution.
fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (PI.sqrt() * SQRT_2)
}

/// P(u + s z < 0), averaged over u in from..to, for s >= 0.
pub fn mean_below_zero(from: f64, to: f64, s: f64) -> f64 {
    if s == 0.0 {
        return ((-from).max(0.0) - (-to).max(0.0)) / (to - from);
    }
    // Antiderivative of the cumulative distribution.
    let integral = |x: f64| x * cumulative(x) + density(x);
    (integral(-from / s) - integral(-to / s)) * s / (to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cumulative_has_the_tabulated_values() {
        // Abramowitz and Stegun, table 26.1.
        for (x, p) in [
            (0.0, 0.5),
            (1.0, 0.841_344_746_068_543),
            (2.0, 0.977_249_868_051_821),
            (3.0, 0.998_650_101_968_370),
            (-1.0, 0.158_655_253_931_457),
        ] {
            assert!((cumulative(x) - p).abs() < 1e-14, "{x}");
        }
    }

    #[test]
    fn means_agree_with_a_sum_over_the_range() {
        for (from, to, s) in [(-1.0, 2.0, 0.7), (-3.0, -2.5, 1.0), (-0.25, 0.75, 0.0)] {
            let points = 100_000;
            let sum: f64 = (0..points)
                .map(|i| {
                    let u = from + (to - from) * (f64::from(i) + 0.5) / f64::from(points);
                    if s > 0.0 {
                        cumulative(-u / s)
                    } else {
                        f64::from(u < 0.0)
                    }
                })
                .sum();
            let found = mean_below_zero(from, to, s);
            assert!((found - sum / f64::from(points)).abs() < 1e-9, "{found}");
        }
    }
}

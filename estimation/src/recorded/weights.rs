//! Residuals in units of their scatter, and what their squares add up to.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::response::{CountMoments, MeanCount};

/// Whitens the counts of every step: the signed ones alone, or with the totals.
pub(super) struct Whitening {
    /// Of each step: the signed count's factor, and the total's two.
    factors: Vec<[f64; 3]>,
    /// Number of counts of a step: 1, or 2 with totals.
    per_step: usize,
    /// Logarithm of the determinant of all covariances.
    pub ln_determinant: f64,
    /// What the counts' fourth cumulants add to the variance of chi-square.
    pub excess_variance: f64,
}

impl Whitening {
    pub fn of(moments: &[CountMoments], has_totals: bool) -> Whitening {
        let mut whitening = Whitening {
            factors: Vec::with_capacity(moments.len()),
            per_step: if has_totals { 2 } else { 1 },
            ln_determinant: 0.0,
            excess_variance: 0.0,
        };
        for moment in moments {
            let factor = match moment.whitening() {
                [of_signed, ..] if !has_totals => [of_signed, 0.0, 0.0],
                of_both => of_both,
            };
            whitening.factors.push(factor);
            let determinant = factor[0] * if has_totals { factor[2] } else { 1.0 };
            whitening.ln_determinant -= 2.0 * determinant.ln();
            whitening.excess_variance += fourth_cumulants(moment, factor);
        }
        whitening
    }

    /// All whitened values, step by step.
    pub fn whitened(&self, counts: impl Iterator<Item = MeanCount>) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.factors.len() * self.per_step);
        for ([a, b, c], count) in self.factors.iter().zip(counts) {
            values.push(a * count.signed);
            if self.per_step == 2 {
                values.push(b * count.signed + c * count.total);
            }
        }
        values
    }
}

/// Chance of a chi-square at least this large, by a scaled chi-square distribution
/// with its mean and variance (Satterthwaite): squares of small counts scatter
/// more than those of normal numbers.
pub(super) fn tail(chi_square: f64, degrees: usize, excess_variance: f64) -> Option<f64> {
    if degrees == 0 {
        return None;
    }
    let mean = degrees as f64;
    let variance = 2.0 * mean + excess_variance;
    let distribution = ChiSquared::new(2.0 * mean * mean / variance).ok()?;
    Some(distribution.sf(chi_square * 2.0 * mean / variance))
}

/// Sum of the fourth cumulants of a step's whitened counts that chi-square's variance
/// has beyond that of normal ones, as if hits up and hits down were Poisson numbers.
fn fourth_cumulants(moment: &CountMoments, [a, b, c]: [f64; 3]) -> f64 {
    let up = 0.5 * (moment.total_mean + moment.signed_mean);
    let down = 0.5 * (moment.total_mean - moment.signed_mean);
    let of_hit = |sign: f64| (a * a + (b * sign + c) * (b * sign + c)).powi(2);
    up.max(0.0) * of_hit(1.0) + down.max(0.0) * of_hit(-1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poisson(up: f64, down: f64) -> CountMoments {
        CountMoments {
            signed_mean: up - down,
            total_mean: up + down,
            signed_variance: up + down,
            total_variance: up + down,
            covariance: up - down,
        }
    }

    #[test]
    fn whitened_counts_have_unit_covariance_and_the_determinant_is_theirs() {
        let moment = CountMoments {
            signed_variance: 5.0,
            total_variance: 3.0,
            covariance: 2.0,
            ..poisson(1.0, 1.0)
        };
        let whitening = Whitening::of(&[moment], true);
        let [a, b, c] = whitening.factors[0];
        assert!((a * a * 5.0 - 1.0).abs() < 1e-12);
        assert!((b * b * 5.0 + 4.0 * b * c + c * c * 3.0 - 1.0).abs() < 1e-12);
        assert!((a * (b * 5.0 + c * 2.0)).abs() < 1e-12);
        // 5 x 3 - 2 x 2.
        assert!((whitening.ln_determinant - 11.0_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn chi_square_has_its_tabulated_quantiles_where_counts_are_large() {
        // Abramowitz and Stegun, table 26.8: 18.307 for 10 degrees at 5 %.
        let moments = [poisson(1e9, 1e9); 10];
        let whitening = Whitening::of(&moments, false);
        let p = tail(18.307, 10, whitening.excess_variance).unwrap();
        assert!((p - 0.05).abs() < 1e-5, "{p}");
        assert_eq!(tail(1.0, 0, whitening.excess_variance), None);
    }

    /// A Poisson number's squared deviation in variances has the variance 2 + 1/mean.
    #[test]
    fn small_counts_widen_chi_square_as_their_fourth_moment_says() {
        let mean = 0.7;
        // Only hits up, so that the signed count is the Poisson number.
        let whitening = Whitening::of(&[poisson(mean, 0.0)], false);
        assert!((whitening.excess_variance - 1.0 / mean).abs() < 1e-12);
        // Hits up and down apart: U and W each have theirs.
        let both = Whitening::of(&[poisson(3.0, 3.0)], true);
        // r and N with variance 6 each, uncorrelated; each hit has both squares 1/6.
        assert!((both.excess_variance - 6.0 * (2.0 / 6.0_f64).powi(2)).abs() < 1e-12);
    }
}

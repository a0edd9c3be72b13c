//! Unwrapping of errors of a periodic quantity, and how large they may be.

use std::f64::consts::PI;
use std::fmt;

/// Least mean resultant length of errors with a mean. A normal error of a fifth of the
/// range has 0.45, and beyond that a part of it comes round from the other side.
const LEAST_RESULTANT: f64 = 0.5;
/// -ln of the level at which Rayleigh's test must refuse uniform errors: n R^2 beyond
/// it has a chance of 5 %.
const RAYLEIGH: f64 = 3.0;
/// The most that is asked of few errors: a single one has 1 in any case.
const MOST_ASKED: f64 = 0.9;

/// How far an estimate may be off for its scan to have found the peak, in ps: a chip,
/// the half-base of the correlation's peak; of a code so short that a chip is more
/// than a quarter of its period (a square wave) a quarter of the period, so that an
/// estimate on the far side of it is never right.
pub fn tolerance_ps(chip_period_ps: f64, code_period_ps: f64) -> f64 {
    chip_period_ps.min(0.25 * code_period_ps)
}

/// Errors are spread too widely over the range to have a mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpreadTooWide {
    /// Length of the mean of the errors as directions, 0 to 1.
    pub resultant: f64,
    /// What it must be for so many.
    pub least: f64,
    /// The range after which they repeat, in metres.
    pub range_m: f64,
}

impl fmt::Display for SpreadTooWide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "no mean: the estimates are spread over the unambiguous range of {:.4} m (mean \
             resultant length {:.2}; a mean needs {:.2})",
            self.range_m, self.resultant, self.least
        )
    }
}

/// Mean resultant length that `count` errors must have: that of a distribution with a
/// mean, and more than uniform ones would have by chance (Rayleigh's test).
fn least_resultant(count: usize) -> f64 {
    let by_chance = (RAYLEIGH / count.max(1) as f64).sqrt();
    by_chance.clamp(LEAST_RESULTANT, MOST_ASKED)
}

/// Errors of a distance with the unambiguous range `range_m`, unwrapped: each moved by
/// whole ranges to within half a range of their circular mean, so that mean and
/// deviation are those of the errors round it. Errors that do not wrap stay as they
/// are, bit for bit.
///
/// # Errors
/// If they are spread so widely that a mean is meaningless.
pub fn unwrap(errors_m: &[f64], range_m: f64) -> Result<Vec<f64>, SpreadTooWide> {
    let (mut sin, mut cos) = (0.0, 0.0);
    for error_m in errors_m {
        let angle = 2.0 * PI * error_m / range_m;
        sin += angle.sin();
        cos += angle.cos();
    }
    let resultant = sin.hypot(cos) / errors_m.len().max(1) as f64;
    let least = least_resultant(errors_m.len());
    if !errors_m.is_empty() && resultant < least {
        return Err(SpreadTooWide { resultant, least, range_m });
    }
    let mean_m = sin.atan2(cos) / (2.0 * PI) * range_m;
    let unwrapped = errors_m.iter().map(|&error_m| {
        let turns = ((error_m - mean_m) / range_m).round();
        if turns == 0.0 { error_m } else { error_m - turns * range_m }
    });
    Ok(unwrapped.collect())
}

/// The same for an error that is normal, with a standard deviation: what is refused of
/// a sample is refused of its distribution.
///
/// # Errors
/// If it is spread so widely that a mean is meaningless.
pub fn check_normal(std_m: f64, range_m: f64) -> Result<(), SpreadTooWide> {
    // Of a wrapped normal error.
    let resultant = (-0.5 * (2.0 * PI * std_m / range_m).powi(2)).exp();
    if resultant < LEAST_RESULTANT {
        return Err(SpreadTooWide { resultant, least: LEAST_RESULTANT, range_m });
    }
    Ok(())
}

/// An error the shorter way round the range.
pub fn fold(error_m: f64, range_m: f64) -> f64 {
    let turns = (error_m / range_m).round();
    if turns == 0.0 { error_m } else { error_m - turns * range_m }
}

/// A distance within 0 .. range, the range itself left out.
pub fn fold_distance(distance_m: f64, range_m: f64) -> f64 {
    let folded = distance_m.rem_euclid(range_m);
    // What is a little below zero is the range after rounding.
    if folded < range_m { folded } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_that_wrap_stay_together_and_others_as_they_are() {
        let plain = [-0.3, 0.1, 0.25];
        assert_eq!(unwrap(&plain, 6.0), Ok(plain.to_vec()));
        // Round half the range: 2.9, 3.1 and 3.2 of 6.
        let wrapped = unwrap(&[2.9, -2.9, -2.8], 6.0).expect("they stand together");
        let mean = wrapped.iter().sum::<f64>() / 3.0;
        assert!((fold(mean - (2.9 + 3.1 + 3.2) / 3.0, 6.0)).abs() < 1e-12, "{mean}");
        let width = wrapped.iter().fold(0.0, |most: f64, v| most.max((v - mean).abs()));
        assert!(width < 0.2, "{wrapped:?}");
        assert_eq!(unwrap(&[], 6.0), Ok(Vec::new()));
        assert_eq!(unwrap(&[-2.99], 6.0), Ok(vec![-2.99]));
    }

    #[test]
    fn errors_all_round_the_range_have_no_mean() {
        let uniform: Vec<f64> = (0..1000).map(|i| f64::from(i) * 6e-3 - 3.0).collect();
        assert!(unwrap(&uniform, 6.0).is_err());
        // Two against each other, and two that stand together.
        assert!(unwrap(&[1.5, -1.5], 6.0).is_err());
        assert!(unwrap(&[0.5, -0.2], 6.0).is_ok());
        let text = unwrap(&[1.5, -1.5], 6.0).map_err(|spread| spread.to_string());
        assert!(text.is_err_and(|text| text.contains("6.0000 m") && text.contains("0.90")));
    }

    #[test]
    fn a_wide_normal_error_has_no_mean() {
        // exp(-x^2 / 2) = 1/2 at x = sqrt(2 ln 2) radians.
        let limit_m = (2.0 * 2f64.ln()).sqrt() / (2.0 * PI) * 6.0;
        assert!(check_normal(0.999 * limit_m, 6.0).is_ok());
        assert!(check_normal(1.001 * limit_m, 6.0).is_err());
    }

    #[test]
    fn distances_at_the_border_of_the_range_fold_to_zero() {
        assert_eq!(fold_distance(-1e-20, 6.0), 0.0);
        assert_eq!(fold_distance(6.0, 6.0), 0.0);
        assert!((fold_distance(-0.5, 6.0) - 5.5).abs() < 1e-12);
        assert!((fold_distance(12.25, 6.0) - 0.25).abs() < 1e-12);
    }
}

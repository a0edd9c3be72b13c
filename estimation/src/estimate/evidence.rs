//! Tests of scans against their expectation.
//!
//! Bias, scatter and share of missed peaks are compared with the expectation by exact
//! intervals: of a binomial share, of the mean and of the variance of normal errors (of the
//! variance also by its fourth moment, where errors have long tails). Deviations within the accuracy
//! that an expectation claims pass: [`STD_SHARE`], [`BIAS_IN_STD`] and
//! [`BIAS_M`], [`MISSED_SHARE`]. The family-wise error rate of all comparisons, of all paths of a
//! simulation or of all points of a sweep, is [`FAMILY_WISE`] at most.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ChiSquared, ContinuousCDF, Normal};

use super::unwrap::fold;

/// Probability that any of a family's comparisons rejects an expectation that holds.
const FAMILY_WISE: f64 = 1e-4;
/// A standard deviation is expected to within this share of it.
const STD_SHARE: f64 = 0.05;
/// A bias is expected to within this share of the standard deviation, and as much beside
/// that as the coarse stage's own noise adds.
const BIAS_IN_STD: f64 = 0.1;
const BIAS_M: f64 = 0.3e-3;
/// A share of missed peaks is expected to within this share of it; shares of a thousandth
/// and less to within a factor of two, [`SMALL_MISSED`] more.
const MISSED_SHARE: f64 = 0.1;
const FEW_MISSED: f64 = 1e-3;
const SMALL_MISSED: f64 = 1e-7;
/// From this many scans on, none of which finds the path, this is reported without an expected share.
const NEVER_FOUND: u64 = 5;

/// What is expected of a path's estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expectation {
    /// Errors of the scans that find the path; none where they are not known.
    pub errors: Option<ExpectedErrors>,
    /// Share of scans that miss the path, and the error of that share where it is from drawn
    /// scans; none where it is not known.
    pub missed: Option<(f64, f64)>,
}

/// What is expected of the errors of the scans that find a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExpectedErrors {
    /// Their mean.
    pub bias_m: f64,
    /// Standard deviation of one scan's.
    pub std_m: f64,
}

/// Results of scans for a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence<'a> {
    /// Errors of the estimates that count for the path.
    pub errors_m: &'a [f64],
    /// Scans.
    pub scans: u64,
    /// Those of them that miss the path.
    pub missed: u64,
    /// Range after which distances repeat.
    pub range_m: f64,
}

/// A family of comparisons of scans with expectations, as one of its members sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparisons {
    /// Significance level of one comparison.
    level: f64,
}

impl Comparisons {
    /// Of so many comparisons, with the probability that any of them rejects what holds.
    pub(crate) fn of(chance: f64, comparisons: usize) -> Comparisons {
        Comparisons { level: chance / comparisons.max(1) as f64 }
    }

    /// Of so many paths, each with three comparisons.
    pub fn of_paths(paths: usize) -> Comparisons {
        Comparisons::of(FAMILY_WISE, 3 * paths.max(1))
    }

    /// Significance level of one comparison.
    pub(crate) fn level(&self) -> f64 {
        self.level
    }

    /// The same of one of so many simulations, which are a family together.
    pub fn one_of(self, simulations: usize) -> Comparisons {
        Comparisons { level: self.level / simulations.max(1) as f64 }
    }

    /// How scans contradict an expectation, in words; empty where they agree with it. `None`
    /// without anything to compare.
    pub fn contradictions(
        &self,
        evidence: &Evidence,
        expected: &Expectation,
    ) -> Option<Vec<String>> {
        let is_told = expected.missed.is_some() || expected.errors.is_some();
        let is_compared = expected.missed.is_some() || !evidence.errors_m.is_empty();
        if evidence.scans == 0 || !is_told || !is_compared && evidence.scans < NEVER_FOUND {
            return None;
        }
        let of_errors = |errors: ExpectedErrors| {
            [self.of_bias(evidence, &errors), self.of_scatter(evidence, &errors)]
        };
        let found = [self.of_missed(evidence, expected.missed)];
        let found = found.into_iter().chain(expected.errors.map(of_errors).into_iter().flatten());
        Some(found.flatten().collect())
    }

    fn of_missed(&self, evidence: &Evidence, expected: Option<(f64, f64)>) -> Option<String> {
        let Evidence { scans, missed, .. } = *evidence;
        let percent = 100.0 * missed as f64 / scans as f64;
        let Some((share, error)) = expected else {
            let never = missed == scans && scans >= NEVER_FOUND;
            return never.then(|| format!("none of {scans} scans finds the path"));
        };
        let tolerance = error + MISSED_SHARE * share + share.min(FEW_MISSED) + SMALL_MISSED;
        let (least, most) = ((share - tolerance).max(0.0), (share + tolerance).min(1.0));
        let too_many = missed > 0 && {
            let at_least = Beta::new(missed as f64, (scans - missed + 1) as f64);
            at_least.is_ok_and(|beta| beta.cdf(most) < 0.5 * self.level)
        };
        let too_few = missed < scans && {
            let at_most = Beta::new((missed + 1) as f64, (scans - missed) as f64);
            at_most.is_ok_and(|beta| beta.sf(least) < 0.5 * self.level)
        };
        (too_many || too_few)
            .then(|| format!("missed {percent:.2} % of {scans}, expected {:.2} %", 100.0 * share))
    }

    fn of_bias(&self, evidence: &Evidence, expected: &ExpectedErrors) -> Option<String> {
        let off = Off::of(evidence, expected)?;
        let least_std_m = expected.std_m * (1.0 + STD_SHARE) / off.count.sqrt();
        let tolerance_m = BIAS_IN_STD * expected.std_m + BIAS_M;
        (off.mean_m.abs() > self.sigmas() * least_std_m + tolerance_m).then(|| {
            let [found_mm, expected_mm] =
                [off.mean_m + expected.bias_m, expected.bias_m].map(|m| m * 1e3);
            format!("bias {found_mm:.2} mm, expected {expected_mm:.2} mm")
        })
    }

    fn of_scatter(&self, evidence: &Evidence, expected: &ExpectedErrors) -> Option<String> {
        let off = Off::of(evidence, expected).filter(|off| off.count > 1.0)?;
        let std_m = off.variance.sqrt();
        let degrees = off.count - 1.0;
        let chi_square = ChiSquared::new(degrees).ok()?;
        let of = |std_m: f64| degrees * off.variance / (std_m * std_m);
        let [least_m, most_m] = [-STD_SHARE, STD_SHARE].map(|by| expected.std_m * (1.0 + by));
        let by_chi_square = chi_square.sf(of(most_m)) < 0.5 * self.level
            || chi_square.cdf(of(least_m)) < 0.5 * self.level;
        let beyond_m = (least_m - std_m).max(std_m - most_m);
        let by_fourth = beyond_m > self.sigmas() * off.std_error_m;
        (by_chi_square && by_fourth).then(|| {
            let [found_mm, expected_mm] = [std_m, expected.std_m].map(|m| m * 1e3);
            format!("standard deviation {found_mm:.2} mm, expected {expected_mm:.2} mm")
        })
    }

    /// Two-sided quantile of the standard normal distribution.
    pub(crate) fn sigmas(&self) -> f64 {
        -Normal::standard().inverse_cdf(0.5 * self.level)
    }
}

/// How far estimates are off the expected one.
struct Off {
    count: f64,
    mean_m: f64,
    variance: f64,
    /// Standard error of the standard deviation, by the fourth moment.
    std_error_m: f64,
}

impl Off {
    /// None without estimates.
    fn of(evidence: &Evidence, expected: &ExpectedErrors) -> Option<Off> {
        let off = |error_m: &f64| fold(error_m - expected.bias_m, evidence.range_m);
        let off_m: Vec<f64> = evidence.errors_m.iter().map(off).collect();
        let count = off_m.len() as f64;
        let mean = |power: i32, from: f64| {
            off_m.iter().map(|off| (off - from).powi(power)).sum::<f64>() / count
        };
        let mean_m = mean(1, 0.0);
        let [second, fourth] = [2, 4].map(|power| mean(power, mean_m));
        let of_variance = ((fourth - second * second).max(0.0) / count).sqrt();
        (count > 0.0).then(|| Off {
            count,
            mean_m,
            variance: second * count / (count - 1.0).max(1.0),
            std_error_m: 0.5 * of_variance / second.sqrt().max(f64::MIN_POSITIVE),
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    const EXPECTED: Expectation = Expectation {
        errors: Some(ExpectedErrors { bias_m: 0.02, std_m: 0.01 }),
        missed: Some((0.0, 0.0)),
    };

    fn errors_m(seed: u64, count: usize, mean_m: f64, std_m: f64) -> Vec<f64> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let normal = |_| -> f64 { StandardNormal.sample(&mut rng) };
        (0..count).map(normal).map(|z| mean_m + std_m * z).collect()
    }

    fn accused(errors_m: &[f64], missed: u64, expected: &Expectation) -> Vec<String> {
        let scans = errors_m.len() as u64 + missed;
        let evidence = Evidence { errors_m, scans, missed, range_m: 100.0 };
        Comparisons::of_paths(1).contradictions(&evidence, expected).expect("there are scans")
    }

    #[test]
    fn scans_that_are_as_expected_are_not_accused() {
        for seed in 0..300 {
            for count in [1, 2, 5, 30, 1000] {
                let errors_m = errors_m(seed, count, 0.02, 0.01);
                assert_eq!(accused(&errors_m, 0, &EXPECTED), [""; 0], "{seed} {count}");
            }
        }
    }

    #[test]
    fn each_of_the_three_is_held_against_what_is_expected() {
        let told = |count, mean_m, std_m| {
            let found = accused(&errors_m(1, count, mean_m, std_m), 0, &EXPECTED);
            found
                .iter()
                .map(|told| told.split(' ').next().unwrap_or("").to_owned())
                .collect::<Vec<_>>()
        };
        let none: Vec<String> = Vec::new();
        assert_eq!(told(100, 0.02, 0.01), none);
        assert_eq!(told(100, 0.03, 0.01), ["bias"]);
        assert_eq!(told(100, 0.02, 0.02), ["standard"]);
        assert_eq!(told(400, 0.02, 0.006), ["standard"]);
        assert_eq!(told(1, 0.2, 0.0), ["bias"]);
        // What is not claimed is let pass, however many scans see it.
        assert_eq!(told(100_000, 0.0211, 0.01), none);
        assert_eq!(told(100_000, 0.02, 0.0104), none);
    }

    /// P(X >= k) of a binomial number, term by term.
    #[test]
    fn missed_shares_have_exact_binomial_levels() {
        let level = 0.5 * FAMILY_WISE / 3.0;
        let (share, scans) = (0.05_f64, 60_u64);
        let most = share * (1.0 + MISSED_SHARE) + FEW_MISSED + SMALL_MISSED;
        let mut term = (1.0 - most).powi(scans as i32);
        let mut at_least = 1.0;
        for missed in 0..scans {
            let expected = Expectation { missed: Some((share, 0.0)), ..EXPECTED };
            let found = (scans - missed) as usize;
            let told = accused(&vec![0.02; found], missed, &expected);
            let is_told = told.iter().any(|told| told.starts_with("missed"));
            assert_eq!(is_told, at_least < level, "{missed}: {at_least} {told:?}");
            at_least -= term;
            term *= (scans - missed) as f64 / (missed + 1) as f64 * most / (1.0 - most);
        }
    }

    /// A share that is expected is held against the scans, whatever is known of errors.
    #[test]
    fn a_share_without_expected_errors_is_compared_all_the_same() {
        let share = Expectation { errors: None, ..EXPECTED };
        assert_eq!(accused(&[0.5; 30], 0, &share), [""; 0]);
        assert_eq!(accused(&[0.5; 30], 30, &share), ["missed 50.00 % of 60, expected 0.00 %"]);
        let nothing = Expectation { missed: None, ..share };
        let evidence = Evidence { errors_m: &[], scans: 60, missed: 60, range_m: 100.0 };
        assert_eq!(Comparisons::of_paths(1).contradictions(&evidence, &nothing), None);
    }

    /// What one simulation alone would be accused of at a level, a thousand together are not.
    #[test]
    fn simulations_of_a_family_share_its_level() {
        let off_m = |sigmas: f64| 0.02 + 0.01 * (BIAS_IN_STD + sigmas * 1.05) + BIAS_M;
        let is_accused = |sigmas: f64, simulations: usize| {
            let errors_m = [off_m(sigmas)];
            let evidence = Evidence { errors_m: &errors_m, scans: 1, missed: 0, range_m: 100.0 };
            let family = Comparisons::of_paths(1).one_of(simulations);
            !family.contradictions(&evidence, &EXPECTED).expect("there is a scan").is_empty()
        };
        // Two-sided normal quantiles of 1e-4 / 3 and of 1e-7 / 3.
        assert_eq!([4.14, 4.16].map(|sigmas| is_accused(sigmas, 1)), [false, true]);
        assert_eq!([5.51, 5.53].map(|sigmas| is_accused(sigmas, 1000)), [false, true]);
    }

    #[test]
    fn an_unknown_share_is_not_compared_unless_no_scan_finds_the_path() {
        let expected = Expectation { missed: None, ..EXPECTED };
        assert_eq!(accused(&[0.02, 0.021], 40, &expected), [""; 0]);
        assert_eq!(accused(&[], 40, &expected), ["none of 40 scans finds the path"]);
    }
}

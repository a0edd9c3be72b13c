//! Gold sets and the preferred pairs that they are made from.

use std::collections::BTreeMap;

use super::correlation::{correlate, cross_correlation_counts};
use super::gf2;
use super::lfsr::{Lfsr, polynomial_text};
use super::{Code, CodeError, Generator};

/// A Gold set: u, v, and u XOR (v advanced by i chips) for i in 0..L.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GoldSet {
    /// First m-sequence, index -2.
    pub u: Lfsr,
    /// Second m-sequence, index -1.
    pub v: Lfsr,
}

impl GoldSet {
    /// Chips per period of each code, L = 2^n - 1.
    pub fn length(&self) -> u64 {
        self.u.period()
    }

    /// Number of codes in the set, 2^n + 1.
    pub fn members(&self) -> u64 {
        self.length() + 2
    }

    /// Gold's bound t(n) on the magnitude of the correlations off the peak: at once
    /// beta of eq. 20 (between codes) and alpha of eq. 21 (of one code).
    pub fn bound(&self) -> i64 {
        bound(self.u.degree)
    }

    /// How the code of `index` is made, without interleaving.
    pub fn generator(&self, index: i64) -> Result<Generator, CodeError> {
        let last = self.length() as i64 - 1;
        match index {
            -2 => Ok(Generator::MSequence(self.u.clone())),
            -1 => Ok(Generator::MSequence(self.v.clone())),
            0.. if index <= last => {
                Ok(Generator::Gold { u: self.u.clone(), v: self.v.advanced(index as u64) })
            }
            _ => Err(CodeError::IndexOutOfRange { index, last }),
        }
    }

    /// The code of `index`, without interleaving.
    pub fn code(&self, index: i64) -> Result<Code, CodeError> {
        Code::new(self.generator(index)?, 0)
    }

    /// theta_uv at every lag. In a preferred pair's set every correlation off
    /// the peak takes one of its values.
    pub fn cross_correlation(&self) -> Vec<i64> {
        let period = self.length() as usize;
        correlate(&self.u.chips(period), &self.v.chips(period))
    }

    /// How often each value of theta_uv occurs, in ascending order of value.
    pub fn cross_correlation_counts(&self) -> BTreeMap<i64, u64> {
        let period = self.length() as usize;
        cross_correlation_counts(&self.u.chips(period), &self.v.chips(period), self.u.degree)
    }

    /// Number of codes of the set with 2^(n-1) ones.
    ///
    /// The code of index i has as many ones as u and v advanced by i differ,
    /// which is (L - theta_uv\[i\]) / 2; u and v themselves are balanced.
    pub fn balanced_members(&self) -> u64 {
        let of_theta = self.cross_correlation_counts();
        2 + of_theta.get(&-1).copied().unwrap_or_default()
    }

    /// Checks that the cross-correlation takes Gold's three values only.
    pub fn check_preferred(&self) -> Result<(), CodeError> {
        let counts = self.cross_correlation_counts();
        let bound = self.bound();
        if counts.keys().all(|value| [-bound, -1, bound - 2].contains(value)) {
            return Ok(());
        }
        Err(CodeError::NotPreferred {
            u: polynomial_text(&self.u.exponents),
            v: polynomial_text(&self.v.exponents),
            values: counts.len(),
            least: counts.keys().next().copied().unwrap_or_default(),
            greatest: counts.keys().next_back().copied().unwrap_or_default(),
            bound,
        })
    }
}

/// Gold's t(n) = 2^floor((n + 2) / 2) + 1: 2^((n+1)/2) + 1 for odd n,
/// 2^((n+2)/2) + 1 for even n.
pub fn bound(degree: u32) -> i64 {
    (1 << ((degree + 2) / 2)) + 1
}

/// The default pair of polynomials for `degree`, exponents descending.
///
/// u is the primitive polynomial with the fewest terms; v generates every q-th
/// chip of u's sequence. Gold proved the pair preferred for q = 2^k + 1 with
/// gcd(k, n) = 1 for odd n and 2 for n = 2 mod 4; the smallest such k are 1 and
/// 2. Where 4 divides n no pair is preferred, and q = 2^((n+2)/2) - 1 gives
/// Niho's four values, which keep within Gold's bound; it needs
/// `allow_non_preferred`.
pub fn default_pair(degree: u32, allow_non_preferred: bool) -> Result<[Vec<u32>; 2], CodeError> {
    let decimation = match degree % 4 {
        0 if !allow_non_preferred => return Err(CodeError::NoPreferredPair { degree }),
        0 => (1 << ((degree + 2) / 2)) - 1,
        2 => 5,
        _ => 3,
    };
    let u = default_polynomial(degree)?;
    let sample_count = 2 * degree as usize;
    let chips = Lfsr::new(degree, &u, None)?.chips(sample_count * decimation);
    let decimated: Vec<u8> = chips.into_iter().step_by(decimation).collect();
    Ok([u, gf2::shortest_recurrence(&decimated)])
}

/// The default polynomial of an m-sequence: the primitive one with the fewest
/// terms, exponents descending.
pub fn default_polynomial(degree: u32) -> Result<Vec<u32>, CodeError> {
    gf2::first_primitive(degree).ok_or(CodeError::DegreeOutOfRange { degree })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peterson and Weldon's table of irreducible polynomials, Appendix C: the
    /// entries 1 and 3 (5 where 2 mod 4) of each degree, in octal.
    #[test]
    fn default_pairs_are_those_of_the_published_tables() {
        let octal = [
            (5, 0o45, 0o75),
            (6, 0o103, 0o147),
            (9, 0o1021, 0o1131),
            (10, 0o2011, 0o2415),
            (11, 0o4005, 0o4445),
        ];
        for (degree, u, v) in octal {
            let pair = default_pair(degree, false).unwrap();
            assert_eq!(pair, [gf2::exponents(u), gf2::exponents(v)], "degree {degree}");
        }
    }
}

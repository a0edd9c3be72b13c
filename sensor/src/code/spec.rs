//! A code as a scene or the command line asks for it.

use super::family::Family;
use super::gold::{GoldSet, default_pair, default_polynomial};
use super::lfsr::Lfsr;
use super::{Code, CodeError, Generator, MAX_DEGREE, MIN_DEGREE, parse_chips};

/// The parameters of a code, unchecked. `None` means not given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodeSpec {
    /// Family of the code.
    pub family: Family,
    /// Degree n of the polynomials, 3..=20.
    pub degree: Option<u32>,
    /// Code of the Gold set, -2..L (default 0).
    pub index: Option<i64>,
    /// Interleaving depth nu, 0..=8.
    pub interleave: u32,
    /// One polynomial for each LFSR (default: the program's own choice).
    pub polynomials: Option<Vec<Vec<u32>>>,
    /// One seed for each LFSR (default: all-ones).
    pub seeds: Option<Vec<String>>,
    /// Whether a Gold set may be made from a pair that is not preferred.
    pub allow_non_preferred: Option<bool>,
    /// Chips of family `chips`, "0110...".
    pub chips: Option<String>,
}

impl CodeSpec {
    /// A code of `family` with nothing else given.
    pub fn new(family: Family) -> CodeSpec {
        CodeSpec {
            family,
            degree: None,
            index: None,
            interleave: 0,
            polynomials: None,
            seeds: None,
            allow_non_preferred: None,
            chips: None,
        }
    }

    /// Checks the parameters and makes the code.
    pub fn build(&self) -> Result<Code, CodeError> {
        let generator = match self.family {
            Family::Gold => self.gold_set()?.generator(self.index.unwrap_or(0))?,
            Family::MSequence => Generator::MSequence(self.m_sequence()?),
            Family::Square => {
                self.check_keys()?;
                Generator::Square
            }
            Family::Chips => Generator::Chips(self.given_chips()?),
        };
        Code::new(generator, self.interleave)
    }

    /// The Gold set of which [`CodeSpec::build`] makes one code. For family
    /// `gold` only.
    pub fn gold_set(&self) -> Result<GoldSet, CodeError> {
        self.check_keys()?;
        let degree = self.checked_degree()?;
        let allow_non_preferred = self.allow_non_preferred.unwrap_or(false);
        let [u, v] = match &self.polynomials {
            None => default_pair(degree, allow_non_preferred)?,
            Some(given) => given
                .clone()
                .try_into()
                .map_err(|given: Vec<_>| self.polynomial_count(2, given.len()))?,
        };
        let [seed_u, seed_v] = self.checked_seeds()?;
        let set = GoldSet { u: Lfsr::new(degree, &u, seed_u)?, v: Lfsr::new(degree, &v, seed_v)? };
        if !allow_non_preferred {
            if degree % 4 == 0 {
                return Err(CodeError::NoPreferredPair { degree });
            }
            // The default pair is preferred by Gold's theorem.
            if self.polynomials.is_some() {
                set.check_preferred()?;
            }
        }
        Ok(set)
    }

    fn m_sequence(&self) -> Result<Lfsr, CodeError> {
        self.check_keys()?;
        let degree = self.checked_degree()?;
        let polynomial = match self.polynomials.as_deref() {
            None => default_polynomial(degree)?,
            Some([polynomial]) => polynomial.clone(),
            Some(given) => return Err(self.polynomial_count(1, given.len())),
        };
        let [seed] = self.checked_seeds()?;
        Lfsr::new(degree, &polynomial, seed)
    }

    fn given_chips(&self) -> Result<Vec<u8>, CodeError> {
        self.check_keys()?;
        let text = self.chips.as_deref().ok_or(CodeError::MissingKey {
            key: "chips",
            family: self.family,
            example: "chips = \"0110\"",
        })?;
        parse_chips(text).ok_or(CodeError::MalformedChips)
    }

    fn checked_degree(&self) -> Result<u32, CodeError> {
        let degree = self.degree.ok_or(CodeError::MissingKey {
            key: "degree",
            family: self.family,
            example: "degree = 11",
        })?;
        if !(MIN_DEGREE..=MAX_DEGREE).contains(&degree) {
            return Err(CodeError::DegreeOutOfRange { degree });
        }
        Ok(degree)
    }

    /// The seeds of `N` LFSRs, `None` where the default is meant.
    fn checked_seeds<const N: usize>(&self) -> Result<[Option<&str>; N], CodeError> {
        let Some(given) = &self.seeds else {
            return Ok([None; N]);
        };
        let seeds: Vec<Option<&str>> = given.iter().map(|seed| Some(seed.as_str())).collect();
        seeds.try_into().map_err(|_| CodeError::SeedCount {
            family: self.family,
            expected: N,
            got: given.len(),
        })
    }

    fn polynomial_count(&self, expected: usize, got: usize) -> CodeError {
        CodeError::PolynomialCount { family: self.family, expected, got }
    }

    /// Refuses keys that mean nothing for the family.
    fn check_keys(&self) -> Result<(), CodeError> {
        let given = [
            ("degree", self.degree.is_some()),
            ("index", self.index.is_some()),
            ("polynomials", self.polynomials.is_some()),
            ("seeds", self.seeds.is_some()),
            ("allow_non_preferred", self.allow_non_preferred.is_some()),
            ("chips", self.chips.is_some()),
        ];
        let foreign = given.iter().find(|(key, given)| *given && !self.family.keys().contains(key));
        match foreign {
            Some(&(key, _)) => Err(CodeError::ForeignKey { key, family: self.family }),
            None => Ok(()),
        }
    }
}

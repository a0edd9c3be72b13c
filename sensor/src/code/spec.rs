//! A code as a scene or the command line asks for it.

use super::family::Family;
use super::gold::{GoldSet, default_pair, default_polynomial};
use super::lfsr::Lfsr;
use super::text::{parse_polynomial, parse_seed};
use super::{Code, CodeError, Generator, MAX_DEGREE, MIN_DEGREE, parse_chips};

/// The parameters of a code, unchecked; the options of `goldtof codes`. `None` means not given.
#[derive(Debug, Clone, PartialEq, Eq, clap::Args)]
pub struct CodeSpec {
    /// Degree n of the polynomials, 2 to 20, for example --degree 11; the code has
    /// 2^n - 1 chips before interleaving
    #[arg(long, value_name = "N")]
    pub degree: Option<u32>,
    /// Family, for example --family m-sequence
    #[arg(long, value_name = "F", value_enum, default_value_t = Family::Gold)]
    pub family: Family,
    /// Exponents in descending order, the two polynomials of a Gold pair
    /// separated by a semicolon: --polynomials "11,2,0;11,8,5,2,0"
    /// [default: a preferred pair]
    #[arg(long, value_name = "LIST", value_delimiter = ';', value_parser = parse_polynomial,
          num_args = 1, action = clap::ArgAction::Set)]
    pub polynomials: Option<Vec<Vec<u32>>>,
    /// First chips of each m-sequence, separated by a comma: --seeds
    /// 11111,11111 [default: all ones]
    #[arg(long, value_name = "A,B", value_delimiter = ',', value_parser = parse_seed,
          num_args = 1, action = clap::ArgAction::Set)]
    pub seeds: Option<Vec<String>>,
    /// Index in the Gold set: -2 is u, -1 is v, i is u XOR v advanced by i chips,
    /// up to 2^n - 2, for example --index 3 [default: 0]
    #[arg(long, value_name = "I", allow_negative_numbers = true)]
    pub index: Option<i64>,
    /// Interleaving depth nu, 0 to 8, for example --interleave 1
    #[arg(long, value_name = "V", default_value_t = 0)]
    pub interleave: u32,
    /// Chips of family chips, first chip first: --chips 0110100
    #[arg(long, value_name = "BITS")]
    pub chips: Option<String>,
    /// Permit a Gold set from a pair that is not preferred
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub allow_non_preferred: Option<bool>,
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

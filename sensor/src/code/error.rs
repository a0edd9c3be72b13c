//! What can be wrong with a code's parameters.

use thiserror::Error;

use super::family::Family;
use super::{MAX_CODE_CHIPS, MAX_DEGREE, MAX_INTERLEAVE, MIN_DEGREE, MOST_HARDWARE_DEGREE};

/// A code that cannot be made, and what would be right.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CodeError {
    /// A key that means nothing for this family.
    #[error("`{key}` does not belong to family \"{family}\"; leave it out")]
    ForeignKey {
        /// The key.
        key: &'static str,
        /// The family that does not know it.
        family: Family,
    },
    /// A key that this family cannot do without.
    #[error("family \"{family}\" needs `{key}`, for example {example}")]
    MissingKey {
        /// The key.
        key: &'static str,
        /// The family that needs it.
        family: Family,
        /// How to write it.
        example: &'static str,
    },
    /// The degree is too small or too large.
    #[error("degree {degree} is outside {MIN_DEGREE} to {MAX_DEGREE}")]
    DegreeOutOfRange {
        /// The degree asked for.
        degree: u32,
    },
    /// 4 divides the degree.
    #[error(
        "degree {degree} has no preferred pair, because 4 divides it; \
         use {}, or set allow_non_preferred = true",
        degrees_beside(*degree)
    )]
    NoPreferredPair {
        /// The degree asked for.
        degree: u32,
    },
    /// The cross-correlation of u and v takes other values than Gold's three.
    #[error(
        "polynomials {u} and {v} are not a preferred pair: their cross-correlation \
         takes {values} different values between {least} and {greatest}, not just -{}, -1 and {}; \
         take another pair, or set allow_non_preferred = true",
        bound, bound - 2
    )]
    NotPreferred {
        /// First polynomial.
        u: String,
        /// Second polynomial.
        v: String,
        /// How many different values the cross-correlation takes.
        values: usize,
        /// The smallest of them.
        least: i64,
        /// The largest of them.
        greatest: i64,
        /// Gold's t(n).
        bound: i64,
    },
    /// Not one polynomial for each LFSR.
    #[error(
        "family \"{family}\" takes {expected} polynomial{}, not {got}",
        if *expected == 1 { "" } else { "s" }
    )]
    PolynomialCount {
        /// The family.
        family: Family,
        /// How many it takes.
        expected: usize,
        /// How many there were.
        got: usize,
    },
    /// Exponents that are not a polynomial of the degree in descending order.
    #[error(
        "polynomial {} does not list exponents in descending order \
         from the degree {degree} down to 0, as {example} does",
        if polynomial.is_empty() { "[]" } else { polynomial }
    )]
    MalformedPolynomial {
        /// The exponents as given.
        polynomial: String,
        /// The degree it should have.
        degree: u32,
        /// A polynomial of that degree.
        example: String,
    },
    /// The LFSR would not run through all 2^n - 1 states.
    #[error("polynomial {polynomial} is not primitive; {example} is")]
    NotPrimitive {
        /// The exponents as given.
        polynomial: String,
        /// A primitive polynomial of the same degree.
        example: String,
    },
    /// Not one seed for each LFSR.
    #[error(
        "family \"{family}\" takes {expected} seed{}, not {got}",
        if *expected == 1 { "" } else { "s" }
    )]
    SeedCount {
        /// The family.
        family: Family,
        /// How many it takes.
        expected: usize,
        /// How many there were.
        got: usize,
    },
    /// A seed that is not n binary digits.
    #[error("seed \"{seed}\" is not {degree} binary digits, first chip first, as \"{}\" is",
        "1".repeat(*degree as usize))]
    MalformedSeed {
        /// The seed as given.
        seed: String,
        /// How many digits it should have.
        degree: u32,
    },
    /// A seed from which an LFSR never leaves zero.
    #[error("seed \"{seed}\" is all zero, and an LFSR never leaves that state; set at least one 1")]
    ZeroSeed {
        /// The seed as given.
        seed: String,
    },
    /// A Gold index that names no code of the set.
    #[error("index {index} is outside -2 to {last} (-2 is u, -1 is v, i is u XOR v advanced by i)")]
    IndexOutOfRange {
        /// The index asked for.
        index: i64,
        /// The largest index of the set.
        last: i64,
    },
    /// Chips that are not a string of 0 and 1.
    #[error("chips may hold only the digits 0 and 1, as \"0110\" does, and at least one")]
    MalformedChips,
    /// All chips alike.
    #[error("all chips of this code are {chip}: it carries no time; use a code with both 0 and 1")]
    ConstantCode {
        /// The one value.
        chip: u8,
    },
    /// Chips that come again within the code.
    #[error(
        "this code repeats after {period} of its {length} chips, and two distances would look alike; give \
         it once, as {period} chips"
    )]
    RepeatedCode {
        /// Chips after which it repeats.
        period: usize,
        /// All of its chips.
        length: usize,
    },
    /// The interleaving depth is too large.
    #[error("interleave {interleave} is outside 0 to {MAX_INTERLEAVE}")]
    InterleaveOutOfRange {
        /// The depth asked for.
        interleave: u32,
    },
    /// The code table would be too large.
    #[error(
        "the code is {chips} chips long, more than {MAX_CODE_CHIPS}; use a smaller degree or interleaving depth"
    )]
    TooLong {
        /// Chips per period.
        chips: u64,
    },
}

impl CodeError {
    /// The key of the scene's `code` table that has to change.
    pub fn key(&self) -> &'static str {
        match self {
            CodeError::ForeignKey { key, .. } | CodeError::MissingKey { key, .. } => key,
            CodeError::DegreeOutOfRange { .. } | CodeError::NoPreferredPair { .. } => "degree",
            CodeError::NotPreferred { .. }
            | CodeError::PolynomialCount { .. }
            | CodeError::MalformedPolynomial { .. }
            | CodeError::NotPrimitive { .. } => "polynomials",
            CodeError::SeedCount { .. }
            | CodeError::MalformedSeed { .. }
            | CodeError::ZeroSeed { .. } => "seeds",
            CodeError::IndexOutOfRange { .. } => "index",
            CodeError::MalformedChips
            | CodeError::ConstantCode { .. }
            | CodeError::RepeatedCode { .. } => "chips",
            CodeError::InterleaveOutOfRange { .. } | CodeError::TooLong { .. } => "interleave",
        }
    }
}

/// Degrees near one that 4 divides; the hardware's longest codes first, where it makes
/// none as long as these.
fn degrees_beside(degree: u32) -> String {
    let (below, above) = (degree - 1, degree + 1);
    if above <= MOST_HARDWARE_DEGREE {
        return format!("degree {below} or {above}");
    }
    let longer = if below > MOST_HARDWARE_DEGREE { below } else { above };
    let longest = MOST_HARDWARE_DEGREE - 1;
    format!(
        "degree {longest}, or {longer} in simulation alone (hardware ends at {MOST_HARDWARE_DEGREE})"
    )
}

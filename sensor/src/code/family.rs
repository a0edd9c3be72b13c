//! Families of codes and their names.

use std::fmt;
use std::str::FromStr;

/// Families of codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Family {
    /// A code of a Gold set.
    Gold,
    /// The sequence of one LFSR.
    MSequence,
    /// Chips 1, 0.
    Square,
    /// Chips as given.
    Chips,
}

impl Family {
    /// Every family, under the name that scenes use.
    pub const NAMES: [(&'static str, Family); 4] = [
        ("gold", Family::Gold),
        ("m-sequence", Family::MSequence),
        ("square", Family::Square),
        ("chips", Family::Chips),
    ];

    /// Keys that mean something for this family, besides `interleave`.
    pub(super) fn keys(self) -> &'static [&'static str] {
        match self {
            Family::Gold => &["degree", "index", "polynomials", "seeds", "allow_non_preferred"],
            Family::MSequence => &["degree", "polynomials", "seeds"],
            Family::Square => &[],
            Family::Chips => &["chips"],
        }
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name =
            Family::NAMES.iter().find_map(|(name, family)| (family == self).then_some(*name));
        f.write_str(name.unwrap_or_default())
    }
}

/// A name that is not a family's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not a family of codes; there are gold, m-sequence, square and chips")]
pub struct UnknownFamily(String);

impl FromStr for Family {
    type Err = UnknownFamily;

    fn from_str(text: &str) -> Result<Family, UnknownFamily> {
        Family::NAMES
            .iter()
            .find_map(|(name, family)| (*name == text).then_some(*family))
            .ok_or_else(|| UnknownFamily(text.to_owned()))
    }
}

//! What the names of a design's modules begin with, so that two designs can be one.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::names::check_name;

/// What the name of every module begins with; nothing by default.
///
/// With names of modules of which none is the end of another, as those of goldtof's
/// blocks, designs with different prefixes have no module in common.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Prefix(String);

/// Why a text is not a prefix.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "{reason}; a prefix is a letter and then letters, digits and single underscores, at most {} \
         characters in all, for example left_",
    Prefix::MOST_CHARACTERS
)]
pub struct BadPrefix {
    reason: &'static str,
}

impl Prefix {
    /// Longest prefix: with a module's name and an ending it is the name of a file.
    pub const MOST_CHARACTERS: usize = 64;

    /// The full name of a module or a file.
    pub fn of(&self, name: &str) -> String {
        format!("{}{name}", self.0)
    }

    /// The full name of a macro: in capitals, as macros are.
    pub fn of_macro(&self, name: &str) -> String {
        format!("{}{name}", self.0.to_uppercase())
    }

    /// The name without the prefix, if it begins with it.
    pub fn strip<'n>(&self, name: &'n str) -> Option<&'n str> {
        name.strip_prefix(self.0.as_str())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromStr for Prefix {
    type Err = BadPrefix;

    /// Takes what Verilog and VHDL both take as the beginning of a name.
    fn from_str(text: &str) -> Result<Prefix, BadPrefix> {
        let refuse = |reason| Err(BadPrefix { reason });
        if text.is_empty() {
            return refuse("it is empty");
        }
        if text.len() > Prefix::MOST_CHARACTERS {
            return refuse("it is too long");
        }
        if !text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return refuse("it has other characters than letters, digits and _");
        }
        if !text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return refuse("it does not begin with a letter");
        }
        if text.contains("__") {
            return refuse("it has two underscores in a row, which VHDL does not take");
        }
        match check_name(text) {
            Ok(()) => Ok(Prefix(text.to_owned())),
            Err(_) => refuse("it is a keyword of Verilog"),
        }
    }
}

impl fmt::Display for Prefix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_name_begins_with_is_refused_and_told_why() {
        let long = "a".repeat(65);
        for (bad, reason) in [
            ("", "empty"),
            ("0left_", "begin with a letter"),
            ("_left", "begin with a letter"),
            ("left-", "other characters"),
            ("left ", "other characters"),
            ("l\u{e4}ser_", "other characters"),
            ("\\left ", "other characters"),
            ("a.b", "other characters"),
            ("../a", "other characters"),
            ("le$ft", "other characters"),
            ("left__", "two underscores"),
            ("table", "keyword"),
            ("logic", "keyword"),
            (long.as_str(), "too long"),
        ] {
            let told = Prefix::from_str(bad).expect_err(bad).to_string();
            assert!(told.contains(reason), "{bad}: {told}");
            assert!(told.contains("for example left_"), "{bad}: {told}");
        }
        for good in ["a", "left_", "Left2", &long[1..]] {
            let prefix = Prefix::from_str(good).expect(good);
            assert_eq!(prefix.of("sensor_top"), format!("{good}sensor_top"));
        }
    }

    #[test]
    fn macros_are_in_capitals() {
        let prefix: Prefix = "left_".parse().expect("it is one");
        assert_eq!(prefix.of_macro("SENSOR_TOP_VH"), "LEFT_SENSOR_TOP_VH");
        assert_eq!(Prefix::default().of_macro("SENSOR_TOP_VH"), "SENSOR_TOP_VH");
    }
}

//! Every key of a scene: what it means, and what it may be.
//!
//! The one place for bounds: the reader takes them from here, and so do
//! `docs/scene.md` ([`reference()`]) and `docs/scene.schema.json` ([`schema()`]). Bounds are what the arithmetic keeps
//! precise, or what is physical, whichever is narrower; each key says why.
//!
//! - Time in a simulation is whole chips in 64 bits and an offset within the chip:
//!   2^-53 of a chip at any time. Delays are read as one double, which keeps 2 fs
//!   (0.3 um of distance) up to 10 s, and at the shortest chip period still counts
//!   10^13 chips of the 9 10^15 that a double holds.
//! - Sample numbers are 64 bits: a scan has at most 2^60 samples.
//! - Counts are 64 bits: no more than one per two samples.
//!
//! Bounds that depend on several keys are checked where these are read, and stand
//! at the end of the document.

mod detector;
mod document;
mod light;
mod schema;
mod sensor;

use super::units::{self, Quantity};

pub use document::reference;
pub use schema::schema;

pub(super) use detector::{AFTERPULSING, COUNTER, DETECTOR, JITTER_TAIL};
pub(super) use light::{BACKGROUND, CODE, FLUCTUATION, LINK, PATH, SOURCE};
pub(super) use sensor::{CLOCK, ESTIMATE, HARDWARE, SCAN, STEPS};

/// A key of a table.
#[derive(Debug)]
pub(super) struct Key {
    pub name: &'static str,
    pub kind: Kind,
    /// What it is when it is left out; `None` for a key that must be there.
    pub default: Option<&'static str>,
    /// A right value, without quotation marks.
    pub example: &'static str,
    pub meaning: &'static str,
    /// Where the bounds come from.
    pub why: &'static str,
}

/// What a key takes. Bounds belong to what is allowed.
#[derive(Debug)]
pub(super) enum Kind {
    /// A number and a unit, as text, or a list of them.
    Quantity { quantity: Quantity, least: &'static str, most: &'static str },
    /// A plain number.
    Number { least: f64, most: f64 },
    /// A whole number, or a list of them.
    Integer { least: i64, most: i64 },
    /// Anything else, in words.
    Words(&'static str, Form),
}

/// What is neither a quantity nor a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Text,
    /// A text of digits 0 and 1.
    Digits,
    /// A list of such.
    Texts,
    /// One of some texts.
    Choice(&'static [&'static str]),
    Boolean,
    /// The table of that path.
    Table(&'static str),
    /// "all", or the table of that path.
    AllOr(&'static str),
}

/// The keys of a table.
pub(super) struct Table {
    /// Keys from the root to here, as error messages show them.
    pub path: &'static str,
    pub keys: &'static [Key],
}

/// Every table of a scene.
pub(super) const TABLES: [&Table; 15] = [
    &CLOCK,
    &SOURCE,
    &CODE,
    &DETECTOR,
    &BACKGROUND,
    &AFTERPULSING,
    &JITTER_TAIL,
    &COUNTER,
    &PATH,
    &LINK,
    &FLUCTUATION,
    &SCAN,
    &STEPS,
    &ESTIMATE,
    &HARDWARE,
];

impl Table {
    /// The key of that name.
    ///
    /// # Panics
    /// If there is none, which a test of every table would have shown.
    pub fn key(&self, name: &str) -> &'static Key {
        let found = self.keys.iter().find(|key| key.name == name);
        found.unwrap_or_else(|| unreachable!("the key {}.{name} is not in its table", self.path))
    }
}

impl Key {
    /// Whether `value`, in the base unit of its quantity, is within the bounds.
    pub fn holds(&self, value: f64) -> bool {
        match self.kind {
            Kind::Quantity { .. } => {
                let [least, most] = self.bounds();
                (least..=most).contains(&value)
            }
            Kind::Number { least, most } => (least..=most).contains(&value),
            Kind::Integer { least, most } => (least as f64..=most as f64).contains(&value),
            Kind::Words(..) => true,
        }
    }

    /// How many lists there are round a value: `jitter` is a list, `polynomials` a list
    /// of lists.
    fn lists(&self) -> usize {
        match self.name {
            "jitter" => 1,
            "polynomials" => 2,
            _ => 0,
        }
    }

    /// A right value, as a file has it.
    fn example_toml(&self) -> String {
        let value = match self.kind {
            Kind::Quantity { .. } => format!("\"{}\"", self.example),
            _ => self.example.to_owned(),
        };
        match self.lists() {
            0 => value,
            1 => format!("[{value}]"),
            // Whatever the bounds of an exponent, a polynomial has several.
            _ => "[[11, 2, 0], [11, 8, 5, 2, 0]]".to_owned(),
        }
    }

    /// The bounds of a quantity, in its base unit.
    fn bounds(&self) -> [f64; 2] {
        let Kind::Quantity { quantity, least, most } = self.kind else {
            unreachable!("{} is no quantity", self.name)
        };
        [least, most].map(|bound| {
            let read = units::parse(bound, quantity, self.example);
            read.unwrap_or_else(|wrong| unreachable!("a bound of {}: {wrong}", self.name))
        })
    }

    /// What is wrong with `shown`, a value outside of the bounds, and what would be
    /// right.
    pub fn outside(&self, shown: &str) -> String {
        let example = self.example;
        match self.kind {
            Kind::Quantity { least, most, .. } => format!(
                "{shown} is outside \"{least}\" to \"{most}\"; write for example \"{example}\""
            ),
            Kind::Number { least, most } => {
                format!("{shown} is outside {least} to {most}; write for example {example}")
            }
            Kind::Integer { least, most } => {
                format!("{shown} is outside {least} to {most}; write for example {example}")
            }
            Kind::Words(words, _) => format!("{shown} is not {words}; write for example {example}"),
        }
    }
}

#[cfg(test)]
mod tests;

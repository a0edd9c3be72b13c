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

mod document;
mod plain;
mod schema;

use super::units::{self, Quantity};

pub use document::reference;
pub use schema::schema;

pub(super) use plain::Plain;

use super::budget::{BACKGROUND, LINK};
use super::detector::{AFTERPULSING, COUNTER, DETECTOR, JITTER_TAIL};
use super::estimator::ESTIMATE;
use super::hardware::HARDWARE;
use super::movement::FLUCTUATION;
use super::scan::{SCAN, STEPS};
use super::source::{CODE, PATH, SOURCE};
use super::whole::CLOCK;
use super::wording::{alternatives, quoted};

/// What a declaration of keys needs.
pub(super) mod declare {
    pub(in crate::scene) use super::Absent::{Needed, Or, Otherwise};
    pub(in crate::scene) use super::{
        BOOLEAN, Form, Key, Kind, Plain, Table, choice, choices, integer, names, number, quantity,
        ratio, table, tables, words,
    };
    pub(in crate::scene) use crate::scene::reader::Section;
    pub(in crate::scene) use crate::scene::units::Quantity::{self, *};
}

/// Declares tables, each key of them once: `key = kind, when left out, example; "meaning" "why
/// these bounds";`. Of a table that is a struct, `key => field: type = ...` is a field, which is
/// read as it is written, and in braces stand the fields that other keys decide.
macro_rules! tables {
    () => {};
    (
        $(#[$about:meta])*
        $vis:vis struct $Struct:ident { $($(#[$doc:meta])* $other:ident: $other_type:ty,)* }
        of $name:ident = $path:literal $(and $shared:ident)? {
            $($key:ident $(=> $field:ident: $type:ty)? = $kind:expr, $absent:expr, $example:literal;
              $meaning:literal $($why:literal)?;)*
        }
        $($rest:tt)*
    ) => {
        $(#[$about])*
        $vis struct $Struct {
            $($(#[doc = $meaning] pub $field: $type,)?)*
            $($(#[$doc])* pub $other: $other_type,)*
        }

        impl $Struct {
            /// The keys that are fields, as they are read, beside defaults; what is wrong with
            /// them is reported.
            fn keys(section: &Section) -> Option<$Struct> {
                $($(let $field = <$type as Plain>::read(section, stringify!($key));)?)*
                Some($Struct {
                    $($($field: $field?,)?)*
                    $($other: Default::default(),)*
                })
            }
        }

        impl Default for $Struct {
            /// Of an empty table.
            fn default() -> $Struct {
                $Struct {
                    $($($field: <$type as Plain>::left_out($name.key(stringify!($key))),)?)*
                    $($other: Default::default(),)*
                }
            }
        }

        tables! {
            $name = $path $(and $shared)? {
                $($key = $kind, $absent, $example; $meaning $($why)?;)*
            }
            $($rest)*
        }
    };
    (
        $name:ident = $path:literal $(and $shared:ident)? {
            $($key:ident = $kind:expr, $absent:expr, $example:literal; $meaning:literal $($why:literal)?;)*
        }
        $($rest:tt)*
    ) => {
        pub(in crate::scene) static $name: Table = Table::new(
            $path,
            &[$(Key {
                name: stringify!($key),
                kind: $kind,
                absent: $absent,
                example: $example,
                meaning: $meaning,
                why: concat!("", $($why)?),
            },)*],
            &[$(&$shared)?],
        );

        tables! { $($rest)* }
    };
}

/// Declares the values of a key, each with the name that scenes use.
macro_rules! choices {
    (
        $(#[$about:meta])*
        pub enum $Enum:ident { $($(#[$doc:meta])* $Value:ident = $name:literal,)* }
    ) => {
        $(#[$about])*
        pub enum $Enum { $($(#[$doc])* $Value,)* }

        impl $Enum {
            const CHOICES: &'static [&'static str] = &[$($name),*];

            /// Each of them, under the name that scenes use.
            pub const NAMES: &'static [(&'static str, $Enum)] = &[$(($name, $Enum::$Value)),*];
        }

        impl Plain for $Enum {
            fn read(section: &Section, name: &'static str) -> Option<$Enum> {
                section.choice(name, $Enum::NAMES)
            }

            fn left_out(key: &Key) -> $Enum {
                let is_default = |(name, _): &&(&str, $Enum)| key.default() == Some(*name);
                $Enum::NAMES.iter().find(is_default).unwrap_or(&$Enum::NAMES[0]).1
            }
        }
    };
}

pub(super) use {choices, tables};

/// A key of a table.
#[derive(Debug)]
pub(super) struct Key {
    pub name: &'static str,
    pub kind: Kind,
    pub absent: Absent,
    /// A right value, without quotation marks.
    pub example: &'static str,
    pub meaning: &'static str,
    /// Where the bounds come from.
    pub why: &'static str,
}

/// A key's value when it is left out.
#[derive(Debug, Clone, Copy)]
pub(super) enum Absent {
    /// It may not be.
    Needed,
    /// This value, and behind a colon what that means.
    Or(&'static str),
    /// Something that other keys decide, in words.
    Otherwise(&'static str),
}

/// Type and bounds of a key; a value at a bound is allowed.
#[derive(Debug)]
pub(super) enum Kind {
    /// A number and a unit, as text, or a list of them.
    Quantity { quantity: Quantity, least: &'static str, most: &'static str },
    /// A plain number; `or_inf` for one that may be "inf" too.
    Number { least: f64, most: f64, or_inf: bool },
    /// A whole number, or a list of them.
    Integer { least: i64, most: i64 },
    /// Anything else, in words.
    Words(&'static str, Form),
}

pub(super) const fn quantity(quantity: Quantity, least: &'static str, most: &'static str) -> Kind {
    Kind::Quantity { quantity, least, most }
}

pub(super) const fn number(least: f64, most: f64) -> Kind {
    Kind::Number { least, most, or_inf: false }
}

pub(super) const fn ratio(least: f64, most: f64) -> Kind {
    Kind::Number { least, most, or_inf: true }
}

pub(super) const fn integer(least: i64, most: i64) -> Kind {
    Kind::Integer { least, most }
}

pub(super) const fn words(words: &'static str, form: Form) -> Kind {
    Kind::Words(words, form)
}

pub(super) const fn table(path: &'static str) -> Kind {
    Kind::Words("a table", Form::Table(path))
}

pub(super) const fn choice(names: &'static [&'static str]) -> Kind {
    Kind::Words("one of its names", Form::Choice(names))
}

pub(super) const BOOLEAN: Kind = Kind::Words("true or false", Form::Boolean);

/// The names of a list of names and values.
pub(super) const fn names<T, const N: usize>(named: &[(&'static str, T); N]) -> [&'static str; N] {
    let mut names = [""; N];
    let mut n = 0;
    while n < N {
        names[n] = named[n].0;
        n += 1;
    }
    names
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
    keys: &'static [Key],
    /// Tables whose keys it has too.
    shared: &'static [&'static Table],
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
    pub const fn new(
        path: &'static str,
        keys: &'static [Key],
        shared: &'static [&'static Table],
    ) -> Table {
        Table { path, keys, shared }
    }

    /// All of its keys, shared ones last.
    pub fn keys(&self) -> impl Iterator<Item = &'static Key> + use<> {
        self.keys.iter().chain(self.shared.iter().flat_map(|table| table.keys))
    }

    /// The key of that name.
    ///
    /// # Panics
    /// If there is none, which a test of every table would have shown.
    pub fn key(&self, name: &str) -> &'static Key {
        let found = self.keys().find(|key| key.name == name);
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
            Kind::Number { least, most, or_inf } => {
                (least..=most).contains(&value) || (or_inf && value == f64::INFINITY)
            }
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

    /// The value that it is when it is left out, if that is one, without quotation marks.
    pub fn default(&self) -> Option<&'static str> {
        match self.absent {
            Absent::Or(text) => {
                let value = text.split_once(": ").map_or(text, |(value, _)| value);
                Some(value.trim_matches('"'))
            }
            Absent::Needed | Absent::Otherwise(_) => None,
        }
    }

    /// [`Key::default`] of a number or a quantity, in its base unit.
    pub fn default_number(&self) -> Option<f64> {
        let text = self.default()?;
        match self.kind {
            Kind::Quantity { quantity, .. } => units::parse(text, quantity, self.example).ok(),
            _ => text.parse().ok(),
        }
    }

    /// Its value when it is left out, in words.
    fn when_left_out(&self) -> &'static str {
        match self.absent {
            Absent::Needed => "it must be given",
            Absent::Or(text) | Absent::Otherwise(text) => text,
        }
    }

    /// A right value, as error messages offer it.
    pub fn shown_example(&self) -> String {
        match self.kind {
            Kind::Quantity { .. } => format!("\"{}\"", self.example),
            _ => self.example.to_owned(),
        }
    }

    /// Its range, in words.
    fn range(&self) -> String {
        match self.kind {
            Kind::Quantity { least, most, .. } => format!("{least} to {most}"),
            Kind::Number { least, most, .. } => format!("{least} to {most}"),
            Kind::Integer { least, most } => format!("{least} to {most}"),
            Kind::Words(_, Form::Choice(names)) => alternatives(&quoted(names)),
            Kind::Words(words, _) => words.to_owned(),
        }
    }

    /// A right value, as a file has it.
    fn example_toml(&self) -> String {
        let value = self.shown_example();
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
            unreachable!("{} is not a quantity", self.name)
        };
        [least, most].map(|bound| {
            let read = units::parse(bound, quantity, self.example);
            read.unwrap_or_else(|wrong| unreachable!("a bound of {}: {wrong}", self.name))
        })
    }

    /// What is wrong with `shown`, a value outside of the bounds, and what would be
    /// right.
    pub fn outside(&self, shown: &str) -> String {
        let is_not = match self.kind {
            Kind::Quantity { least, most, .. } => format!("outside \"{least}\" to \"{most}\""),
            Kind::Words(..) => format!("not {}", self.range()),
            _ => format!("outside {}", self.range()),
        };
        let or_inf = self.or_inf();
        format!("{shown} is {is_not}; write for example {}{or_inf}", self.shown_example())
    }

    /// What is said behind an example, of a number that may be "inf", too.
    pub fn or_inf(&self) -> &'static str {
        match self.kind {
            Kind::Number { or_inf: true, .. } => ", or \"inf\"",
            _ => "",
        }
    }
}

#[cfg(test)]
mod tests;

//! What a key of a scene is: its type, bounds, default, meaning. Tables of keys are declared beside
//! their readers (`super::declare`).

use super::units::{self, Quantity};
use super::wording::{alternatives, quoted};

/// A key of a table.
#[derive(Debug)]
pub(super) struct Key {
    pub name: &'static str,
    pub kind: KeyKind,
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
pub(super) enum KeyKind {
    /// A number and a unit, as text, or a list of them.
    Quantity { quantity: Quantity, least: &'static str, most: &'static str },
    /// A plain number, or a list of them; `or_inf` for one that may be "inf" too.
    Number { least: f64, most: f64, or_inf: bool },
    /// A whole number, or a list of them.
    Integer { least: i64, most: i64 },
    /// Anything else, in words.
    Words(&'static str, Form),
}

pub(super) const fn quantity(
    quantity: Quantity,
    least: &'static str,
    most: &'static str,
) -> KeyKind {
    KeyKind::Quantity { quantity, least, most }
}

pub(super) const fn number(least: f64, most: f64) -> KeyKind {
    KeyKind::Number { least, most, or_inf: false }
}

pub(super) const fn ratio(least: f64, most: f64) -> KeyKind {
    KeyKind::Number { least, most, or_inf: true }
}

pub(super) const fn integer(least: i64, most: i64) -> KeyKind {
    KeyKind::Integer { least, most }
}

pub(super) const fn words(words: &'static str, form: Form) -> KeyKind {
    KeyKind::Words(words, form)
}

pub(super) const fn table(path: &'static str) -> KeyKind {
    KeyKind::Words("a table", Form::Table(path))
}

pub(super) const fn choice(names: &'static [&'static str]) -> KeyKind {
    KeyKind::Words("one of its names", Form::Choice(names))
}

pub(super) const BOOLEAN: KeyKind = KeyKind::Words("true or false", Form::Boolean);

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
pub(super) struct KeyTable {
    /// Keys from the root to here, as error messages show them.
    pub path: &'static str,
    keys: &'static [Key],
    /// Tables whose keys it has too.
    shared: &'static [&'static KeyTable],
}

impl KeyTable {
    pub const fn new(
        path: &'static str,
        keys: &'static [Key],
        shared: &'static [&'static KeyTable],
    ) -> KeyTable {
        KeyTable { path, keys, shared }
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
            KeyKind::Quantity { .. } => {
                let [least, most] = self.bounds();
                (least..=most).contains(&value)
            }
            KeyKind::Number { least, most, or_inf } => {
                (least..=most).contains(&value) || (or_inf && value == f64::INFINITY)
            }
            KeyKind::Integer { least, most } => (least as f64..=most as f64).contains(&value),
            KeyKind::Words(..) => true,
        }
    }

    /// How many lists there are round a value: `jitter` and `widths` are lists, as are the
    /// tables of a room, `polynomials` a list of lists.
    pub fn lists(&self) -> usize {
        match self.name {
            "jitter" | "widths" | "cell_dark_count_rates" | "plane" | "sphere" | "light" => 1,
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
            KeyKind::Quantity { quantity, .. } => units::parse(text, quantity, self.example).ok(),
            _ => text.parse().ok(),
        }
    }

    /// Its value when it is left out, in words.
    pub fn when_left_out(&self) -> &'static str {
        match self.absent {
            Absent::Needed => "it must be given",
            Absent::Or(text) | Absent::Otherwise(text) => text,
        }
    }

    /// A right value, as error messages offer it.
    pub fn shown_example(&self) -> String {
        match self.kind {
            KeyKind::Quantity { .. } => format!("\"{}\"", self.example),
            _ => self.example.to_owned(),
        }
    }

    /// Its range, in words.
    pub fn range(&self) -> String {
        match self.kind {
            KeyKind::Quantity { least, most, .. } => format!("{least} to {most}"),
            KeyKind::Number { least, most, .. } => format!("{least} to {most}"),
            KeyKind::Integer { least, most } => format!("{least} to {most}"),
            KeyKind::Words(_, Form::Choice(names)) => alternatives(&quoted(names)),
            KeyKind::Words(words, _) => words.to_owned(),
        }
    }

    /// A right value, as a file has it.
    pub fn example_toml(&self) -> String {
        let value = self.shown_example();
        match self.lists() {
            0 => value,
            1 => format!("[{value}]"),
            // Whatever the bounds of an exponent, a polynomial has several.
            _ => "[[11, 2, 0], [11, 8, 5, 2, 0]]".to_owned(),
        }
    }

    /// The bounds of a quantity, in its base unit.
    pub fn bounds(&self) -> [f64; 2] {
        let KeyKind::Quantity { quantity, least, most } = self.kind else {
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
            KeyKind::Quantity { least, most, .. } => format!("outside \"{least}\" to \"{most}\""),
            KeyKind::Words(..) => format!("not {}", self.range()),
            _ => format!("outside {}", self.range()),
        };
        let or_inf = self.or_inf();
        format!("{shown} is {is_not}; write for example {}{or_inf}", self.shown_example())
    }

    /// What is said behind an example, of a number that may be "inf", too.
    pub fn or_inf(&self) -> &'static str {
        match self.kind {
            KeyKind::Number { or_inf: true, .. } => ", or \"inf\"",
            _ => "",
        }
    }
}

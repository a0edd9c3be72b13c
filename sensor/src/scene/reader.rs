//! Reads keys of one TOML table, and reports what is wrong with them.

use std::cell::RefCell;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::error::Diagnostics;
use super::keys::{Absent, Key, KeyKind, KeyTable};
use super::units::{self, Quantity};
use super::wording::{alternatives, nearest, quoted};

/// Most tables of one kind in a scene.
pub(super) const MAX_TABLES: usize = 256;

/// A value and where it stands in the file.
pub(super) type SceneValue<'r, 't> = &'r Spanned<DeValue<'t>>;

/// One TOML table. Readers of numbers, choices and booleans return the key's default where it
/// has one and is left out. They return `None` for a key that is left out and has none, and
/// for one that is wrong; the latter is reported, and so is a key that must be given.
pub(super) struct Section<'r, 't> {
    diagnostics: &'r Diagnostics<'t>,
    /// Every table of a scene.
    tables: &'static [&'static KeyTable],
    /// `None` for one that is left out: every key of it is, too.
    table: Option<&'r DeTable<'t>>,
    span: Range<usize>,
    /// Keys from the root to here, as error messages show them.
    path: String,
    /// Keys asked for so far; all others are unknown.
    known: RefCell<Vec<&'static str>>,
}

impl<'r, 't> Section<'r, 't> {
    pub(super) fn new(
        diagnostics: &'r Diagnostics<'t>,
        tables: &'static [&'static KeyTable],
        table: &'r DeTable<'t>,
        span: Range<usize>,
        path: String,
    ) -> Self {
        Section { diagnostics, tables, table: Some(table), span, path, known: RefCell::default() }
    }

    /// The value of `key`, which is from now on a known key.
    pub(super) fn get(&self, key: &'static str) -> Option<SceneValue<'r, 't>> {
        let mut known = self.known.borrow_mut();
        if !known.contains(&key) {
            known.push(key);
        }
        self.table?.get(key)
    }

    /// What a key of this table means and may be.
    ///
    /// # Panics
    /// If it is in no table of keys.
    pub(super) fn key(&self, name: &str) -> &'static Key {
        let table = self.tables.iter().find(|table| table.path == self.path);
        match table {
            Some(table) => table.key(name),
            None => unreachable!("there is no table of keys \"{}\"", self.path),
        }
    }

    /// [`Section::get`], and a complaint where a key that must be given is left out.
    fn given(&self, name: &'static str) -> Option<SceneValue<'r, 't>> {
        let key = self.key(name);
        if let Absent::Needed = key.absent {
            self.require(name, &key.shown_example());
        }
        self.get(name)
    }

    /// Reports that a key is missing, unless it is there; the example suits the file.
    pub(super) fn require(&self, key: &'static str, example: &str) {
        if self.get(key).is_none() {
            self.complain(&format!("`{key}` is missing; write for example {key} = {example}"));
        }
    }

    /// Reports something wrong with the value of `key`, or with the whole
    /// table if the key is not there.
    pub(super) fn report(&self, key: &str, message: &str) {
        match self.table.and_then(|table| table.get(key)) {
            Some(value) => self.report_at(key, value, message),
            None => self.complain(message),
        }
    }

    /// Reports something wrong with the whole table.
    pub(super) fn complain(&self, message: &str) {
        let message = match self.path.as_str() {
            "" => message.to_owned(),
            path => format!("{path}: {message}"),
        };
        self.diagnostics.report(self.span.clone(), message);
    }

    /// [`Section::complain`] for when the section has been read.
    pub(super) fn complaint(&self) -> impl Fn(&str) + use<'r, 't> {
        let (diagnostics, span) = (self.diagnostics, self.span.clone());
        let path = self.path.clone();
        move |message| diagnostics.report(span.clone(), format!("{path}: {message}"))
    }

    /// Reports something wrong with `value`, which belongs to `key`.
    pub(super) fn report_at(&self, key: &str, value: SceneValue, message: &str) {
        let path = self.path_of(key);
        self.diagnostics.report(value.span(), format!("{path}: {message}"));
    }

    /// What was read of `value`, which belongs to `key`; what is wrong with it is reported.
    fn told<T>(&self, key: &str, value: SceneValue, read: Result<T, String>) -> Option<T> {
        read.map_err(|message| self.report_at(key, value, &message)).ok()
    }

    /// How much was wrong with the scene so far.
    pub(super) fn complaints(&self) -> usize {
        self.diagnostics.reported()
    }

    /// Reports every key that was never asked for.
    pub(super) fn finish(self) {
        let known = self.known.borrow();
        for key in self.table.into_iter().flat_map(DeTable::keys) {
            let name = key.get_ref().as_ref();
            if known.contains(&name) {
                continue;
            }
            let place = match self.path.as_str() {
                "" => "a scene".to_owned(),
                path => format!("`{path}`"),
            };
            let advice = match nearest(name, &known) {
                Some(nearest) => format!("did you mean `{nearest}`?"),
                None => format!("it takes {}", alternatives(&known)),
            };
            self.diagnostics.report(
                key.span(),
                format!("{}: {place} has no key `{name}`; {advice}", self.path_of(name)),
            );
        }
    }

    /// A quantity in its unit (see [`Quantity`]), within its bounds.
    pub(super) fn quantity(&self, name: &'static str) -> Option<f64> {
        match self.given(name) {
            Some(value) => self.quantity_of(name, value, self.key(name)),
            None => self.key(name).default_number(),
        }
    }

    /// Every quantity of a list.
    pub(super) fn quantities(&self, name: &'static str, example: &str) -> Vec<f64> {
        self.list(name, example, |value| self.quantity_of(name, value, self.key(name)))
    }

    fn list<T>(
        &self,
        name: &'static str,
        example: &str,
        read: impl Fn(SceneValue) -> Option<T>,
    ) -> Vec<T> {
        let array = self.array(name, example).into_iter().flat_map(|array| array.iter());
        array.filter_map(read).collect()
    }

    /// The quantity `value` of the key `name`, if it is what `key` says.
    pub(super) fn quantity_of(&self, name: &str, value: SceneValue, key: &Key) -> Option<f64> {
        let KeyKind::Quantity { quantity, .. } = key.kind else {
            unreachable!("{name} is not a quantity");
        };
        let parsed = self.parse_quantity(value, quantity, key.example);
        let checked = parsed.and_then(|number| match key.holds(number) {
            true => Ok(number),
            false => Err(key.outside(&self.excerpt(value))),
        });
        self.told(name, value, checked)
    }

    fn parse_quantity(
        &self,
        value: SceneValue,
        quantity: Quantity,
        example: &str,
    ) -> Result<f64, String> {
        match value.get_ref() {
            DeValue::String(text) => units::parse(text, quantity, example),
            DeValue::Integer(_) | DeValue::Float(_) => {
                let number = self.excerpt(value);
                Err(units::missing_unit(&number, &number, example))
            }
            _ => Err(self.wrong_type(value, quantity.name(), &format!("\"{example}\""))),
        }
    }

    /// A plain number within its bounds, or "inf" where the key takes that.
    pub(super) fn number(&self, name: &'static str) -> Option<f64> {
        let key = self.key(name);
        match self.given(name) {
            Some(value) => self.number_of(name, value, key),
            None => key.default_number(),
        }
    }

    /// Every number of a list.
    pub(super) fn numbers(&self, name: &'static str, example: &str) -> Vec<f64> {
        self.list(name, example, |value| self.number_of(name, value, self.key(name)))
    }

    /// The number `value` of the key `name`, if it is what `key` says.
    fn number_of(&self, name: &'static str, value: SceneValue, key: &Key) -> Option<f64> {
        let number: Option<f64> = match value.get_ref() {
            DeValue::Integer(digits) => digits.to_string().parse().ok(),
            DeValue::Float(digits) => digits.as_str().parse().ok(),
            DeValue::String(text) if text == "inf" && key.holds(f64::INFINITY) => {
                Some(f64::INFINITY)
            }
            _ => {
                let wrong = self.wrong_type(value, "a plain number", key.example);
                return self.told(name, value, Err(wrong + key.or_inf()));
            }
        };
        let within = number.filter(|&number| key.holds(number));
        self.told(name, value, within.ok_or_else(|| key.outside(&self.excerpt(value))))
    }

    /// A whole number within its bounds.
    pub(super) fn integer(&self, name: &'static str) -> Option<i64> {
        match self.given(name) {
            Some(value) => self.integer_of(name, value),
            None => self.key(name).default()?.parse().ok(),
        }
    }

    /// [`Section::integer`] of a key whose bounds no negative number keeps.
    pub(super) fn count<T: TryFrom<i64>>(&self, name: &'static str) -> Option<T> {
        self.integer(name).and_then(|number| T::try_from(number).ok())
    }

    /// Like [`Section::integer`], for a value already found.
    pub(super) fn integer_of(&self, name: &str, value: SceneValue) -> Option<i64> {
        let key = self.key(name);
        let KeyKind::Integer { least, most } = key.kind else {
            unreachable!("{name} is not a whole number");
        };
        let read = match value.get_ref() {
            DeValue::Integer(digits) => {
                let number = i64::from_str_radix(digits.as_str(), digits.radix()).ok();
                let within = number.filter(|number| (least..=most).contains(number));
                within.ok_or_else(|| key.outside(&self.excerpt(value)))
            }
            _ => Err(self.wrong_type(value, "a whole number", key.example)),
        };
        self.told(name, value, read)
    }

    /// A string; `example` without its quotation marks.
    pub(super) fn string(&self, key: &'static str, example: &str) -> Option<&'r str> {
        let value = self.get(key)?;
        self.string_of(key, value, example)
    }

    /// Like [`Section::string`], for a value already found.
    pub(super) fn string_of(
        &self,
        key: &str,
        value: SceneValue<'r, 't>,
        example: &str,
    ) -> Option<&'r str> {
        let text = value.get_ref().as_str();
        let wrong = || self.wrong_type(value, "a string", &format!("\"{example}\""));
        self.told(key, value, text.ok_or_else(wrong))
    }

    /// `true` or `false`.
    pub(super) fn boolean(&self, key: &'static str) -> Option<bool> {
        let Some(value) = self.given(key) else {
            return self.key(key).default()?.parse().ok();
        };
        let wrong = || self.wrong_type(value, "true or false", "true");
        self.told(key, value, value.get_ref().as_bool().ok_or_else(wrong))
    }

    /// One of a set of names.
    pub(super) fn choice<T: Copy>(&self, key: &'static str, choices: &[(&str, T)]) -> Option<T> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        let text = match self.given(key) {
            Some(value) => self.string_of(key, value, names.first().unwrap_or(&""))?,
            None => self.key(key).default()?,
        };
        let chosen = choices.iter().find(|(name, _)| *name == text);
        if chosen.is_none() {
            let advice = match nearest(text, &names) {
                Some(nearest) => format!("did you mean \"{nearest}\"?"),
                None => format!("it may be {}", alternatives(&quoted(&names))),
            };
            self.report(key, &format!("\"{text}\" is not known; {advice}"));
        }
        chosen.map(|(_, value)| *value)
    }

    /// An array.
    pub(super) fn array(&self, key: &'static str, example: &str) -> Option<&'r DeArray<'t>> {
        let value = self.get(key)?;
        self.array_of(key, value, example)
    }

    /// Like [`Section::array`], for a value already found.
    pub(super) fn array_of(
        &self,
        key: &str,
        value: SceneValue<'r, 't>,
        example: &str,
    ) -> Option<&'r DeArray<'t>> {
        let wrong = || self.wrong_type(value, "an array", example);
        self.told(key, value, value.get_ref().as_array().ok_or_else(wrong))
    }

    /// A table below this one.
    pub(super) fn section(&self, name: &'static str) -> Option<Section<'r, 't>> {
        let value = self.given(name)?;
        self.section_of(name, value, self.key(name).example)
    }

    /// A table of the scene.
    pub(super) fn table(&self, name: &'static str) -> Option<Section<'r, 't>> {
        self.section_of(name, self.get(name)?, &format!("[{name}]"))
    }

    /// A table below this one; one that is left out, or wrong, has its keys' defaults.
    pub(super) fn section_or_defaults(&self, name: &'static str) -> Section<'r, 't> {
        let example = match self.path.as_str() {
            "" => format!("[{name}]"),
            _ => self.key(name).example.to_owned(),
        };
        let section = self.get(name).and_then(|value| self.section_of(name, value, &example));
        section.unwrap_or_else(|| Section {
            diagnostics: self.diagnostics,
            tables: self.tables,
            table: None,
            span: self.span.clone(),
            path: self.path_of(name),
            known: RefCell::default(),
        })
    }

    /// Like [`Section::section`], for a value already found.
    pub(super) fn section_of(
        &self,
        key: &str,
        value: SceneValue<'r, 't>,
        example: &str,
    ) -> Option<Section<'r, 't>> {
        let wrong = || self.wrong_type(value, "a table", example);
        let table = self.told(key, value, value.get_ref().as_table().ok_or_else(wrong))?;
        let path = self.path_of(key);
        Some(Section::new(self.diagnostics, self.tables, table, value.span(), path))
    }

    /// The tables of an array of tables, `[[key]]`; of more than `most` of them
    /// only the first so many, and a complaint.
    pub(super) fn sections(&self, key: &'static str, most: usize) -> Vec<Section<'r, 't>> {
        let example = format!("[[{}]]", self.path_of(key));
        let array = self.array(key, &example);
        let count = array.map_or(0, |array| array.len());
        if count > most {
            let message = format!("{count} tables {example} are more than {most}; use fewer");
            self.report(key, &message);
        }
        array
            .into_iter()
            .flat_map(|array| array.iter())
            .take(most)
            .filter_map(|value| self.section_of(key, value, &example))
            .collect()
    }

    /// What all tables of an array of tables are, each read so that every error is reported; `None`
    /// if one of them is wrong.
    pub(super) fn all<T>(
        &self,
        key: &'static str,
        read: impl FnMut(Section<'r, 't>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let values: Vec<Option<T>> = self.sections(key, MAX_TABLES).into_iter().map(read).collect();
        values.into_iter().collect()
    }

    /// The text of a value as the file has it, shortened.
    pub(super) fn excerpt(&self, value: SceneValue) -> String {
        self.diagnostics.excerpt(value.span())
    }

    /// The complaint about a value of the wrong TOML type.
    pub(super) fn wrong_type(&self, value: SceneValue, needed: &str, example: &str) -> String {
        let kind = match value.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) => "an integer",
            DeValue::Float(_) => "a float",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date or time of day",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        };
        format!(
            "{} is {kind}, but {needed} is needed; write for example {example}",
            self.excerpt(value)
        )
    }

    fn path_of(&self, key: &str) -> String {
        match self.path.as_str() {
            "" => key.to_owned(),
            path => format!("{path}.{key}"),
        }
    }
}

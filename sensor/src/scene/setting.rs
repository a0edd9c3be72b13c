//! One key of a scene, set from outside of its file: `path.distance=5 m`.

use std::borrow::Cow;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::wording::{alternatives, quoted};

/// A key and its value, as `--set` has them.
///
/// Keys are those of the file, joined by dots. A table of several of its kind is told
/// by its number, from 0, or by its name: `source[0].mean_power`,
/// `source[laser].mean_power`; of an only one that may be left out. The value is TOML; what
/// is not one is a text, so that a quantity needs no quotation marks. In JSON it is key and value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(into = "String", try_from = "String")]
#[schemars(with = "String")]
pub struct Setting {
    parts: Vec<KeyPart>,
    /// The value, as TOML.
    value: String,
    /// Where it comes from, for error messages.
    origin: String,
}

/// One step of the way to a key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum KeyPart {
    Key(String),
    Index(usize),
    Name(String),
}

impl KeyPart {
    /// Of a key, not of a number or a name in brackets.
    pub(super) fn name(&self) -> Option<&str> {
        match self {
            KeyPart::Key(name) => Some(name),
            KeyPart::Index(_) | KeyPart::Name(_) => None,
        }
    }
}

/// Parts of the longest key that is read: a scene's own have four.
pub const MOST_KEY_PARTS: usize = 16;

const EXAMPLE: &str = "write for example path.distance=\"5 m\" or source[0].mean_power=\"1 pW\"";

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Setting, String> {
        let split = Setting::split(text).map_err(|problem| format!("{problem}; {EXAMPLE}"));
        let (key, value) = split?;
        Setting::of(key, value, "--set")
    }
}

impl From<Setting> for String {
    fn from(setting: Setting) -> String {
        setting.assignment().to_owned()
    }
}

impl TryFrom<String> for Setting {
    type Error = String;

    fn try_from(text: String) -> Result<Setting, String> {
        text.parse()
    }
}

impl Setting {
    /// Key and value of `KEY=VALUE`; the name in `source[NAME]` may have an equals sign, too.
    ///
    /// # Errors
    /// If there is none.
    pub fn split(text: &str) -> Result<(&str, &str), &'static str> {
        let mut depth = 0;
        for (at, character) in text.char_indices() {
            match character {
                '[' => depth += 1,
                ']' => depth -= 1,
                '=' if depth == 0 => return Ok((text[..at].trim(), text[at + 1..].trim())),
                _ => {}
            }
        }
        Err("there is no \"=\" in it")
    }

    /// The setting of `key` to `value`, which `option` of the command line asked for.
    ///
    /// # Errors
    /// If the key is none.
    pub fn of(key: &str, value: &str, option: &str) -> Result<Setting, String> {
        Ok(Setting {
            parts: parts(key)?,
            value: as_toml(value),
            origin: format!("{option} {key}={value}"),
        })
    }

    /// Where it comes from, for error messages: `--set path.distance=5 m`.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Key and value, without the option that they stood behind.
    pub(super) fn assignment(&self) -> &str {
        self.origin.split_once(' ').map_or("", |(_, rest)| rest)
    }

    /// Key and value, as [`Setting::of`] takes them.
    pub fn key_and_value(&self) -> (&str, &str) {
        Setting::split(self.assignment()).unwrap_or_default()
    }

    /// Its value as a line of TOML.
    pub(super) fn line(&self) -> String {
        format!("v = {}", self.value)
    }

    /// Puts its value into a document.
    ///
    /// # Errors
    /// If the document has no such key; the message names those that it has.
    pub(super) fn apply<'t>(
        &self,
        root: &mut DeTable<'t>,
        value: Spanned<DeValue<'t>>,
    ) -> Result<(), String> {
        into_table(root, &self.parts, value, "")
    }
}

/// Puts settings into a document, each with its line of TOML; `refuse` hears of those, by their
/// number, that do not go into it.
pub(super) fn with_settings<'t>(
    document: &mut Spanned<DeTable<'t>>,
    settings: impl Iterator<Item = (&'t Setting, &'t str)>,
    mut refuse: impl FnMut(usize, String),
) {
    for (index, (setting, line)) in settings.enumerate() {
        let value = DeTable::parse(line).ok().and_then(|table| {
            let mut values = table.into_inner().into_iter();
            values.next().map(|(_, value)| value)
        });
        let applied = match value {
            Some(value) => setting.apply(document.get_mut(), value),
            None => Err("the value is not TOML".to_owned()),
        };
        if let Err(message) = applied {
            refuse(index, message);
        }
    }
}

/// The parts of a key: `a`, `a[0].b`, `a[name].b`.
pub(super) fn parts(key: &str) -> Result<Vec<KeyPart>, String> {
    let too_long =
        || format!("a key of more than {MOST_KEY_PARTS} parts is not a key of a scene; {EXAMPLE}");
    let mut parts = Vec::new();
    let mut rest = key;
    loop {
        let end = rest.find(['.', '[']).unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(is_bare) {
            return Err(format!("\"{key}\" is not a key; {EXAMPLE}"));
        }
        if parts.len() >= MOST_KEY_PARTS {
            return Err(too_long());
        }
        parts.push(KeyPart::Key(name.to_owned()));
        rest = after;
        while let Some(inside) = rest.strip_prefix('[') {
            let Some((which, after)) = inside.split_once(']') else {
                return Err(format!("\"{key}\" has no closing bracket; {EXAMPLE}"));
            };
            if parts.len() >= MOST_KEY_PARTS {
                return Err(too_long());
            }
            let which = which.trim().trim_matches('"');
            parts.push(match which.parse() {
                Ok(index) => KeyPart::Index(index),
                Err(_) => KeyPart::Name(which.to_owned()),
            });
            rest = after;
        }
        match rest.strip_prefix('.') {
            Some(after) => rest = after,
            None if rest.is_empty() => return Ok(parts),
            None => return Err(format!("\"{key}\" is not a key; {EXAMPLE}")),
        }
    }
}

/// A value that is TOML as it stands, else as a text.
fn as_toml(value: &str) -> String {
    let line = format!("v = {value}");
    match DeTable::parse(&line) {
        Ok(table) if table.get_ref().len() == 1 && !value.contains('\n') => value.to_owned(),
        _ => toml::Value::String(value.to_owned()).to_string(),
    }
}

/// The key that a table gets which is not in the file.
fn key<'t>(name: &str, span: Range<usize>) -> Spanned<Cow<'t, str>> {
    Spanned::new(span, Cow::Owned(name.to_owned()))
}

fn into_table<'t>(
    table: &mut DeTable<'t>,
    parts: &[KeyPart],
    value: Spanned<DeValue<'t>>,
    path: &str,
) -> Result<(), String> {
    let Some((KeyPart::Key(name), rest)) = parts.split_first() else {
        return Err(EXAMPLE.to_owned());
    };
    let path = match path {
        "" => name.clone(),
        _ => format!("{path}.{name}"),
    };
    if rest.is_empty() {
        table.insert(key(name, value.span()), value);
        return Ok(());
    }
    if table.get(name.as_str()).is_none() {
        if ["source", "detector", "path"].contains(&path.as_str()) {
            return Err(format!("the scene has no [[{path}]]"));
        }
        let empty = Spanned::new(value.span(), DeValue::Table(DeTable::new()));
        table.insert(key(name, value.span()), empty);
    }
    match table.get_mut(name.as_str()) {
        Some(found) => into_value(found.get_mut(), rest, value, &path),
        None => Err(format!("there is no `{path}`")),
    }
}

fn into_value<'t>(
    found: &mut DeValue<'t>,
    parts: &[KeyPart],
    value: Spanned<DeValue<'t>>,
    path: &str,
) -> Result<(), String> {
    match (found, parts) {
        (DeValue::Table(table), [KeyPart::Key(_), ..]) => into_table(table, parts, value, path),
        (DeValue::Array(array), [KeyPart::Key(_), ..]) => {
            let only = only(array, path)?;
            into_value((**array)[only].get_mut(), parts, value, path)
        }
        (DeValue::Array(array), [which, rest @ ..]) => {
            let index = index_of(array, which, path)?;
            if rest.is_empty() {
                (**array)[index] = value;
                return Ok(());
            }
            let path = format!("{path}[{index}]");
            into_value((**array)[index].get_mut(), rest, value, &path)
        }
        (DeValue::Table(_), _) => Err(format!("`{path}` is one table, and has no number")),
        _ => Err(format!("`{path}` is a value, and has no keys below it")),
    }
}

/// The only table of an array, whose number may be left out.
pub(super) fn only(array: &[Spanned<DeValue>], path: &str) -> Result<usize, String> {
    match array.len() {
        1 => Ok(0),
        count => Err(format!(
            "the scene has {count} [[{path}]]; write which one is meant, {path}[0] to {path}[{}]{}",
            count.saturating_sub(1),
            by_name(array, path)
        )),
    }
}

/// The names of the tables of an array.
fn names<'a>(array: &'a [Spanned<DeValue>]) -> Vec<&'a str> {
    let tables = array.iter().filter_map(|value| value.get_ref().as_table());
    tables.filter_map(|table| table.get("name")?.get_ref().as_str()).collect()
}

fn by_name(array: &[Spanned<DeValue>], path: &str) -> String {
    match names(array).first() {
        Some(name) => format!(", or by its name, {path}[{name}]"),
        None => String::new(),
    }
}

pub(super) fn index_of(
    array: &[Spanned<DeValue>],
    which: &KeyPart,
    path: &str,
) -> Result<usize, String> {
    let found = match which {
        KeyPart::Index(index) => Some(*index).filter(|&index| index < array.len()),
        KeyPart::Name(wanted) => array.iter().position(|value| {
            let table = value.get_ref().as_table();
            let name = table.and_then(|table| table.get("name")?.get_ref().as_str());
            name == Some(wanted)
        }),
        KeyPart::Key(_) => None,
    };
    found.ok_or_else(|| match (which, names(array).as_slice()) {
        (KeyPart::Name(wanted), []) => {
            format!("`{path}` has no names; write its number, {path}[0], not \"{wanted}\"")
        }
        (KeyPart::Name(wanted), names) => {
            format!("no `{path}` is named \"{wanted}\"; there is {}", alternatives(&quoted(names)))
        }
        (_, _) => format!(
            "`{path}` has {} of them, numbered from 0; write {path}[0]{}",
            array.len(),
            by_name(array, path)
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{parse, parse_with};
    use super::*;

    const TWO: &str = include_str!("../../../scenes/dual-view.toml");

    fn set(text: &str, settings: &[&str]) -> Result<crate::scene::Scene, String> {
        let settings: Result<Vec<Setting>, String> =
            settings.iter().map(|setting| setting.parse()).collect();
        parse_with("two.toml", text, &settings?).map_err(|error| error.to_string())
    }

    #[test]
    fn a_setting_is_as_if_the_file_had_it() {
        for (setting, from, to) in [
            ("clock.chip_period=4 ns", "\"8 ns\"", "\"4 ns\""),
            ("clock.chip_period=\"4 ns\"", "\"8 ns\"", "\"4 ns\""),
            (
                "source[1].mean_power=1 pW",
                "index = 2, interleave = 0 }\nwavelength = \"783 nm\"\nmean_power = \"4 pW\"",
                "index = 2, interleave = 0 }\nwavelength = \"783 nm\"\nmean_power = \"1 pW\"",
            ),
            ("source[other].code.index=5", "index = 2", "index = 5"),
            ("path[0].distance=4 m", "\"3.2 m\"                    # one", "\"4 m\" # one"),
            ("detector.jitter[1]=9 ps", "\"4 ps\"]", "\"9 ps\"]"),
            ("detector.afterpulsing.probability=0.2", "0.137", "0.2"),
            ("estimate.estimator=model", "estimator = \"fft\"", "estimator = \"model\""),
            ("hardware.peak_detector=true", "parallel = 1 ", "parallel = 1\npeak_detector = true "),
            (
                "source[\"laser\"].extinction_ratio=inf",
                "extinction_ratio = 10 ",
                "extinction_ratio = \"inf\" ",
            ),
        ] {
            assert!(TWO.contains(from), "{from}");
            let expected = parse("two.toml", &TWO.replacen(from, to, 1)).unwrap();
            let mut found = set(TWO, &[setting]).unwrap();
            assert_eq!(found.origin.settings, [setting]);
            // Where it comes from is the one thing that differs.
            found.origin = expected.origin.clone();
            assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{setting}");
        }
        let without = TWO.split("[estimate]").next().unwrap();
        let found = set(without, &["estimate.estimator=model"]).unwrap();
        assert_eq!(found.estimator, crate::scene::EstimatorKind::Model);
    }

    #[test]
    fn a_mistake_is_told_of_the_setting_and_not_of_a_line() {
        for (setting, told) in [
            ("clock.chip_period=4", "--set clock.chip_period=4: clock.chip_period: 4 has no unit"),
            ("clock.chip_perod=4 ns", "has no key `chip_perod`; did you mean `chip_period`?"),
            ("clok.chip_period=4 ns", "a scene has no key `clok`; did you mean `clock`?"),
            (
                "path.distance=4 m",
                "the scene has 2 [[path]]; write which one is meant, path[0] to path[1]",
            ),
            ("source.mean_power=4 pW", "or by its name, source[laser]"),
            (
                "source[lazer].mean_power=4 pW",
                "no `source` is named \"lazer\"; there is \"laser\" or \"other\"",
            ),
            ("path[2].distance=4 m", "`path` has 2 of them, numbered from 0"),
            ("path[x].distance=4 m", "`path` has no names; write its number"),
            ("clock[0].chip_period=4 ns", "`clock` is one table"),
            ("clock.chip_period.unit=ns", "`clock.chip_period` is a value"),
            ("clock.chip_period", "there is no \"=\""),
            ("=4 ns", "is not a key"),
            ("clock..x=4 ns", "is not a key"),
            ("source[0.x=4 ns", "there is no \"=\""),
            ("clock.chip_period=\u{1b}[2J", "\\u{1b}"),
            // Thirty thousand parts would be as many calls within each other.
            (&format!("a{}=1", ".a".repeat(30_000)), "a key of more than 16 parts"),
            (&format!("a{}=1", "[0]".repeat(30_000)), "a key of more than 16 parts"),
            (&format!("clock.chip_period={}", "[".repeat(30_000)), "clock.chip_period"),
        ] {
            let error = set(TWO, &[setting]).expect_err(setting);
            assert!(error.contains(told), "{setting}: {error}");
            assert!(!error.contains("two.toml"), "{setting}: {error}");
        }
    }

    #[test]
    fn the_last_of_two_settings_holds_and_the_file_keeps_its_lines() {
        let scene = set(TWO, &["clock.chip_period=4 ns", "clock.chip_period=2 ns"]).unwrap();
        assert_eq!(scene.chip_period_ps, 2000.0);
        let broken = TWO.replace("\"104.8 us\"", "104.8");
        let error = set(&broken, &["clock.chip_period=4 ns"]).expect_err("no unit");
        assert!(error.starts_with("two.toml:50:15: scan.integration"), "{error}");
    }
}

//! What a scene has at a key, in SI units.

use toml::Value;
use toml::de::{DeTable, DeValue};

use super::catalogue::TABLES;
use super::keys::{Form, Key, KeyKind};
use super::setting::{self, KeyPart, Setting, with_settings};
use super::units::{self, Quantity};
use super::wording::{alternatives, nearest, quoted};

/// What a scene has at a key.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its value, or the default that holds: quantities as numbers in SI units, "inf" as a number.
    /// None where the key is left out, and other keys decide.
    pub value: Option<Value>,
    /// The SI unit of a quantity, as UDUNITS writes it: "m s-1", "1" of a ratio.
    pub unit: Option<&'static str>,
    /// What the key means.
    pub meaning: &'static str,
}

impl Entry {
    /// Looks up `key` as a [`Setting`] has it, in the text of a valid scene with its settings.
    ///
    /// # Errors
    /// If it is not one of a scene's keys, or is of a table that the scene does not have.
    pub fn of(text: &str, settings: &[Setting], key: &str) -> Result<Entry, String> {
        let (parts, declared) = find(key)?;
        let lines: Vec<String> = settings.iter().map(Setting::line).collect();
        let mut document = DeTable::parse(text).map_err(|error| error.message().to_owned())?;
        let settings = settings.iter().zip(lines.iter().map(String::as_str));
        with_settings(&mut document, settings, |_, _| ());
        let root = DeValue::Table(document.into_inner());
        let value = match written(&root, &parts, "")? {
            Some(value) => Some(in_si(value, declared)),
            // The default of a table that is left out itself is not a value.
            None if parts.len() == 2
                || written(&root, &parts[..parts.len() - 1], "")?.is_some() =>
            {
                default(declared)
            }
            None => None,
        };
        let unit = quantity_of(declared).map(Quantity::si_unit);
        Ok(Entry { value, unit, meaning: declared.meaning })
    }
}

/// A number in SI units as a scene has it at `key`, 4e-12 as "4 pW"; none where the key takes no
/// quantity.
///
/// # Errors
/// If it is not one of a scene's keys.
pub fn quantity_text(key: &str, value: f64) -> Result<Option<String>, String> {
    let (_, declared) = find(key)?;
    Ok(quantity_of(declared).map(|quantity| units::in_scene(value, quantity)))
}

fn quantity_of(key: &Key) -> Option<Quantity> {
    match key.kind {
        KeyKind::Quantity { quantity, .. } => Some(quantity),
        _ => None,
    }
}

/// The parts of a key, and what is declared of it.
fn find(key: &str) -> Result<(Vec<KeyPart>, &'static Key), String> {
    let parts = setting::parts(key)?;
    let names: Vec<&str> = parts.iter().filter_map(KeyPart::name).collect();
    let (name, tables) = names.split_last().ok_or("a key is needed")?;
    let path = tables.join(".");
    let Some(table) = TABLES.iter().find(|table| table.path == path) else {
        let known: Vec<&str> = TABLES.iter().map(|table| table.path).collect();
        let meant = nearest(&path, &known).map(|meant| format!("; did you mean `{meant}`?"));
        return Err(format!("a scene has no table `{path}`{}", meant.unwrap_or_default()));
    };
    match table.keys().find(|key| key.name == *name) {
        Some(declared) => Ok((parts, declared)),
        None => {
            let known: Vec<&str> = table.keys().map(|key| key.name).collect();
            let told = match nearest(name, &known) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("it has {}", alternatives(&quoted(&known))),
            };
            Err(format!("`{path}` has no key `{name}`; {told}"))
        }
    }
}

/// What is written at a key: none where it, or a table on the way, is left out.
fn written<'v, 't>(
    value: &'v DeValue<'t>,
    parts: &[KeyPart],
    path: &str,
) -> Result<Option<&'v DeValue<'t>>, String> {
    let Some((part, rest)) = parts.split_first() else { return Ok(Some(value)) };
    match (value, part) {
        (DeValue::Table(table), KeyPart::Key(name)) => {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            match table.get(name.as_str()) {
                Some(found) => written(found.get_ref(), rest, &path),
                None => Ok(None),
            }
        }
        (DeValue::Array(array), KeyPart::Key(_)) => {
            let only = setting::only(array, path)?;
            written(array[only].get_ref(), parts, path)
        }
        (DeValue::Array(array), which) => {
            let index = setting::index_of(array, which, path)?;
            written(array[index].get_ref(), rest, &format!("{path}[{index}]"))
        }
        _ => Ok(None),
    }
}

/// A value of the file, quantities in SI units.
fn in_si(value: &DeValue, key: &Key) -> Value {
    let within = |values: &[toml::Spanned<DeValue>]| {
        Value::Array(values.iter().map(|value| in_si(value.get_ref(), key)).collect())
    };
    match (value, &key.kind) {
        (DeValue::Array(values), _) => within(values),
        (DeValue::String(text), kind) => of_text(text, key, kind),
        (DeValue::Integer(digits), KeyKind::Number { .. }) => number(digits.as_str()),
        (DeValue::Integer(digits), _) => i64::from_str_radix(digits.as_str(), digits.radix())
            .map_or(number("nan"), Value::Integer),
        (DeValue::Float(digits), _) => number(digits.as_str()),
        (DeValue::Boolean(value), _) => Value::Boolean(*value),
        (DeValue::Datetime(value), _) => Value::String(value.to_string()),
        (DeValue::Table(table), _) => {
            let fields = table.iter().map(|(name, value)| {
                let plain = Key { kind: KeyKind::Words("", Form::Text), ..*key };
                (name.get_ref().to_string(), in_si(value.get_ref(), &plain))
            });
            Value::Table(fields.collect())
        }
    }
}

fn number(digits: &str) -> Value {
    Value::Float(digits.parse().unwrap_or(f64::NAN))
}

fn of_text(text: &str, key: &Key, kind: &KeyKind) -> Value {
    match kind {
        KeyKind::Quantity { quantity, .. } => {
            let value = units::in_si(text, *quantity, key.example);
            value.map_or_else(|_| Value::String(text.to_owned()), Value::Float)
        }
        KeyKind::Number { or_inf: true, .. } if text == "inf" => Value::Float(f64::INFINITY),
        _ => Value::String(text.to_owned()),
    }
}

/// The value that holds where a key is left out.
fn default(key: &Key) -> Option<Value> {
    let text = key.default()?;
    let value = match key.kind {
        KeyKind::Quantity { .. } | KeyKind::Number { or_inf: true, .. }
            if text.starts_with("inf") =>
        {
            Value::Float(f64::INFINITY)
        }
        KeyKind::Number { .. } => number(text),
        KeyKind::Integer { .. } => Value::Integer(text.parse().ok()?),
        KeyKind::Words(_, Form::Boolean) => Value::Boolean(text.parse().ok()?),
        _ => of_text(text, key, &key.kind),
    };
    match value {
        // What is said of it in words.
        Value::String(_) if quantity_of(key).is_some() => None,
        value => Some(value),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{parse, parse_with};
    use super::*;

    const TWO: &str = include_str!("../../../scenes/dual-view.toml");

    fn value(settings: &[&str], key: &str) -> Result<Option<Value>, String> {
        let settings: Vec<Setting> = settings.iter().map(|s| s.parse().unwrap()).collect();
        Entry::of(TWO, &settings, key).map(|entry| entry.value)
    }

    #[test]
    fn quantities_are_in_si_units_and_defaults_filled_in() {
        for (settings, key, told) in [
            (&[][..], "clock.chip_period", Value::Float(8e-9)),
            (&["clock.chip_period=4.5 ns"], "clock.chip_period", Value::Float(4.5e-9)),
            (&[], "source[other].mean_power", Value::Float(4e-12)),
            (&["source[1].mean_power=-70 dBm"], "source[1].mean_power", Value::Float(1e-10)),
            (&["source[0].clock_offset=20 ppm"], "source[0].clock_offset", Value::Float(20e-6)),
            (
                &["source[0].extinction_ratio=inf"],
                "source[0].extinction_ratio",
                f64::INFINITY.into(),
            ),
            (&[], "source[0].extinction_ratio", Value::Float(10.0)),
            (&[], "source[0].rise_time", Value::Float(0.0)),
            (&[], "source[0].code.degree", Value::Integer(11)),
            (&[], "source[0].name", Value::String("laser".to_owned())),
            (&[], "detector.jitter", Value::Array(vec![53.5e-12.into(), 4e-12.into()])),
            (&[], "detector.jitter[1]", Value::Float(4e-12)),
            (&[], "detector.afterpulsing.probability", Value::Float(0.137)),
            (&[], "hardware.parallel", Value::Integer(1)),
        ] {
            assert_eq!(value(settings, key), Ok(Some(told)), "{key}");
        }
        assert_eq!(value(&[], "source[0].impulse_response"), Ok(None));
        assert_eq!(value(&[], "path[0].link.reflectance"), Ok(None));
    }

    #[test]
    fn a_key_that_is_none_is_told_as_of_a_setting() {
        for (key, told) in [
            ("clock.chip_perod", "`clock` has no key `chip_perod`; did you mean `chip_period`?"),
            ("clok.chip_period", "a scene has no table `clok`; did you mean `clock`?"),
            ("path.distance", "the scene has 2 [[path]]; write which one is meant"),
            ("source[lazer].mean_power", "no `source` is named \"lazer\""),
            ("clock", "a scene has no table ``"),
            ("=4", "is not a key"),
        ] {
            let error = value(&[], key).expect_err(key);
            assert!(error.contains(told), "{key}: {error}");
        }
    }

    /// Every quantity that a scene may have, as a number in SI units and set by it: the same scene.
    #[test]
    fn a_number_in_si_units_is_read_as_it_was_told() {
        for key in ["clock.chip_period", "path[0].distance", "source[0].mean_power"] {
            let Ok(Some(Value::Float(number))) = value(&[], key) else { panic!("{key}") };
            let text = quantity_text(key, number).unwrap().expect("a quantity");
            let setting = Setting::of(key, &text, "--set").unwrap();
            let mut set = parse_with("two.toml", TWO, &[setting]).unwrap();
            let as_it_was = parse("two.toml", TWO).unwrap();
            set.origin = as_it_was.origin.clone();
            assert_eq!(format!("{set:?}"), format!("{as_it_was:?}"), "{key} = {text}");
        }
        let text = |key, number| quantity_text(key, number).unwrap();
        for (key, number, told) in [
            ("source.clock_offset", 2e-5, "20 ppm"),
            ("source.clock_offset", -2.5e-12, "-0.0025 ppb"),
            ("source.mean_power", 4e-12, "4 pW"),
            ("source.mean_power", 0.0, "0 W"),
            ("clock.chip_period", 0.1 + 0.2, "300.00000000000004 ms"),
            ("detector.dark_count_rate", 71e3, "71 kcps"),
            ("detector.dark_count_rate", 1e-9, "1e-9 cps"),
            ("path.distance", 5.0, "5 m"),
            ("path.distance", 0.05, "50 mm"),
            ("path.distance", 1.5e9, "1500000 km"),
        ] {
            assert_eq!(text(key, number).as_deref(), Some(told));
        }
        assert_eq!(text("clock.samples_per_chip", 4.0), None);
    }
}

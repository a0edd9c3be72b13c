//! `--over KEY=VALUES`: the values that a key takes in turn.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::scene::Setting;

/// Most values of an axis.
const MOST_VALUES: u32 = 100_000;

/// A key, and the values that it takes in turn. In JSON it is its text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(into = "String", try_from = "String")]
#[schemars(with = "String", rename = "Axis")]
pub struct SweepAxis {
    /// As it was written, `source[0].mean_power=1 pW..64 pW x7`.
    pub text: String,
    /// The key, `source[0].mean_power`.
    pub key: String,
    /// The values, in the order in which they are taken.
    pub values: Vec<AxisValue>,
    /// Whether they are spaced by ratio.
    pub by_ratio: bool,
}

/// One value of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisValue {
    /// As a setting has it, `1 pW`.
    pub text: String,
    /// Its number, if it is one with or without a unit.
    pub number: Option<f64>,
    /// Its unit; empty of a plain number.
    pub unit: String,
}

const FORMS: &str = "write a list, \"1 pW, 4 pW, 16 pW\", values spaced evenly by ratio, \
                     \"1 pW..64 pW x7\", or by difference, \"1 m..10 m +10\"";

impl From<SweepAxis> for String {
    fn from(axis: SweepAxis) -> String {
        axis.text
    }
}

impl TryFrom<String> for SweepAxis {
    type Error = String;

    fn try_from(text: String) -> Result<SweepAxis, String> {
        text.parse()
    }
}

impl FromStr for SweepAxis {
    type Err = String;

    fn from_str(text: &str) -> Result<SweepAxis, String> {
        let (key, values) =
            Setting::split(text).map_err(|problem| format!("{problem}; {FORMS}"))?;
        // Whether it is a key at all.
        Setting::of(key, "0", "--over")?;
        let (values, by_ratio) = match values.split_once("..") {
            Some((from, rest)) => range(from, rest)?,
            None => (list(values)?, false),
        };
        Ok(SweepAxis { text: text.trim().to_owned(), key: key.to_owned(), values, by_ratio })
    }
}

impl SweepAxis {
    /// The unit of all values, if all are numbers of one unit.
    pub fn unit(&self) -> Option<&str> {
        let first = self.values.first()?;
        let is_alike = |value: &AxisValue| value.number.is_some() && value.unit == first.unit;
        self.values.iter().all(is_alike).then_some(&first.unit)
    }

    /// Name of its column: the key, and the unit where there is one.
    pub fn column(&self) -> String {
        match self.unit() {
            Some("") | None => self.key.clone(),
            Some(unit) => format!("{} ({unit})", self.key),
        }
    }
}

impl AxisValue {
    fn of(text: &str) -> AxisValue {
        let text = text.trim();
        let end = text
            .find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E')
            .unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let number: Option<f64> = number.trim().parse().ok().filter(|n: &f64| n.is_finite());
        AxisValue {
            text: text.to_owned(),
            unit: number.map_or_else(String::new, |_| unit.trim().to_owned()),
            number,
        }
    }

    fn with_unit(number: f64, unit: &str) -> AxisValue {
        // Twelve digits are more than anyone means, and hide what rounding adds.
        let rounded: f64 = format!("{number:.11e}").parse().unwrap_or(number);
        let text = match unit {
            "" => rounded.to_string(),
            _ => format!("{rounded} {unit}"),
        };
        AxisValue { text, number: Some(rounded), unit: unit.to_owned() }
    }
}

/// `FROM..TO xN` or `FROM..TO +N`.
fn range(from: &str, rest: &str) -> Result<(Vec<AxisValue>, bool), String> {
    let Some((to, how)) = rest.trim().rsplit_once(char::is_whitespace) else {
        return Err(format!("\"{}\" does not say how many; {FORMS}", rest.trim()));
    };
    let by_ratio = how.starts_with('x');
    let count = how.strip_prefix(['x', '+']).and_then(|n| n.parse().ok());
    let count: u32 = count.filter(|count| (2..=MOST_VALUES).contains(count)).ok_or_else(|| {
        format!("\"{how}\" is not a number of values from 2 to {MOST_VALUES}; {FORMS}")
    })?;
    let ends = [from, to].map(AxisValue::of);
    let [Some(first), Some(last)] = [ends[0].number, ends[1].number] else {
        return Err(format!("\"{from}..{to}\" has no two numbers; {FORMS}"));
    };
    if ends[0].unit != ends[1].unit {
        return Err(format!(
            "\"{}\" and \"{}\" have two units; write both ends in one",
            ends[0].text, ends[1].text
        ));
    }
    if by_ratio && (first <= 0.0 || last <= 0.0) {
        return Err(format!(
            "values spaced by ratio are above zero, \"{}..{}\" is not; write +{count} for even \
             differences",
            ends[0].text, ends[1].text
        ));
    }
    let value = |i: u32| {
        let share = f64::from(i) / f64::from(count - 1);
        match (i, by_ratio) {
            (0, _) => first,
            (i, _) if i == count - 1 => last,
            (_, true) => first * (last / first).powf(share),
            (_, false) => first + share * (last - first),
        }
    };
    let values = (0..count).map(|i| AxisValue::with_unit(value(i), &ends[0].unit));
    Ok((values.collect(), by_ratio))
}

/// The values of a list; commas within brackets and quotation marks divide nothing.
fn list(text: &str) -> Result<Vec<AxisValue>, String> {
    let (mut parts, mut depth, mut is_quoted) = (vec![String::new()], 0, false);
    for character in text.chars() {
        match character {
            '"' => is_quoted = !is_quoted,
            '[' | '{' if !is_quoted => depth += 1,
            ']' | '}' if !is_quoted => depth -= 1,
            ',' if depth == 0 && !is_quoted => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(last) = parts.last_mut() {
            last.push(character);
        }
    }
    let values: Vec<AxisValue> = parts.iter().map(|part| AxisValue::of(part)).collect();
    if values.iter().any(|value| value.text.is_empty()) {
        return Err(format!("a value is missing in \"{text}\"; {FORMS}"));
    }
    let twice = (1..values.len()).find(|&i| values[..i].contains(&values[i]));
    match twice {
        Some(i) => Err(format!("\"{}\" stands twice in the list", values[i].text)),
        None => Ok(values),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &str) -> Vec<String> {
        let axis: SweepAxis = axis.parse().unwrap();
        axis.values.into_iter().map(|value| value.text).collect()
    }

    #[test]
    fn values_are_spaced_as_they_say() {
        assert_eq!(
            texts("source[0].mean_power=1 pW..64 pW x4"),
            ["1 pW", "4 pW", "16 pW", "64 pW"]
        );
        assert_eq!(texts("path.distance = 1 m..2 m +3"), ["1 m", "1.5 m", "2 m"]);
        assert_eq!(texts("hardware.parallel=1..8 x4"), ["1", "2", "4", "8"]);
        assert_eq!(texts("path.distance=2m..1m +2"), ["2 m", "1 m"]);
        assert_eq!(texts("source.mean_power=-65 dBm..-50 dBm +4")[1], "-60 dBm");
        assert_eq!(texts("a.b=1e-3 m..1e-1 m x3"), ["0.001 m", "0.01 m", "0.1 m"]);
        assert_eq!(texts("estimate.estimator=fft, model"), ["fft", "model"]);
        assert_eq!(
            texts("source.code={ family = \"gold\", degree = 5 }, { family = \"square\" }").len(),
            2
        );
        assert_eq!(texts("source[la=ser].mean_power=3 pW"), ["3 pW"]);
        let jitters = "detector.jitter=[\"5 ps\"], [\"5 ps\", \"9 ps\"]";
        assert_eq!(texts(jitters), ["[\"5 ps\"]", "[\"5 ps\", \"9 ps\"]"]);
    }

    #[test]
    fn columns_have_units_where_all_values_have_one() {
        let column = |axis: &str| axis.parse::<SweepAxis>().unwrap().column();
        assert_eq!(column("a.b=1 pW, 3 pW"), "a.b (pW)");
        assert_eq!(column("a.b=1 pW, 3 nW"), "a.b");
        assert_eq!(column("a.b=1..3 +3"), "a.b");
        assert_eq!(column("a.b=fft, model"), "a.b");
    }

    #[test]
    fn mistakes_are_told_with_what_would_be_right() {
        for (axis, told) in [
            ("path.distance", "there is no \"=\""),
            ("=1 m..2 m +3", "is not a key"),
            ("a.b=1 m..2 m", "is not a number of values"),
            ("a.b=1 m..2", "does not say how many"),
            ("a.b=1 m..2 m x1", "from 2 to 100000"),
            ("a.b=1 m..2 m x99999999999", "from 2 to 100000"),
            ("a.b=1 m..2 km +3", "have two units"),
            ("a.b=0 W..1 W x3", "write +3 for even differences"),
            ("a.b=x..y +3", "has no two numbers"),
            ("a.b=1, ,2", "a value is missing"),
            ("a.b=", "a value is missing"),
            ("a.b=1,2,1", "\"1\" stands twice"),
        ] {
            let error = axis.parse::<SweepAxis>().expect_err(axis);
            assert!(error.contains(told), "{axis}: {error}");
        }
    }
}

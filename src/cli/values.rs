//! Values of options that have a form of their own.

use std::time::Duration;

use crate::shard::Part;

/// Longest time that can be asked for: 1000 days.
const MOST_SECONDS: f64 = 1000.0 * 86_400.0;

/// Reads a time with its unit: "90s", "10min" or "2h".
pub(super) fn parse_time(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit_s = match &text[digits.len()..] {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => {
            return Err("write a number with its unit, as \"90 s\", \"10min\" or \"2h\"".to_owned());
        }
    };
    let seconds = digits.trim().parse::<f64>().map_or(f64::NAN, |n| n * unit_s);
    // Neither is one that is not a number.
    if (1e-3..=MOST_SECONDS).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!("write a time from 0.001 s to {} h", MOST_SECONDS / 3600.0))
    }
}

/// `--shard`, which may ask for the number of the present task.
pub(super) fn parse_shard(text: &str) -> Result<Part, String> {
    Part::parse(text, |name| std::env::var(name).ok())
}

#[cfg(test)]
mod tests {
    use super::parse_time;

    #[test]
    fn a_time_has_its_unit_and_its_bounds() {
        let time = |text| parse_time(text).map(|time| time.as_secs_f64());
        assert_eq!(time("10min"), Ok(600.0));
        assert_eq!(time(" 1.5 h "), Ok(5400.0));
        assert_eq!(time("0.25s"), Ok(0.25));
        for text in ["", "10", "s", "-1 s", "0 s", "1e99 h", "nan s", "inf s", "1 d", "1 \u{b5}s"] {
            assert!(time(text).is_err(), "{text}");
        }
    }
}

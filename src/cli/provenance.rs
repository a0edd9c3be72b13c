//! Version, command and date of a report.

use std::path::Path;
use std::time::SystemTime;

use anyhow::Context as _;
use chrono::{DateTime, SecondsFormat};

use crate::printable::{printable_path, shell_word};
use crate::report::provenance::Provenance;
use crate::version::VERSION;

/// The latest date that can be written: the year 9999.
const MOST_SECONDS: u64 = 253_402_300_799;

/// Of this run. `SOURCE_DATE_EPOCH`, seconds since 1970, stands in for the time of day
/// where it is set, as reproducible builds have it.
///
/// # Errors
/// When `SOURCE_DATE_EPOCH` is not a number of seconds, or beyond the year 9999.
pub(super) fn provenance(scene_text: String) -> anyhow::Result<Provenance> {
    let told = match std::env::var_os("SOURCE_DATE_EPOCH") {
        None => None,
        Some(text) => {
            let number = text.to_str().and_then(|text| text.parse::<u64>().ok());
            let number = number.filter(|&seconds| seconds <= MOST_SECONDS);
            Some(number.with_context(|| {
                let shown = printable_path(Path::new(&text));
                format!("SOURCE_DATE_EPOCH is {shown:?}; write seconds since 1970, as 1767225600")
            })?)
        }
    };
    let now = || SystemTime::UNIX_EPOCH.elapsed().map_or(0, |time| time.as_secs());
    Ok(Provenance {
        version: format!("goldtof {VERSION}"),
        command: typed_command(),
        date: rfc3339(told.unwrap_or_else(now)),
        reproducible: told.is_some(),
        scene_text,
    })
}

/// Seconds since 1970, no more than [`MOST_SECONDS`], as a date and a time of day in UTC (RFC 3339).
fn rfc3339(seconds: u64) -> String {
    let date = DateTime::from_timestamp(seconds as i64, 0).unwrap_or_default();
    date.to_rfc3339_opts(SecondsFormat::Secs, true)
}

/// The command as it was typed; words that a shell would take apart are in quotation marks.
pub(super) fn typed_command() -> String {
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| shell_word(&printable_path(Path::new(&word))).into_owned());
    let all = std::iter::once("goldtof".to_owned()).chain(words);
    all.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    /// As `date --utc --date=@SECONDS` of GNU coreutils has them: ends of days round leap days, of
    /// 2000, which is a leap year, and of 2100, which is none.
    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951782399, "2000-02-28T23:59:59Z"),
            (951782400, "2000-02-29T00:00:00Z"),
            (1767225600, "2026-01-01T00:00:00Z"),
            (4107542399, "2100-02-28T23:59:59Z"),
            (4107542400, "2100-03-01T00:00:00Z"),
            (13574649599, "2400-02-29T23:59:59Z"),
            (253402300799, "9999-12-31T23:59:59Z"),
            (1709164800, "2024-02-29T00:00:00Z"),
        ] {
            assert_eq!(super::rfc3339(seconds), date);
        }
    }
}

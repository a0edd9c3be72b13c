//! Version, command and date of a report.

use std::path::Path;
use std::time::{Duration, SystemTime};

use anyhow::Context as _;

use crate::printable::{printable_path, shell_word};
use crate::report::provenance::Provenance;
use crate::version::VERSION;

/// The latest date that can be written: the year 9999.
const MOST_SECONDS: u64 = 253_402_300_799;

/// Of this run. `SOURCE_DATE_EPOCH`, seconds since 1970, stands in for the time of day
/// where it is set, as reproducible builds have it.
///
/// # Errors
/// When `SOURCE_DATE_EPOCH` is no such number.
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
    let time = match told {
        Some(seconds) => SystemTime::UNIX_EPOCH + Duration::from_secs(seconds),
        None => SystemTime::now(),
    };
    Ok(Provenance {
        version: format!("goldtof {VERSION}"),
        command: typed_command(),
        date: humantime::format_rfc3339_seconds(time).to_string(),
        reproducible: told.is_some(),
        scene_text,
    })
}

/// The command as it was typed; words that a shell would take apart are in quotation marks.
pub(super) fn typed_command() -> String {
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| shell_word(&printable_path(Path::new(&word))).into_owned());
    let all = std::iter::once("goldtof".to_owned()).chain(words);
    all.collect::<Vec<_>>().join(" ")
}

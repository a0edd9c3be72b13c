//! Where a report comes from.

use maud::{Markup, html};

use super::tables::values;
use crate::printable::{printable, printable_lines};

/// Where a report comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    /// Version of goldtof, with its commit where that is known.
    pub version: String,
    /// The command as it was typed.
    pub command: String,
    /// When, in UTC.
    pub date: String,
    /// Whether the report is to be the same, byte for byte, when it is made again
    /// (`SOURCE_DATE_EPOCH`): nothing that a clock on the wall says is in it then.
    pub reproducible: bool,
    /// The scene file.
    pub scene_text: String,
}

impl Provenance {
    pub(super) fn section(&self, seed: u64) -> Markup {
        let row = |name: &str, value: &str| vec![name.to_owned(), printable(value).into_owned()];
        let rows = [
            row("made by", &self.version),
            row("command", &self.command),
            row("date", &self.date),
            row("seed", &seed.to_string()),
        ];
        html! {
            (values(&rows))
            details {
                summary { "The scene file" }
                pre { (printable_lines(&self.scene_text)) }
            }
        }
    }
}

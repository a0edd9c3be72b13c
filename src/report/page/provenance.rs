//! Where a report comes from, in a table.

use maud::{Markup, html};

use super::tables::values;
use crate::printable::{printable, printable_lines};
use crate::report::provenance::Provenance;

pub(super) fn section(provenance: &Provenance, seed: u64) -> Markup {
    let row = |name: &str, value: &str| vec![name.to_owned(), printable(value).into_owned()];
    let rows = [
        row("made by", &provenance.version),
        row("command", &provenance.command),
        row("date", &provenance.date),
        row("seed", &seed.to_string()),
    ];
    html! {
        (values(&rows))
        details {
            summary { "The scene file" }
            pre { (printable_lines(&provenance.scene_text)) }
        }
    }
}

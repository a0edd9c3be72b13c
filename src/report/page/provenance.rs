//! Where a report comes from, in a table.

use maud::{Markup, html};

use super::tables::values;
use crate::printable::{printable, printable_lines};
use crate::report::plan::row;
use crate::report::provenance::Provenance;

pub(super) fn section(provenance: &Provenance, seed: u64) -> Markup {
    let rows = [
        row("made by", printable(&provenance.version)),
        row("command", printable(&provenance.command)),
        row("date", printable(&provenance.date)),
        row("seed", seed.to_string()),
    ];
    html! {
        (values(&rows))
        details {
            summary { "The scene file" }
            pre { (printable_lines(&provenance.scene_text)) }
        }
    }
}

//! What the check is worth: faults that the stimulus finds.

use maud::{Markup, html};

use super::tables::table;
use crate::grade::{Grade, Judged, Score, Verdict};
use crate::report::quantities::{number, percent};

/// Survivors of a kind that are shown.
const MOST_SHOWN: usize = 100;

pub(super) fn section(grade: &Grade) -> Markup {
    let kinds: Vec<(&str, &Score)> = [("stuck-at faults", &grade.faults)]
        .into_iter()
        .chain(grade.mutants.iter().map(|mutants| ("mutants", mutants)))
        .collect();
    let row = |&(name, score): &(&str, &Score)| {
        let counted =
            [score.total, score.caught, score.proven_equivalent, score.not_caught, score.undecided];
        let counted = counted.map(|count| number(count as u64));
        let caught = percent(score.caught_fraction);
        [vec![name.to_owned()], counted.to_vec(), vec![caught]].concat()
    };
    html! {
        p {
            "Faults put into this Verilog, each alone, under " (number(grade.clocks))
            " clocks of inputs chosen to hurt (seed " (grade.seed) "): those are caught that an output \
             shows. Equivalent ones change no output, whatever the inputs; the share is that of all others."
        }
        (table(
            &["kind", "number", "caught", "proven equivalent", "not caught", "undecided", "share caught"],
            &kinds.iter().map(row).collect::<Vec<_>>(),
        ))
        @for (name, score) in kinds {
            @if !score.survivors.is_empty() {
                details {
                    summary { "Not shown, of " (name) }
                    (table(
                        &["net", "change", "source", "known of it", "what would show it"],
                        &score.survivors.iter().take(MOST_SHOWN).map(cells).collect::<Vec<_>>(),
                    ))
                    @if score.survivors.len() > MOST_SHOWN {
                        p.soft { "And " (score.survivors.len() - MOST_SHOWN) " more." }
                    }
                }
            }
        }
    }
}

fn cells(survivor: &Judged) -> Vec<String> {
    let known = match survivor.verdict {
        Verdict::NotCaught => "inputs exist that show it",
        Verdict::Undecided => "undecided",
        Verdict::Caught => "caught",
        Verdict::ProvenEquivalent => "no inputs show it",
    };
    let texts = [&survivor.net, &survivor.change, &survivor.source, known, survivor.reason()];
    texts.map(str::to_owned).to_vec()
}

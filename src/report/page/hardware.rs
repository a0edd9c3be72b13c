//! The emitted design: resources, blocks, ports clock by clock.

use super::{Page, WAVES, id_of, table, values};
use crate::grade::{FaultVerdict, Grade, Judged, Score};
use crate::report::block_diagram::{Diagram, diagrams};
use crate::report::plan::{figures, resources};
use crate::report::prelude::*;

pub(super) fn section(page: &Page) -> Markup {
    let modules = &page.emission.netlists;
    let diagrams = diagrams(modules);
    let ports = page.emission.ports.iter().map(|port| {
        let direction = serde_json::to_value(port.direction).unwrap_or_default();
        let direction = direction.as_str().unwrap_or_default().to_owned();
        vec![port.name.clone(), direction, port.width.to_string()]
    });
    html! {
        div.figures {
            div { h3 { "In time and space" } (values(&figures(page.figures))) }
            div { h3 { "In an FPGA" } (values(&resources(page.resources))) }
        }
        h3 { "Blocks" }
        p.soft { (modules.len()) " modules; clock and reset, which go to each, are not drawn." }
        div.figures { @for diagram in &diagrams { (diagram.figure.markup()) } }
        details {
            summary { "The same in words" }
            @for diagram in &diagrams { (in_words(diagram)) }
        }
        h3 id=(id_of(WAVES)) { (WAVES) }
        p.soft { "Inputs are taken at the edge that ends a column; outputs change at the one that begins it." }
        div.figures {
            @for (number, wave) in page.waves.iter().enumerate() {
                (wave.figure(&format!("wave-{number}")).markup())
            }
        }
        details {
            summary { "Ports, and the diagrams as WaveJSON" }
            (table(&["port", "direction", "bits"], &ports.collect::<Vec<_>>()))
            @for wave in page.waves {
                pre { (serde_json::to_string(wave).unwrap_or_default()) }
            }
        }
    }
}

fn in_words(diagram: &Diagram) -> Markup {
    html! {
        h3 { (diagram.figure.title) }
        (table(
            &["from", "to", "nets"],
            &diagram.connections.iter().map(|row| row.to_vec()).collect::<Vec<_>>(),
        ))
    }
}

/// Survivors of a kind that are shown.
const MOST_SHOWN: usize = 100;

pub(super) fn strength(grade: &Grade) -> Markup {
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
        FaultVerdict::NotCaught => "inputs exist that show it",
        FaultVerdict::Undecided => "undecided",
        FaultVerdict::Caught => "caught",
        FaultVerdict::ProvenEquivalent => "no inputs show it",
    };
    let texts = [&survivor.net, &survivor.change, &survivor.source, known, survivor.reason()];
    texts.map(str::to_owned).to_vec()
}

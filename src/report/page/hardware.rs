//! The emitted design: resources, blocks, ports clock by clock.

use maud::{Markup, html};

use super::tables::{table, values};
use super::{Page, WAVES, id_of};
use crate::report::block_diagram::{Diagram, diagrams};
use crate::report::plan::{figures, resources};

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

//! Proofs that go with the emitted Verilog: properties in Verilog, and tasks for sby.

mod codes;
mod counts;
mod frames;
mod harness;
mod peak;
mod reference;
mod rules;
mod scan;
mod script;
mod stream;

use serde::Serialize;

use self::harness::Harness;

use super::design::{Design, EmittedFile};
use crate::rtl::back::BLOCK_MEMORY;

/// Files of the folder `formal`.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Formal {
    /// The properties, a module round the design for each proof.
    pub properties: EmittedFile,
    /// Modules of which a proof drives the outputs, or leaves them free: their ports.
    pub emptied: EmittedFile,
    /// For Yosys: registers that start as reset leaves them.
    pub registers: EmittedFile,
    /// The tasks of sby.
    pub script: EmittedFile,
    /// For an ABC that is not sby's own.
    pub abc: EmittedFile,
    /// Names of the proofs, which are the names of the tasks.
    pub proofs: Vec<&'static str>,
    /// Names of the tasks that look whether a proof's assertions can be reached.
    pub covers: Vec<String>,
}

impl Formal {
    /// The folder's name.
    pub const FOLDER: &'static str = script::FOLDER;

    /// The proofs of a design.
    pub(super) fn of(design: &Design) -> Formal {
        let interface = design.interface();
        let (codes, mut modules) = codes::harness(interface, design.prefix);
        let mut harnesses = vec![rules::reset(interface), codes];
        if let Some(plan) = &interface.histogram {
            // The words in its memories are beyond these proofs.
            harnesses.extend([frames::scan(interface, plan), frames::stream(interface, plan)]);
        } else {
            let (reference, of_reference) = reference::harness(interface, design.prefix);
            modules += &of_reference;
            harnesses.extend([
                scan::harness(interface),
                reference,
                counts::harness(interface),
                stream::harness(interface),
            ]);
        }
        harnesses.extend(interface.peak.iter().map(|plan| peak::harness(interface, plan)));
        harnesses.push(rules::axis(interface));
        if interface.histogram.is_some() {
            // Nor does reset reach a memory's registers.
            harnesses =
                harnesses.into_iter().map(|harness| harness.freeing(BLOCK_MEMORY)).collect();
        }
        Formal {
            properties: script::properties(design, &harnesses, &modules),
            emptied: script::emptied(design, &harnesses),
            registers: script::registers(design.made_by),
            script: script::script(design, &harnesses),
            abc: script::abc(design.made_by),
            proofs: harnesses.iter().map(|harness| harness.name).collect(),
            covers: harnesses.iter().filter_map(Harness::cover_task).collect(),
        }
    }

    /// Every file, in no order that matters.
    pub fn files(&self) -> impl Iterator<Item = &EmittedFile> {
        [&self.properties, &self.emptied, &self.registers, &self.script, &self.abc].into_iter()
    }
}

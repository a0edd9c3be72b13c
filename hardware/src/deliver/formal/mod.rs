//! Proofs that go with the emitted Verilog. What is to hold stands in the SystemVerilog files of
//! this folder; here are this design's numbers (`numbers`), where in it the proofs look
//! (`proofs`), and the tasks of sby ([`script`]).

mod numbers;
mod proofs;
mod script;

use serde::Serialize;

use self::proofs::{Proof, proofs};
use super::design::{EmittedDesign, EmittedFile};

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
    pub(super) fn of(design: &EmittedDesign) -> Formal {
        let proofs = proofs(design);
        Formal {
            properties: script::properties(design),
            emptied: script::emptied(design, &proofs),
            registers: script::registers(design.made_by),
            script: script::script(design, &proofs),
            abc: script::abc(design.made_by),
            covers: proofs.iter().filter_map(Proof::cover_task).collect(),
            proofs: proofs.iter().map(|proof| proof.name).collect(),
        }
    }

    /// Every file, in no order that matters.
    pub fn files(&self) -> impl Iterator<Item = &EmittedFile> {
        [&self.properties, &self.emptied, &self.registers, &self.script, &self.abc].into_iter()
    }
}

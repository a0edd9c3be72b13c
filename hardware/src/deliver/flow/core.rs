//! FuseSoC core description.

use std::fmt::Write as _;

use super::constraints::Constraints;
use super::testbench::Testbench;
use crate::deliver::design::{EmittedDesign, EmittedFile};
use crate::deliver::formal::Formal;
use crate::deliver::template::filled;

/// What a core lists beside the design.
pub(super) struct CoreFiles<'a> {
    pub(super) header: &'a EmittedFile,
    pub(super) testbench: &'a Testbench,
    pub(super) constraints: &'a Constraints,
    pub(super) formal: &'a Formal,
}

/// The proofs and the design, as they lie beside one another: sby's script names
/// them from the folder of the design.
fn proofs(files: &[EmittedFile], formal: &Formal) -> String {
    let mut text = String::new();
    for file in files {
        let name = &file.name;
        let _ = writeln!(text, "      - {name}: {{copyto: {name}, file_type: verilogSource-2005}}");
    }
    for file in formal.files() {
        let name = format!("{}/{}", Formal::FOLDER, file.name);
        let kind = match name.ends_with(".sby") {
            true => "sbyConfigTemplate",
            false => "user",
        };
        let _ = writeln!(text, "      - {name}: {{copyto: {name}, file_type: {kind}}}");
    }
    text
}

/// FuseSoC core with lint, simulation and synthesis targets.
pub(super) fn core(design: &EmittedDesign, parts: &CoreFiles) -> EmittedFile {
    let Constraints { sdc, lpf, xdc } = parts.constraints;
    let listed = |files: &[EmittedFile]| -> String {
        files.iter().map(|file| format!("      - {}\n", file.name)).collect()
    };
    let vectors = parts.testbench.vectors.iter();
    let vectors: String =
        vectors.map(|file| format!("      - {0}: {{copyto: {0}}}\n", file.name)).collect();
    let (parameters, of_synth) = match design.interface().histogram() {
        Some(_) => (BLOCK_RAM, "\n    parameters: [ECP5_BLOCK_RAM=true]"),
        None => ("", ""),
    };
    let text = filled(
        include_str!("fusesoc.core"),
        &[
            ("TOP", &design.top()),
            ("NAME", &vlnv_name(&design.prefix.of(&design.sensor.scene().name))),
            ("MADE_BY", design.made_by),
            ("VERSION", env!("CARGO_PKG_VERSION")),
            ("RTL", &listed(design.files)),
            ("HEADER", &parts.header.name),
            ("TESTBENCH", &listed(&parts.testbench.files)),
            ("VECTORS", &vectors),
            ("PROOFS", &proofs(design.files, parts.formal)),
            ("SDC", &sdc.name),
            ("XDC", &xdc.name),
            ("LPF", &lpf.name),
            ("PARAMETERS", parameters),
            ("TESTBENCH_TOP", &parts.testbench.top),
            ("OF_SYNTH", of_synth),
        ],
    );
    EmittedFile { name: design.file_name(".core"), text }
}

/// What makes memories of DP16KD.
const BLOCK_RAM: &str = "\
parameters:
  ECP5_BLOCK_RAM:
    datatype: bool
    paramtype: vlogdefine
    description: Memories of Lattice's DP16KD, with its output register

";

/// The scene's name with nothing that a core's name cannot have.
fn vlnv_name(scene_name: &str) -> String {
    scene_name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_core_name_has_no_colon_or_space() {
        assert_eq!(vlnv_name("two views: left"), "two_views__left");
    }
}

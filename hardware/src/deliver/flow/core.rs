//! FuseSoC core description.

use std::fmt::Write as _;

use super::constraints::Constraints;
use super::testbench::Testbench;
use crate::deliver::design::{Design, EmittedFile};
use crate::deliver::formal::Formal;

/// What a core lists beside the design.
pub(super) struct Parts<'a> {
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
pub(super) fn core(design: &Design, parts: &Parts) -> EmittedFile {
    let vlnv_name = vlnv_name(&design.prefix.of(&design.sensor.scene().name));
    let has_memories = design.interface().histogram().is_some();
    let text = format!(
        "\
CAPI=2:
# FuseSoC core of {top}. In this folder, or with it as a library:
#   fusesoc --cores-root . run --target=TARGET goldtof:sensor:{vlnv_name}
# where TARGET is lint (Verilator), sim (Icarus), sim_verilator, formal (sby), or synth (ECP5:
# Yosys, nextpnr-ecp5, ecppack).
# Made by  {made_by}
name: goldtof:sensor:{vlnv_name}:{version}
description: DS-CDMA indirect time-of-flight sensor

{filesets}
{parameters}{targets}",
        top = design.top(),
        made_by = design.made_by,
        version = env!("CARGO_PKG_VERSION"),
        filesets = filesets(design, parts),
        parameters = match has_memories {
            true => BLOCK_RAM,
            false => "",
        },
        targets = targets(&design.top(), &parts.testbench.top, has_memories),
    );
    EmittedFile { name: design.file_name(".core"), text }
}

fn filesets(design: &Design, parts: &Parts) -> String {
    let listed = |files: &[EmittedFile]| -> String {
        files.iter().map(|file| format!("      - {}\n", file.name)).collect()
    };
    let vectors = parts.testbench.vectors.iter();
    let Constraints { sdc, lpf, xdc } = parts.constraints;
    format!(
        "\
filesets:
  rtl:
    file_type: verilogSource-2005
    files:
{rtl}      - {header}: {{is_include_file: true}}

  testbench:
    file_type: verilogSource-2005
    files:
{testbench}
  vectors:
    file_type: user
    files:
{vectors}
  proofs:
    files:
{proofs}
  clock_sdc:
    files:
      - {sdc}: {{file_type: SDC}}

  clock_xdc:
    files:
      - {xdc}: {{file_type: xdc}}

  clock_lpf:
    files:
      - {lpf}: {{file_type: LPF}}
",
        rtl = listed(design.files),
        header = parts.header.name,
        testbench = listed(&parts.testbench.files),
        vectors = vectors
            .map(|file| format!("      - {0}: {{copyto: {0}}}\n", file.name))
            .collect::<String>(),
        proofs = proofs(design.files, parts.formal),
        sdc = sdc.name,
        xdc = xdc.name,
        lpf = lpf.name,
    )
}

/// What makes memories of DP16KD.
const BLOCK_RAM: &str = "\
parameters:
  ECP5_BLOCK_RAM:
    datatype: bool
    paramtype: vlogdefine
    description: Memories of Lattice's DP16KD, with its output register

";

fn targets(top: &str, testbench_top: &str, has_memories: bool) -> String {
    let parameters = match has_memories {
        true => "\n    parameters: [ECP5_BLOCK_RAM=true]",
        false => "",
    };
    format!(
        "\
targets:
  default: &default
    filesets: [rtl, \"tool_vivado? (clock_xdc)\", \"tool_quartus? (clock_sdc)\"]
    toplevel: {top}

  lint:
    <<: *default
    description: Verilator's warnings, all of them
    flow: lint
    flow_options:
      tool: verilator
      verilator_options: [-Wall]

  sim: &sim
    description: Self-checking testbench in Icarus Verilog
    filesets: [rtl, testbench, vectors]
    toplevel: {testbench_top}
    flow: sim
    flow_options:
      tool: icarus
      iverilog_options: [-g2005]

  sim_verilator:
    <<: *sim
    description: Self-checking testbench in Verilator
    flow_options:
      tool: verilator
      mode: binary

  formal:
    <<: *default
    description: Proofs, all of them
    filesets: [proofs]
    default_tool: symbiyosys

  synth:
    <<: *default
    description: Bitstream for an ECP5-25k of speed 6; add pins before it meets a board
    filesets: [rtl, clock_lpf]{parameters}
    flow: trellis
    flow_options:
      yosys_synth_options: [-abc9]
      nextpnr_options: [--25k, --package, CABGA381, --speed, 6, --lpf-allow-unconstrained]
"
    )
}

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

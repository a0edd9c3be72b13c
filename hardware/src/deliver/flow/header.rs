//! The widths of the ports, for Verilog that is written round the design.

use std::fmt::Write as _;

use crate::deliver::design::{EmittedDesign, EmittedFile};

/// A macro with the width of each port: `SENSOR_TOP_M_AXIS_TDATA_BITS`.
pub(super) fn header(design: &EmittedDesign) -> EmittedFile {
    let macros = design.prefix.of_macro("SENSOR_TOP");
    let mut text = format!(
        "// Bits of each port of {top}, for what is written round it\n// Made by  {made_by}\n\n\
         `ifndef {macros}_VH\n`define {macros}_VH\n\n",
        top = design.top(),
        made_by = design.made_by,
    );
    for port in design.interface().ports() {
        let name = port.name.to_uppercase();
        let _ = writeln!(text, "`define {macros}_{name}_BITS {}", port.width);
    }
    text += "\n`endif\n";
    EmittedFile { name: design.file_name(".vh"), text }
}

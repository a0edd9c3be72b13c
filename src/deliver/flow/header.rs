//! The widths of the ports, for Verilog that is written round the design.

use std::fmt::Write as _;

use crate::deliver::emission::EmittedFile;
use crate::sensor::interface::Interface;

/// Its name.
const HEADER: &str = "sensor_top.vh";

/// A macro with the width of each port: `SENSOR_TOP_M_AXIS_TDATA_BITS`.
pub(super) fn header(interface: &Interface, made_by: &str) -> EmittedFile {
    let mut text = format!(
        "// Bits of each port of sensor_top, for what is written round it\n// Made by  {made_by}\n\n\
         `ifndef SENSOR_TOP_VH\n`define SENSOR_TOP_VH\n\n"
    );
    for port in interface.ports() {
        let name = port.name.to_uppercase();
        let _ = writeln!(text, "`define SENSOR_TOP_{name}_BITS {}", port.width);
    }
    text += "\n`endif\n";
    EmittedFile {
        name: HEADER.to_owned(),
        text,
    }
}

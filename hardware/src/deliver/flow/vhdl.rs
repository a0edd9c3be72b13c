//! The design's top module for VHDL that instantiates it.

use std::fmt::Write as _;

use crate::deliver::design::{EmittedDesign, EmittedFile};
use crate::sensor::port::{Direction, Port};

/// A package with a component declaration, and the widths of the ports as constants.
pub(super) fn package(design: &EmittedDesign) -> EmittedFile {
    let top = design.top();
    let ports = design.interface().ports();
    let mut text = format!(
        "-- Component of the Verilog module {top}, for VHDL that instantiates it:\n\
         --   use work.{top}_pkg.all;\n\
         -- Compile the Verilog into the same library; the tool binds the component by its name.\n\
         -- Made by  {made_by}\n\n\
         library ieee;\nuse ieee.std_logic_1164.all;\n\n\
         package {top}_pkg is\n\n    -- Bits of the ports\n",
        made_by = design.made_by,
    );
    let macros = design.prefix.of_macro("SENSOR_TOP");
    for port in &ports {
        let name = port.name.to_uppercase();
        let _ = writeln!(text, "    constant {macros}_{name}_BITS : positive := {};", port.width);
    }
    let declared: Vec<String> = ports.iter().map(declaration).collect();
    let _ = write!(
        text,
        "\n    component {top} is\n        port (\n{}\n        );\n    end component;\n\n\
         end package;\n",
        declared.join(";\n")
    );
    EmittedFile { name: design.file_name(".vhd"), text }
}

fn declaration(port: &Port) -> String {
    let direction = match port.direction {
        Direction::Input => "in ",
        Direction::Output => "out",
    };
    let subtype = match port.width {
        1 => "std_logic".to_owned(),
        width => format!("std_logic_vector({} downto 0)", width - 1),
    };
    format!("            {:<13} : {direction} {subtype}", port.name)
}

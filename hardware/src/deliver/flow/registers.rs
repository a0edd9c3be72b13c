//! The registers for those who write to them: SystemRDL, from which UVM's register models and others follow, and a
//! header for C.

use std::fmt::Write as _;

use serde::Serialize;

use crate::deliver::design::{EmittedDesign, EmittedFile};
use crate::sensor::registers::{Access, MappedRegister, RegisterField};

/// What a host needs to know of a design with registers.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RegisterFiles {
    /// The registers in SystemRDL 2.0.
    pub systemrdl: EmittedFile,
    /// Addresses, bits and values after power-up as macros, for C.
    pub c_header: EmittedFile,
    /// The registers.
    pub map: Vec<MappedRegister>,
}

impl RegisterFiles {
    /// Those of a design, if it has registers.
    pub(super) fn of(design: &EmittedDesign) -> Option<RegisterFiles> {
        let interface = design.interface();
        let plan = interface.registers.as_ref()?;
        let map = plan.map(&interface.timing, &interface.source_codes);
        Some(RegisterFiles {
            systemrdl: EmittedFile {
                name: design.file_name("_registers.rdl"),
                text: systemrdl(design, &map),
            },
            c_header: EmittedFile {
                name: design.file_name("_registers.h"),
                text: c_header(design, &map),
            },
            map,
        })
    }

    /// Every file.
    pub(super) fn files(&self) -> impl Iterator<Item = &EmittedFile> {
        [&self.systemrdl, &self.c_header].into_iter()
    }
}

/// Each register is a type of its own: what tools derive names from does not change with a reset value.
fn systemrdl(design: &EmittedDesign, map: &[MappedRegister]) -> String {
    let top = design.top();
    let mut text = format!(
        "// Registers of {top}, in SystemRDL 2.0\n// Made by  {}\n\naddrmap {top}_registers {{\n    \
         name = \"Registers of {top}\";\n    default regwidth = 32;\n    default accesswidth = 32;\n",
        design.made_by
    );
    for register in map {
        let (name, kind) = (&register.name, register.name.to_lowercase());
        let about = quoted(&register.about);
        let _ = write!(
            text,
            "\n    reg {kind}_t {{\n        name = \"{name}\";\n        desc = \"{about}\";\n"
        );
        for field in &register.fields {
            let _ = writeln!(text, "        {}", rdl_field(field));
        }
        let _ = writeln!(text, "    }};\n    {kind}_t {name} @ 0x{:03x};", register.address);
    }
    text + "};\n"
}

fn rdl_field(field: &RegisterField) -> String {
    let access = match field.access {
        Access::Read if field.reset.is_some() => "sw = r; hw = na;",
        Access::Read => "sw = r; hw = w;",
        Access::ReadWrite => "sw = rw; hw = r;",
        Access::WriteOneToClear => "sw = rw; onwrite = woclr; hw = w;",
    };
    let reset =
        field.reset.map_or_else(String::new, |value| format!(" = {}'h{value:x}", field.width));
    format!(
        "field {{ {access} desc = \"{}\"; }} {}[{}:{}]{reset};",
        quoted(&field.about),
        field.name,
        field.first_bit + field.width - 1,
        field.first_bit
    )
}

fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}

fn c_header(design: &EmittedDesign, map: &[MappedRegister]) -> String {
    let macros = format!("{}_REGISTERS", design.prefix.of_macro("SENSOR_TOP"));
    let mut text = format!(
        "/* Registers of {}: addresses of bytes, bits, and values at power-up\n * Made by  {}\n */\n\n\
         #ifndef {macros}_H\n#define {macros}_H\n",
        design.top(),
        design.made_by.replace("*/", "* /"),
    );
    for register in map {
        let name = format!("{macros}_{}", register.name);
        let _ = writeln!(
            text,
            "\n/* {} */\n#define {name} 0x{:03x}u",
            register.about, register.address
        );
        for field in &register.fields {
            let of_field = format!("{name}_{}", field.name);
            let mask = (u64::MAX >> (64 - field.width)) << field.first_bit;
            let _ = writeln!(
                text,
                "#define {of_field}_SHIFT {} /* {} */",
                field.first_bit, field.about
            );
            let _ = writeln!(text, "#define {of_field}_MASK 0x{mask:08x}u");
            if let Some(value) = field.reset {
                let _ = writeln!(text, "#define {of_field}_RESET 0x{value:x}u");
            }
        }
    }
    text + "\n#endif\n"
}

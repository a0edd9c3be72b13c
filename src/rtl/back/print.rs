//! Verilog-2005 text of a module: header, ports, declarations, instances.

use std::fmt::Write;

use super::module::{Assign, Module};
use super::share::{ModuleType, Parameter};
use super::signals::{Role, Signal};
use super::text::{
    LINE_WIDTH, clocked_block, expression, literal, push_assignment, push_comments, wrapped,
};

/// The whole file of one module.
pub fn module_text(types: &[ModuleType], index: usize, made_by: &str) -> String {
    let this = &types[index];
    let mut out = header(this, made_by);
    out.push_str("`default_nettype none\n\n");
    out.push_str(&format!("module {}", this.name));
    out.push_str(&parameter_list(&this.parameters));
    out.push_str(&port_list(&this.module));
    let mut body = constants(this);
    body.push_str(&module_body_with(&this.module, &|instance| {
        instance_head(types, this, instance)
    }));
    out.push('\n');
    out.push_str(body.trim_start_matches('\n'));
    out.push_str("\nendmodule\n\n`default_nettype wire\n");
    out
}

/// What a module does, without the values of its constants: modules of equal
/// bodies are one.
pub fn module_body(module: &Module) -> String {
    let ports = port_list(module);
    let tables: Vec<_> = module.tables.iter().map(|t| &t.bits).collect();
    let body = module_body_with(module, &|instance| {
        format!("{} ", module.instances[instance].name)
    });
    format!("{ports}{tables:?}{body}")
}

fn header(this: &ModuleType, made_by: &str) -> String {
    let description = &this.module.description;
    let mut out = format!("// {}: {}\n", this.name, description.title);
    for note in &description.notes {
        out.push_str("//\n");
        for line in wrapped(note, LINE_WIDTH - 3) {
            let _ = writeln!(out, "// {line}");
        }
    }
    let facts = &description.facts;
    let label_width = facts.iter().map(|(l, _)| l.len()).max().unwrap_or(0).max(7);
    out.push_str("//\n");
    for (label, text) in facts {
        for (number, line) in wrapped(text, LINE_WIDTH - 5 - label_width)
            .iter()
            .enumerate()
        {
            let label = if number == 0 { label } else { "" };
            let _ = writeln!(out, "// {label:label_width$}  {line}");
        }
    }
    let _ = writeln!(out, "// {:label_width$}  {made_by}", "Made by");
    out.push('\n');
    out
}

fn range(width: u32) -> String {
    if width == 1 {
        String::new()
    } else {
        format!("[{}:0]", width - 1)
    }
}

fn spaced(range: &str) -> String {
    if range.is_empty() {
        String::new()
    } else {
        format!("{range} ")
    }
}

fn parameter_list(parameters: &[Parameter]) -> String {
    let varying: Vec<_> = parameters.iter().filter(|p| p.varies()).collect();
    if varying.is_empty() {
        return " (\n".to_owned();
    }
    let mut out = " #(\n".to_owned();
    for (index, parameter) in varying.iter().enumerate() {
        let _ = writeln!(out, "    // {}", parameter.about);
        let _ = writeln!(
            out,
            "    parameter {}{} = {}{}",
            spaced(&range(parameter.width)),
            parameter.name,
            literal(parameter.values[0], parameter.width),
            if index + 1 < varying.len() { "," } else { "" },
        );
    }
    out.push_str(") (\n");
    out
}

fn port_list(module: &Module) -> String {
    let mut out = String::new();
    let signals = |id: &usize| &module.signals[*id];
    let range_width = module
        .ports
        .iter()
        .map(|id| range(signals(id).width).len())
        .max()
        .unwrap_or(0);
    let name_width = module
        .ports
        .iter()
        .map(|id| signals(id).name.len() + 1)
        .max()
        .unwrap_or(0);
    let mut heading = "";
    for (index, id) in module.ports.iter().enumerate() {
        let port = signals(id);
        if port_heading(port) != heading {
            if !heading.is_empty() {
                out.push('\n');
            }
            heading = port_heading(port);
            let _ = writeln!(out, "    // {heading}");
        }
        let direction = if port.role == Role::Input {
            "input  wire"
        } else if is_output_register(module, &port.name) {
            "output reg "
        } else {
            "output wire"
        };
        let comma = if index + 1 < module.ports.len() {
            ","
        } else {
            ""
        };
        let name = format!("{}{comma}", port.name);
        let range = range(port.width);
        let _ = writeln!(
            out,
            "    {direction} {range:range_width$} {name:name_width$} // {}",
            port.about
        );
    }
    out.push_str(");\n");
    out
}

fn is_output_register(module: &Module, name: &str) -> bool {
    module
        .registers
        .iter()
        .any(|(q, _)| module.signals[*q].name == name)
}

/// The heading that a port names, or one by its direction.
fn port_heading(port: &Signal) -> &str {
    match (&port.heading, port.role) {
        (Some(heading), _) => heading,
        (None, _) if matches!(port.name.as_str(), "i_clk" | "i_rst") => "Clock and reset",
        (None, Role::Input) => "Inputs",
        (None, _) => "Outputs",
    }
}

fn constants(this: &ModuleType) -> String {
    let mut out = String::new();
    for parameter in &this.parameters {
        if parameter.is_handed_on || parameter.varies() {
            continue;
        }
        let _ = writeln!(
            out,
            "\n    // {}\n    localparam {}{} = {};",
            parameter.about,
            spaced(&range(parameter.width)),
            parameter.name,
            literal(parameter.values[0], parameter.width),
        );
    }
    for table in &this.module.tables {
        let contents = &this.module.signals[table.contents];
        let _ = writeln!(
            out,
            "\n    // {}; entry 0 is the least significant bit\n    localparam {}{} = {};",
            contents.about,
            spaced(&range(contents.width)),
            contents.name,
            table_literal(&table.bits, contents.width as usize),
        );
    }
    out
}

/// A table as pieces of 64 bits, the last entries first.
fn table_literal(bits: &[u8], width: usize) -> String {
    let pieces: Vec<String> = (0..width)
        .step_by(64)
        .rev()
        .map(|start| {
            let end = (start + 64).min(width);
            let value = (start..end).rev().fold(0, |value: u128, index| {
                (value << 1) | u128::from(bits.get(index).copied().unwrap_or(0))
            });
            format!("{}'h{value:x}", end - start)
        })
        .collect();
    if pieces.len() == 1 {
        return pieces[0].clone();
    }
    let mut out = "{".to_owned();
    for (index, line) in pieces.chunks(4).enumerate() {
        let comma = if index == 0 { "" } else { "," };
        let _ = write!(out, "{comma}\n        {}", line.join(", "));
    }
    out.push_str("\n    }");
    out
}

fn module_body_with(module: &Module, instance_head: &dyn Fn(usize) -> String) -> String {
    let mut out = declarations(module);
    out.push_str(&assignments(module));
    for (index, instance) in module.instances.iter().enumerate() {
        let _ = writeln!(out, "\n    {}(", instance_head(index));
        let port_width = instance
            .connections
            .iter()
            .map(|(port, _)| port.len())
            .max()
            .unwrap_or(0);
        for (number, (port, value)) in instance.connections.iter().enumerate() {
            let comma = if number + 1 < instance.connections.len() {
                ","
            } else {
                ""
            };
            let _ = writeln!(
                out,
                "        .{port:port_width$} ({}){comma}",
                expression(value, module)
            );
        }
        out.push_str("    );\n");
    }
    out.push_str(&clocked_block(module));
    out
}

fn instance_head(types: &[ModuleType], this: &ModuleType, instance: usize) -> String {
    let (child, first) = this.children[instance];
    let below = &types[child];
    let name = &this.module.instances[instance].name;
    let overrides: Vec<String> = below
        .parameters
        .iter()
        .enumerate()
        .filter(|(_, parameter)| parameter.varies())
        .map(|(index, parameter)| {
            let here = &this.parameters[first + index];
            let value = if here.varies() {
                here.name.clone()
            } else {
                literal(here.values[0], here.width)
            };
            format!("        .{}({value})", parameter.name)
        })
        .collect();
    if overrides.is_empty() {
        format!("{} {name} ", below.name)
    } else {
        format!(
            "{} #(\n{}\n    ) {name} ",
            below.name,
            overrides.join(",\n")
        )
    }
}

fn declarations(module: &Module) -> String {
    let is_port_name = |name: &str| module.ports.iter().any(|p| module.signals[*p].name == name);
    let registers = module
        .registers
        .iter()
        .map(|(id, _)| ("reg ", &module.signals[*id]));
    let wires = module.wires.iter().map(|id| ("wire", &module.signals[*id]));
    let declared: Vec<_> = registers
        .chain(wires)
        .filter(|(_, signal)| !is_port_name(&signal.name))
        .collect();
    let mut out = String::new();
    if declared.is_empty() {
        return out;
    }
    let range_width = declared
        .iter()
        .map(|(_, s)| range(s.width).len())
        .max()
        .unwrap_or(0);
    let name_width = declared
        .iter()
        .map(|(_, s)| s.name.len() + 1)
        .max()
        .unwrap_or(0);
    out.push('\n');
    for (kind, signal) in declared {
        let range = range(signal.width);
        let name = format!("{};", signal.name);
        let space = if range_width > 0 { " " } else { "" };
        let line = format!(
            "    {kind} {range:range_width$}{space}{name:name_width$} // {}",
            signal.about
        );
        let line = line.trim_end_matches("// ").trim_end();
        let _ = writeln!(out, "{line}");
    }
    out
}

fn assignments(module: &Module) -> String {
    let mut out = String::new();
    for Assign {
        target,
        value,
        comments,
    } in &module.assigns
    {
        if out.is_empty() || !comments.is_empty() {
            out.push('\n');
        }
        push_comments(&mut out, comments, 4);
        let target = &module.signals[*target].name;
        push_assignment(&mut out, 4, &format!("assign {target} ="), value, module);
    }
    out
}

//! Verilog-2005 text of a module: header, ports, declarations, instances.

use std::fmt::Write;

use super::module::{Assign, Module};
use super::module_type::{ModuleType, Parameter};
use super::prefix::Prefix;
use super::signals::{Role, Signal};
use super::text::{
    LINE_WIDTH, clocked_block, commented, expression, literal, memory_block, push_broken, wrapped,
};
use crate::rtl::front::StateCheck;

/// The module that checks LFSRs' constants.
pub const LFSR_CHECK: &str = "lfsr_check";
/// The module that memories are instances of.
pub const BLOCK_MEMORY: &str = "block_memory";

/// The whole file of one module.
pub fn module_text(types: &[ModuleType], index: usize, prefix: &Prefix, made_by: &str) -> String {
    let this = &types[index];
    let mut out = header(this, made_by);
    out.push_str("`default_nettype none\n\n");
    out.push_str(&format!("module {}", this.name));
    out.push_str(&parameter_list(&this.parameters));
    let is_top = index + 1 == types.len();
    out.push_str(&port_list(&this.module, is_top));
    let mut body = constants(this);
    body.push_str(&module_body_with(&this.module, &prefix.of(BLOCK_MEMORY), &|instance| {
        instance_head(types, this, instance)
    }));
    out.push('\n');
    out.push_str(body.trim_start_matches('\n'));
    out.push_str(&checks(this, prefix));
    out.push_str("\nendmodule\n\n`default_nettype wire\n");
    out
}

/// What a module does, without the values of its constants: modules of equal
/// bodies are one.
pub fn module_body(module: &Module) -> String {
    let ports = port_list(module, false);
    let tables: Vec<_> = module.tables.iter().map(|t| &t.bits).collect();
    let body = module_body_with(module, BLOCK_MEMORY, &|instance| {
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
        for (number, line) in wrapped(text, LINE_WIDTH - 5 - label_width).iter().enumerate() {
            let label = if number == 0 { label } else { "" };
            let _ = writeln!(out, "// {label:label_width$}  {line}");
        }
    }
    let _ = writeln!(out, "// {:label_width$}  {made_by}", "Made by");
    out.push('\n');
    out
}

fn range(width: u32) -> String {
    if width == 1 { String::new() } else { format!("[{}:0]", width - 1) }
}

fn spaced(range: &str) -> String {
    if range.is_empty() { String::new() } else { format!("{range} ") }
}

fn parameter_list(parameters: &[Parameter]) -> String {
    let varying: Vec<_> = parameters.iter().filter(|p| p.varies()).collect();
    if varying.is_empty() {
        return " (\n".to_owned();
    }
    let code = |parameter: &Parameter| {
        let range = spaced(&range(parameter.width));
        let value = literal(parameter.values[0], parameter.width);
        format!("parameter {range}{} = {value}", parameter.name)
    };
    let lines = varying.iter().map(|p| (code(p), p.said()));
    format!(" #(\n{}) (\n", listed(lines.collect()))
}

/// Lines of a list, each with its comment.
fn listed(mut lines: Vec<(String, String)>) -> String {
    let last = lines.len() - 1;
    for (code, _) in &mut lines[..last] {
        code.push(',');
    }
    aligned(&lines)
}

/// Lines of code, their comments below one another.
fn aligned(lines: &[(String, String)]) -> String {
    let padding = lines.iter().map(|(code, _)| code.len()).max().unwrap_or(0);
    let line = |(code, about): &(String, String)| commented(4, code, padding, about);
    lines.iter().map(line).collect()
}

/// The ports. Clock and reset are explained in the top module only.
fn port_list(module: &Module, is_top: bool) -> String {
    let ports: Vec<&Signal> = module.ports.iter().map(|id| &module.signals[*id]).collect();
    let range_width = ports.iter().map(|port| range(port.width).len()).max();
    let range_width = range_width.unwrap_or(0);
    let mut lines = Vec::new();
    for port in &ports {
        let kind = if port.role == Role::Input {
            "input  wire"
        } else if is_output_register(module, &port.name) {
            "output reg "
        } else {
            "output wire"
        };
        let space = if range_width > 0 { " " } else { "" };
        let range = range(port.width);
        let code = format!("{kind}{space}{range:range_width$} {}", port.name);
        let is_said = is_top || !is_clock_or_reset(port);
        let about = if is_said { port.about.as_str() } else { "" };
        lines.push((code, about.to_owned()));
    }
    let listed = listed(lines);
    let mut out = String::new();
    let mut before: Option<&Signal> = None;
    let mut printed = listed.lines();
    for port in ports {
        if before.is_some_and(|before| group_of(before) != group_of(port)) {
            out.push('\n');
        }
        if let Some(heading) = &port.heading
            && before.and_then(|before| before.heading.as_ref()) != Some(heading)
        {
            let _ = writeln!(out, "    // {heading}");
        }
        before = Some(port);
        // A line of code ends what is printed of a port.
        for line in printed.by_ref() {
            let _ = writeln!(out, "{line}");
            if !line.trim_start().starts_with("//") {
                break;
            }
        }
    }
    out.push_str(");\n");
    out
}

fn is_clock_or_reset(port: &Signal) -> bool {
    matches!(port.name.as_str(), "i_clk" | "i_rst")
}

/// What stands together in a list of ports.
fn group_of(port: &Signal) -> (Option<&str>, bool, bool) {
    match &port.heading {
        Some(heading) => (Some(heading), false, false),
        None => (None, is_clock_or_reset(port), port.role == Role::Input),
    }
}

fn is_output_register(module: &Module, name: &str) -> bool {
    module.registers.iter().any(|(q, _)| module.signals[*q].name == name)
}

fn constants(this: &ModuleType) -> String {
    let own = this.parameters.iter();
    let own: Vec<_> = own.filter(|p| !p.is_handed_on && !p.varies()).collect();
    let mut out = String::new();
    for group in own.chunk_by(|a, b| a.heading == b.heading) {
        out.push('\n');
        if let Some(heading) = &group[0].heading {
            out.push_str(&commented(4, &format!("// {heading}"), 0, ""));
        }
        let names = group.iter().map(|p| p.name.len()).max().unwrap_or(0);
        let line = |p: &&Parameter| {
            let range = spaced(&range(p.width));
            let value = literal(p.values[0], p.width);
            let code = format!("localparam {range}{:names$} = {value};", p.name);
            (code, p.about.clone())
        };
        out.push_str(&aligned(&group.iter().map(line).collect::<Vec<_>>()));
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

/// The checks of constants, which synthesis does not see.
fn checks(this: &ModuleType, prefix: &Prefix) -> String {
    let checks = &this.module.description.checks;
    if checks.is_empty() {
        return String::new();
    }
    let mut out = "\n`ifndef SYNTHESIS\n".to_owned();
    for check in checks {
        let StateCheck { taps, first, shifts, last } = check;
        let taps = taps.to_uppercase();
        let own = this.parameters.iter().find(|p| p.name == taps);
        let width = own.map_or(0, |p| p.width);
        let _ = writeln!(
            out,
            "    {} #(\n        .WIDTH({width}), .TAPS({taps}), .SHIFTS(64'd{shifts}),\n        \
             .FIRST({}), .LAST({})\n    ) {last}_check ();",
            prefix.of(LFSR_CHECK),
            first.to_uppercase(),
            last.to_uppercase(),
        );
    }
    out.push_str("`endif\n");
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

fn module_body_with(
    module: &Module,
    memory_module: &str,
    instance_head: &dyn Fn(usize) -> String,
) -> String {
    let mut out = declarations(module);
    out.push_str(&assignments(module));
    for (index, instance) in module.instances.iter().enumerate() {
        let _ = writeln!(out, "\n    {}(", instance_head(index));
        let port_width = instance.connections.iter().map(|(port, _)| port.len()).max().unwrap_or(0);
        for (number, (port, value)) in instance.connections.iter().enumerate() {
            let comma = if number + 1 < instance.connections.len() { "," } else { "" };
            let value = format!("({}){comma}", expression(value, module));
            push_broken(&mut out, 8, &format!(".{port:port_width$}"), &value);
        }
        out.push_str("    );\n");
    }
    for memory in &module.memories {
        out.push_str(&memory_block(memory, module, memory_module));
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
            let value =
                if here.varies() { here.name.clone() } else { literal(here.values[0], here.width) };
            format!("        .{}({value})", parameter.name)
        })
        .collect();
    if overrides.is_empty() {
        format!("{} {name} ", below.name)
    } else {
        format!("{} #(\n{}\n    ) {name} ", below.name, overrides.join(",\n"))
    }
}

fn declarations(module: &Module) -> String {
    let is_port_name = |name: &str| module.ports.iter().any(|p| module.signals[*p].name == name);
    let registers = module.registers.iter().map(|(id, _)| ("reg ", &module.signals[*id]));
    let read = module.memories.iter().map(|memory| ("wire", &module.signals[memory.q]));
    let wires = module.wires.iter().map(|id| ("wire", &module.signals[*id]));
    let declared: Vec<_> = registers
        .chain(read)
        .chain(wires)
        .filter(|(_, signal)| !is_port_name(&signal.name))
        .collect();
    if declared.is_empty() {
        return String::new();
    }
    let range_width = declared.iter().map(|(_, s)| range(s.width).len()).max();
    let range_width = range_width.unwrap_or(0);
    let space = if range_width > 0 { " " } else { "" };
    let line = |(kind, signal): (&str, &Signal)| {
        let range = range(signal.width);
        let code = format!("{kind} {range:range_width$}{space}{};", signal.name);
        // The port of the instance says it.
        let is_said = !matches!(signal.role, Role::InstanceOutput(_));
        let about = if is_said { signal.about.as_str() } else { "" };
        (code, about.to_owned())
    };
    let lines: Vec<_> = declared.into_iter().map(line).collect();
    format!("\n{}", aligned(&lines))
}

fn assignments(module: &Module) -> String {
    let mut out = String::new();
    for Assign { target, value } in &module.assigns {
        if out.is_empty() {
            out.push('\n');
        }
        let head = format!("assign {} =", module.signals[*target].name);
        push_broken(&mut out, 4, &head, &format!("{};", expression(value, module)));
    }
    out
}

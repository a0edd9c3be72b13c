//! Verilog-2005 text of a module: header, ports, declarations, instances.

use std::fmt::Write;

use super::lines::VerilogLine;
use super::module_type::{ModuleType, Parameter};
use super::number::Num;
use super::prefix::Prefix;
use super::scope::{CLOCK, RESET};
use super::sheet::{Declaration, GENERATED, INDICES, InstanceGroup, Sheet};
use super::term::Term;
use super::text::{
    LINE_WIDTH, LINE_WIDTH_BESIDE, clocked_block, commented, expression, filled, loop_head,
    operand_of, push_broken, symbol, wrapped,
};
use crate::rtl::front::{Size, StateCheck};

/// The module that checks LFSRs' constants.
pub const LFSR_CHECK: &str = "lfsr_check";
/// The module that memories are instances of.
pub const BLOCK_MEMORY: &str = "block_memory";

/// A module that others have instances of, which stands here as it is.
pub fn given_text(prefix: &Prefix, made_by: &str, name: &str, text: &str) -> String {
    let text = text.replace(name, &prefix.of(name));
    text.replacen("//\n\n", &format!("//\n// Made by  {made_by}\n\n"), 1)
}

/// The whole file of one module.
pub fn module_text(types: &[ModuleType], index: usize, prefix: &Prefix, made_by: &str) -> String {
    let this = &types[index];
    if let Some(text) = this.given {
        return given_text(prefix, made_by, &this.module.description.module, text);
    }
    let mut out = header(this, made_by);
    out.push_str("`default_nettype none\n\n");
    out.push_str(&format!("module {}", this.name));
    out.push_str(&parameter_list(this));
    let is_top = index + 1 == types.len();
    out.push_str(&port_list(&this.sheet, is_top));
    let groups = this.sheet.groups.iter().zip(&this.families);
    let heads: Vec<Head> =
        groups.map(|(group, members)| instance_head(types, this, group, members)).collect();
    let mut body = requirements(this);
    body.push_str(&constants(this, &heads));
    body.push_str(&declarations(&this.sheet));
    body.push_str(&assignments(&this.sheet));
    for (group, head) in this.sheet.groups.iter().zip(&heads) {
        body.push_str(&instance(group, &head.text));
    }
    body.push_str(&clocked_block(&this.sheet));
    out.push('\n');
    out.push_str(body.trim_start_matches('\n'));
    out.push_str(&checks(this, prefix));
    out.push_str("\nendmodule\n\n`default_nettype wire\n");
    out
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

fn range(width: &Num) -> String {
    if width.constant() == Some(1) {
        return String::new();
    }
    format!("[{}:0]", width.sub(&1u32.into()).text())
}

fn spaced(range: &str) -> String {
    if range.is_empty() { String::new() } else { format!("{range} ") }
}

fn parameter_list(this: &ModuleType) -> String {
    let varying: Vec<_> = this.parameters.iter().filter(|p| p.varies()).collect();
    let sizes = this.varying_sizes();
    let size = |size: &Size| {
        (
            format!("parameter {} = {}", size.name, size.value),
            format!("{}, {}", size.about, takes(size)),
        )
    };
    if varying.is_empty() && sizes.is_empty() {
        return " (\n".to_owned();
    }
    let code = |parameter: &Parameter| {
        let range = spaced(&range(&parameter.width.into()));
        let value = parameter.literal(0);
        format!("parameter {range}{} = {value}", parameter.name)
    };
    let lines = varying.iter().map(|p| (code(p), p.said()));
    let lines = sizes.into_iter().map(size).chain(lines);
    format!(" #(\n{}) (\n", listed(lines.collect()))
}

/// Which sizes the circuit is for.
fn takes(size: &Size) -> String {
    let (least, most) = (size.takes.start(), size.takes.end());
    match *most {
        u32::MAX => format!("{least} or more"),
        _ => format!("{least} to {most}"),
    }
}

/// What sizes have to be: elaboration finds no module of this name.
fn requirements(this: &ModuleType) -> String {
    let sizes = this.varying_sizes();
    if sizes.is_empty() {
        return String::new();
    }
    let beyond = |size: &&Size| {
        let Size { name, takes, .. } = size;
        match *takes.end() {
            u32::MAX => format!("{name} < {}", takes.start()),
            most => format!("{name} < {} || {name} > {most}", takes.start()),
        }
    };
    let beyond: Vec<String> = sizes.iter().map(beyond).collect();
    let needs = |size: &&Size| format!("{}_of_{}", size.name, takes(size).replace(' ', "_"));
    let needs: Vec<String> = sizes.iter().map(needs).collect();
    format!(
        "\n    // Elaboration ends here: there is no module of this name.\n    if ({}) \
         begin : gen_refused\n        {}_takes_{} refused ();\n    end\n",
        beyond.join(" || "),
        this.name,
        needs.join("_and_")
    )
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
    let said = lines.iter().filter(|(_, about)| !about.is_empty());
    let padding = said.map(|(code, _)| code.len()).max().unwrap_or(0);
    let line = |(code, about): &(String, String)| commented(4, code, padding, about);
    lines.iter().map(line).collect()
}

/// The ports. Clock and reset are explained in the top module only.
fn port_list(sheet: &Sheet, is_top: bool) -> String {
    let said = |port: &Declaration| match is_top || !is_clock_or_reset(port) {
        true => port.clone(),
        false => Declaration { about: String::new(), ..port.clone() },
    };
    let ports = sharing_lines(sheet.ports.iter().map(said));
    let listed = listed(declared(&ports, ""));
    let mut out = String::new();
    let mut before: Option<&Declaration> = None;
    let mut printed = listed.lines();
    for port in &ports {
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

/// Declarations of which like neighbours without a comment are one; outputs have a line each, by which
/// proofs find them.
fn sharing_lines(all: impl Iterator<Item = Declaration>) -> Vec<Declaration> {
    let mut out: Vec<Declaration> = Vec::new();
    for one in all {
        if let Some(before) = out.last_mut()
            && [&*before, &one].iter().all(|one| one.about.is_empty())
            && !one.kind.starts_with("output")
            && (before.kind, &before.width, &before.heading) == (one.kind, &one.width, &one.heading)
            && before.name.len() + 2 + one.name.len() <= MOST_NAMES
        {
            before.name += &format!(", {}", one.name);
        } else {
            out.push(one);
        }
    }
    out
}

/// Characters of names that share a declaration.
const MOST_NAMES: usize = 76;

/// Declarations in columns, each with what is said of it.
fn declared(all: &[Declaration], end: &str) -> Vec<(String, String)> {
    let range_width = all.iter().map(|one| range(&one.width).len()).max().unwrap_or(0);
    let space = if range_width > 0 { " " } else { "" };
    let line = |one: &Declaration| {
        let range = range(&one.width);
        let code = format!("{}{space}{range:range_width$} {}{end}", one.kind, one.name);
        (code, one.about.clone())
    };
    all.iter().map(line).collect()
}

fn is_clock_or_reset(port: &Declaration) -> bool {
    port.name.split(", ").all(|name| [CLOCK.0, RESET.0].contains(&name))
}

/// What stands together in a list of ports.
fn group_of(port: &Declaration) -> (Option<&str>, bool, bool) {
    match &port.heading {
        Some(heading) => (Some(heading), false, false),
        None => (None, is_clock_or_reset(port), port.kind.starts_with("input")),
    }
}

fn constants(this: &ModuleType, heads: &[Head]) -> String {
    let own = this.parameters.iter();
    let own: Vec<_> = own.filter(|p| !p.is_handed_on && !p.varies()).collect();
    let mut out = String::new();
    for group in own.chunk_by(|a, b| a.heading == b.heading) {
        out.push('\n');
        if let Some(heading) = &group[0].heading {
            out.push_str(&commented(4, &format!("// {heading}"), 0, ""));
        }
        let names = group.iter().map(|p| p.name.len()).max().unwrap_or(0);
        let ranges = group.iter().map(|p| spaced(&range(&p.width.into())).len()).max();
        let ranges = ranges.unwrap_or(0);
        let line = |p: &&Parameter| {
            let range = spaced(&range(&p.width.into()));
            let value = p.literal(0);
            let code = format!("localparam {range:ranges$}{:names$} = {value};", p.name);
            (code, p.about.clone())
        };
        out.push_str(&aligned(&group.iter().map(line).collect::<Vec<_>>()));
    }
    let tables: Vec<&String> = heads.iter().flat_map(|head| &head.tables).collect();
    if !tables.is_empty() {
        out.push('\n');
    }
    tables.into_iter().for_each(|table| out.push_str(table));
    for table in &this.module.tables {
        let contents = &this.module.signals[table.contents];
        let _ = writeln!(
            out,
            "\n    // {}; entry 0 is the least significant bit\n    localparam {}{} = {};",
            contents.about,
            spaced(&range(&contents.width.into())),
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

/// How an instance begins, and the constants that a vector of them needs for that.
struct Head {
    text: String,
    tables: Vec<String>,
}

fn instance_head(
    types: &[ModuleType],
    this: &ModuleType,
    group: &InstanceGroup,
    members: &[usize],
) -> Head {
    let (child, _) = this.children[members[0]];
    let below = &types[child];
    let mut tables = Vec::new();
    let mut overrides = Vec::new();
    let varying = below.varying_sizes();
    for (name, size) in &group.sizes {
        if below.given.is_some() || varying.iter().any(|size| size.name == *name) {
            overrides.push(format!("        .{name}({})", size.text()));
        }
    }
    if let Some((name, contents)) = &below.contents {
        overrides.push(format!("        .{name}({contents})"));
    }
    for (index, parameter) in below.parameters.iter().enumerate().filter(|(_, p)| p.varies()) {
        let value = |member: &usize| {
            let here = &this.parameters[this.children[*member].1 + index];
            if here.varies() { here.name.clone() } else { here.literal(0) }
        };
        let mut values: Vec<String> = members.iter().map(value).collect();
        let value = match values.iter().all(|value| *value == values[0]) {
            true => values.swap_remove(0),
            false => {
                let name = format!("{}_{}", group.name.to_uppercase(), parameter.name);
                values.reverse();
                let head = format!(
                    "localparam [{}:0] {name} =",
                    parameter.width as usize * values.len() - 1
                );
                let mut table = String::new();
                push_broken(&mut table, 4, &head, &format!("{{{}}};", values.join(", ")));
                tables.push(table);
                let place = Num::default().along(&parameter.width.into(), GENERATED[0], 0);
                format!("{name}[{} +: {}]", place.text(), parameter.width)
            }
        };
        overrides.push(format!("        .{}({value})", parameter.name));
    }
    let text = match overrides.is_empty() {
        true => format!("{} {} ", below.name, group.name),
        false if overrides.len() == 1 => {
            format!("{} #({}) {} ", below.name, overrides[0].trim_start(), group.name)
        }
        false => format!("{} #(\n{}\n    ) {} ", below.name, overrides.join(",\n"), group.name),
    };
    Head { text, tables }
}

/// An instance, or a loop of them.
fn instance(group: &InstanceGroup, head: &str) -> String {
    let mut out = match group.about.as_str() {
        "" => String::new(),
        about => format!("    // {about}\n"),
    };
    let _ = writeln!(out, "    {head}(");
    connections(&mut out, &group.connections);
    if group.is_family() {
        let head = loop_head(&group.count, GENERATED[0]);
        out = format!("    {head} begin : gen_{}\n{}    end\n", group.name, indented(&out));
    }
    format!("\n{out}")
}

fn indented(text: &str) -> String {
    let line = |line: &str| if line.is_empty() { "\n".to_owned() } else { format!("    {line}\n") };
    text.lines().map(line).collect()
}

/// What an instance is connected to: neighbours share lines that go the same way and are named alike on both
/// sides; any other port has its own.
fn connections(out: &mut String, connections: &[(String, Term)]) {
    let last = connections.len() - 1;
    let texts: Vec<(String, String)> = connections
        .iter()
        .enumerate()
        .map(|(number, (port, value))| {
            let comma = if number < last { "," } else { "" };
            (format!(".{port}"), format!("({}){comma}", expression(value)))
        })
        .collect();
    let mut at = 0;
    let runs = connections.chunk_by(|a, b| shares(a).is_some() && shares(a) == shares(b));
    let runs: Vec<&[(String, String)]> = runs
        .map(|run| {
            at += run.len();
            &texts[at - run.len()..at]
        })
        .collect();
    let alone = runs.iter().filter(|run| run.len() == 1);
    let width = alone.map(|run| run[0].0.len()).max().unwrap_or(0);
    for run in runs {
        if let [(port, value)] = run {
            push_broken(out, 8, &format!("{port:width$}"), value);
            continue;
        }
        let all: Vec<String> = run.iter().map(|(port, value)| format!("{port} {value}")).collect();
        for line in filled("", &all.join(" "), 0, LINE_WIDTH - 8) {
            let _ = writeln!(out, "        {line}");
        }
    }
    out.push_str("    );\n");
}

/// Which lines a connection shares: where it goes to what has the port's name, as a register or behind an instance's
/// name or not, those of its direction.
fn shares((port, value): &(String, Term)) -> Option<bool> {
    let Term::Name(name) = value else {
        return None;
    };
    let plain = port.trim_start_matches("i_").trim_start_matches("o_");
    let name = name.strip_suffix("_r").unwrap_or(name);
    let is_alike =
        name.strip_suffix(plain).is_some_and(|before| before.is_empty() || before.ends_with('_'));
    is_alike.then(|| port.starts_with("o_"))
}

/// Registers, wires, and what the wires are made of where one expression says that.
fn declarations(sheet: &Sheet) -> String {
    let mut out = String::new();
    let made: Vec<&str> = sheet.made_at_once().iter().map(|(one, _)| one.name.as_str()).collect();
    let others = sheet.declarations.iter().filter(|one| !made.contains(&one.name.as_str()));
    let (mut plain, others): (Vec<&Declaration>, Vec<&Declaration>) =
        others.partition(|one| one.kind == "wire" && one.about.is_empty());
    // Those of one width stand together.
    let known = plain.clone();
    plain.sort_by_key(|one| known.iter().position(|other| other.width == one.width));
    let lines = declared(&sharing_lines(others.into_iter().chain(plain).cloned()), ";");
    if !lines.is_empty() {
        out = format!("\n{}", aligned(&lines));
    }
    let mut counters = |kind: &str, used: Vec<&str>| {
        if !used.is_empty() {
            if out.is_empty() {
                out.push('\n');
            }
            let _ = writeln!(out, "    {kind} {};", used.join(", "));
        }
    };
    counters("integer", INDICES.into_iter().filter(|index| sheet.loops_with(index)).collect());
    counters("genvar", GENERATED.into_iter().filter(|index| sheet.generates_with(index)).collect());
    out + &made_wires(sheet)
}

/// Wires with what they are made of, each behind those that it is made of.
fn made_wires(sheet: &Sheet) -> String {
    let made = sheet.made_at_once();
    let declared = declared(&made.iter().map(|(one, _)| (*one).clone()).collect::<Vec<_>>(), " =");
    let mut out = String::new();
    for ((head, about), (_, value)) in declared.iter().zip(&made) {
        let value = format!("{};", expression(value));
        let beside = format!("    {head} {value} // {about}");
        if about.is_empty() {
            push_broken(&mut out, 4, head, &value);
        } else if beside.len() <= LINE_WIDTH_BESIDE {
            let _ = writeln!(out, "{beside}");
        } else {
            for line in wrapped(about, LINE_WIDTH - 7) {
                let _ = writeln!(out, "    // {line}");
            }
            push_broken(&mut out, 4, head, &value);
        }
    }
    if out.is_empty() { out } else { format!("\n{out}") }
}

/// What is left to assign to ports, to parts of vectors, and in loops.
fn assignments(sheet: &Sheet) -> String {
    let mut out = String::new();
    let made = sheet.made_at_once();
    let is_left = |line: &&VerilogLine| match line {
        VerilogLine::Store { target: Term::Name(name), .. } => {
            made.iter().all(|(one, _)| one.name != *name)
        }
        _ => true,
    };
    let (loops, plain): (Vec<&VerilogLine>, Vec<&VerilogLine>) = sheet
        .assigns
        .iter()
        .filter(is_left)
        .partition(|line| !matches!(line, VerilogLine::Store { .. }));
    if !plain.is_empty() {
        out.push('\n');
    }
    for line in plain {
        push_assignment(&mut out, line, 4);
    }
    for line in loops {
        out.push('\n');
        push_assignment(&mut out, line, 4);
    }
    out
}

fn push_assignment(out: &mut String, line: &VerilogLine, indent: usize) {
    match line {
        VerilogLine::Store { target, value } => {
            let head = format!("assign {} =", expression(target));
            push_broken(out, indent, &head, &format!("{};", expression(value)));
        }
        VerilogLine::Loop { index, trips, body } => {
            let head = loop_head(trips, index);
            let _ = writeln!(out, "{:indent$}{head} begin : gen_{}", "", label(body));
            body.iter().for_each(|line| push_assignment(out, line, indent + 4));
            let _ = writeln!(out, "{:indent$}end", "");
        }
        VerilogLine::Fold { target, op, index, trips, operand, zero } => {
            let inner = indent + 4;
            let target = expression(target);
            let _ = writeln!(
                out,
                "{:indent$}always @* begin : make_{target}\n{:inner$}integer {index};\n{:inner$}{target} = \
                 {};\n{:inner$}{} begin",
                "",
                "",
                "",
                expression(zero),
                "",
                loop_head(trips, index)
            );
            let joined = format!("{target} {} {};", symbol(*op), operand_of(operand, *op));
            push_broken(out, inner + 4, &format!("{target} ="), &joined);
            let _ = writeln!(out, "{:inner$}end\n{:indent$}end", "", "");
        }
        VerilogLine::If { .. } => {}
    }
}

/// What a loop of assignments makes first.
fn label(body: &[VerilogLine]) -> String {
    match &body[0] {
        VerilogLine::Store { target, .. } | VerilogLine::Fold { target, .. } => {
            let text = expression(target);
            text.split('[').next().unwrap_or(&text).to_owned()
        }
        VerilogLine::Loop { body, .. } => format!("{}_inner", label(body)),
        VerilogLine::If { yes, .. } => label(yes),
    }
}

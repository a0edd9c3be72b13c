//! The files: properties, the start of registers, and sby's tasks.

use std::fmt::Write as _;

use super::numbers::header;
use super::proofs::Proof;
use crate::deliver::design::{EmittedDesign, EmittedFile};
use crate::rtl::back::BLOCK_MEMORY;

/// Name of the folder of these files.
pub(super) const FOLDER: &str = "formal";
const REGISTERS: &str = "registers.v";
const EMPTIED: &str = "emptied.v";
const ABC: &str = "abc.sh";
/// After which a proof is given up; each takes seconds.
const TIMEOUT_S: u32 = 600;

/// What the names of proofs' modules begin with, and of what they hold a design against.
const PROOF: &str = "prove_";
const SPECIFICATION: &str = "spec_";

/// Name of the file with the properties.
fn properties_name(design: &EmittedDesign) -> String {
    design.file_name("_formal.sv")
}

/// Name of sby's file.
fn script_name(design: &EmittedDesign) -> String {
    design.file_name(".sby")
}

/// What all proofs share, the codes, and those that a host sets; then what each kind of design has.
const SHARED: [&str; 2] = [include_str!("design.sv"), include_str!("code.sv")];
const OF_CODES: [&str; 1] = [include_str!("codes.sv")];
const OF_SET_CODES: [&str; 1] = [include_str!("set_codes.sv")];
const OF_CORRELATORS: [&str; 4] = [
    include_str!("scan.sv"),
    include_str!("reference.sv"),
    include_str!("counts.sv"),
    include_str!("stream.sv"),
];
const OF_HISTOGRAMS: [&str; 1] = [include_str!("frames.sv")];
const OF_PEAKS: [&str; 1] = [include_str!("peak.sv")];
const OF_REGISTERS: [&str; 1] = [include_str!("registers.sv")];
const OF_STREAM: [&str; 1] = [include_str!("axis.sv")];

/// The properties of all proofs.
pub(super) fn properties(design: &EmittedDesign) -> EmittedFile {
    let interface = design.interface();
    let mut text = format!(
        "// What {top} has to do: a module for each proof of {script}\n\
         //\n\
         // Each has the design, a specification of its own, and assertions. Registers start as one clock\n\
         // of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any\n\
         // time. Outputs of modules inside are seen, or cut and driven by the proof, by {script}.\n",
        top = design.top(),
        script = script_name(design),
    );
    if interface.histogram().is_some() || interface.rows().is_some() {
        let _ = writeln!(text, "// What a {BLOCK_MEMORY} gives is anything, at any clock.");
    }
    let _ = write!(
        text,
        "//\n// Made by  {}\n\n`default_nettype none\n\n// The numbers of this design, and its codes.\n{}",
        design.made_by,
        header(design)
    );
    let parts: &[&str] = match interface.histogram() {
        Some(_) => &OF_HISTOGRAMS,
        // What of scans and references does not follow from the scene alone is not proven.
        None if interface.registers.is_some() => &OF_CORRELATORS[2..],
        None if interface.rows().is_some() => &OF_CORRELATORS[..OF_CORRELATORS.len() - 2],
        None => &OF_CORRELATORS,
    };
    let given = |is_there: bool, parts: &'static [&'static str]| if is_there { parts } else { &[] };
    let peaks = given(interface.peak().is_some(), &OF_PEAKS);
    let registers = given(interface.registers.is_some(), &OF_REGISTERS);
    let codes = if interface.registers.is_some() { &OF_SET_CODES } else { &OF_CODES };
    let parts =
        SHARED.iter().chain(codes).chain(parts).chain(peaks).chain(registers).chain(&OF_STREAM);
    for part in parts {
        text += part;
        text.push('\n');
    }
    text += "`default_nettype wire\n";
    // Modules of several designs may come together.
    for name in [PROOF, SPECIFICATION] {
        text = text.replace(name, &design.prefix.of(name));
    }
    EmittedFile { name: properties_name(design), text }
}

/// Maps for Yosys' techmap.
pub(super) fn registers(made_by: &str) -> EmittedFile {
    EmittedFile {
        name: REGISTERS.to_owned(),
        text: format!(
            "// Registers, for Yosys' techmap\n// Made by  {made_by}\n\n{}",
            include_str!("registers.v")
        ),
    }
}

/// For an ABC that is not sby's own.
pub(super) fn abc(made_by: &str) -> EmittedFile {
    let text = format!("#!/bin/sh\n# Made by  {made_by}\n#\n{}", include_str!("abc.sh"));
    EmittedFile { name: ABC.to_owned(), text }
}

/// Modules that a proof empties: ports without anything behind them, or behind outputs
/// whatever the proof's engine likes.
pub(super) fn emptied(design: &EmittedDesign, proofs: &[Proof]) -> EmittedFile {
    let mut text = format!(
        "// Modules of {} of which a proof drives the outputs, or leaves them free: their ports and no more\n\
         // Made by  {}\n\n`default_nettype none\n",
        design.top(),
        design.made_by,
    );
    for proof in proofs.iter().filter(|proof| proof.is_cut()) {
        let _ = writeln!(text, "\n`ifdef PROVE_{}", proof.name.to_uppercase());
        let files = design.files.iter();
        for file in files.filter(|file| proof.empties(module(design, file))) {
            text += &ports_only(&file.text, proof.frees(module(design, file)));
        }
        text += "`endif\n";
    }
    text += "\n`default_nettype wire\n";
    EmittedFile { name: EMPTIED.to_owned(), text }
}

/// The head of a module, with its end; if `free`, its outputs are anything.
fn ports_only(text: &str, free: bool) -> String {
    let head = text.lines().skip_while(|line| !line.starts_with("module "));
    let (mut ports, mut anything) = (String::new(), String::new());
    for line in head {
        let line = line.replace("output reg ", "output wire");
        let _ = writeln!(ports, "{line}");
        if line == ");" {
            break;
        }
        if let Some((range, name)) = output(&line).filter(|_| free) {
            let _ = writeln!(anything, "    (* anyseq *) wire {range}any_{name};");
            let _ = writeln!(anything, "    assign {name} = any_{name};");
        }
    }
    if anything.is_empty() {
        // Without a line of its own Yosys would take it for a black box.
        anything += "    wire nothing = 1'b0;\n";
    }
    ports + &anything + "endmodule\n"
}

/// The range, with a space behind it if there is one, and the name of an output that a
/// line declares.
fn output(line: &str) -> Option<(String, &str)> {
    let declared = line.trim_start().strip_prefix("output wire")?;
    let (declared, _comment) = declared.split_once("//").unwrap_or((declared, ""));
    let declared = declared.trim().trim_end_matches(',');
    Some(match declared.rsplit_once(']') {
        Some((range, name)) => (format!("{range}] "), name.trim_start()),
        None => (String::new(), declared),
    })
}

/// The module of a file, without the prefix.
fn module<'f>(design: &EmittedDesign, file: &'f EmittedFile) -> &'f str {
    let name = file.name.trim_end_matches(".v");
    design.prefix.strip(name).unwrap_or(name)
}

/// Name of a proof's module.
fn top(design: &EmittedDesign, proof: &Proof) -> String {
    design.prefix.of(&format!("{PROOF}{}", proof.name))
}

/// The files of the design that a proof reads.
fn names(design: &EmittedDesign, proof: &Proof) -> String {
    let files = design.files.iter();
    let read = files.filter(|file| !proof.empties(module(design, file)));
    let names: Vec<&str> = read.map(|file| file.name.as_str()).collect();
    names.join(" ")
}

/// sby's tasks.
pub(super) fn script(design: &EmittedDesign, proofs: &[Proof]) -> EmittedFile {
    let properties = properties_name(design);
    let mut text = format!(
        "# Proofs of {top}, for sby (SymbiYosys). In the folder of {top}.v:\n\
         #   sby -f {folder}/{script}         all of them\n\
         #   sby -f {folder}/{script} counts  one; {properties} says what each of them proves\n\
         # A task ..._cover passes if what its proof is about can be.\n\
         # {folder}/{ABC} says what to add where ABC is Debian's.\n\
         # Made by  {made_by}\n\n[tasks]\n",
        top = design.top(),
        script = script_name(design),
        made_by = design.made_by,
        folder = FOLDER
    );
    let covers = || proofs.iter().filter_map(|proof| Some((proof, proof.cover_task()?)));
    for proof in proofs {
        let _ = writeln!(text, "{0} on_{0}", proof.name);
    }
    for (proof, task) in covers() {
        let _ = writeln!(text, "{task} on_{} cover", proof.name);
    }
    let _ = write!(text, "\n[options]\naigsmt none\ntimeout {TIMEOUT_S}\n");
    for proof in proofs {
        for option in proof.options() {
            let _ = writeln!(text, "{}: {option}", proof.name);
        }
    }
    text += "cover: mode bmc\ncover: expect fail\n";
    for (proof, task) in covers() {
        let _ = writeln!(text, "{task}: depth {}", proof.cover_depth());
    }
    text += "\n[engines]\ncover: abc bmc3\n";
    for proof in proofs {
        let _ = writeln!(text, "{}: {}", proof.name, proof.engine_line());
    }
    text += "\n[script]\n";
    write_yosys(design, proofs, &properties, &mut text);
    text += "\n[files]\n";
    for name in design.files.iter().map(|file| &file.name) {
        let _ = writeln!(text, "{name}");
    }
    for name in [properties.as_str(), EMPTIED, REGISTERS] {
        let _ = writeln!(text, "{}/{name}", FOLDER);
    }
    EmittedFile { name: script_name(design), text }
}

/// What Yosys does before the proofs, line by line; one that begins with a name is for
/// that task alone.
fn write_yosys(design: &EmittedDesign, proofs: &[Proof], properties: &str, text: &mut String) {
    for proof in proofs {
        let _ = writeln!(text, "on_{}: read_verilog {}", proof.name, names(design, proof));
        if proof.is_cut() {
            let macros = format!("-D PROVE_{}", proof.name.to_uppercase());
            let _ = writeln!(text, "on_{}: read_verilog -formal {macros} {EMPTIED}", proof.name);
        }
    }
    let _ = writeln!(text, "~cover: read_verilog -formal -sv {properties}");
    let _ = writeln!(text, "cover: read_verilog -formal -sv -D COVER {properties}");
    for proof in proofs {
        let _ = writeln!(text, "on_{}: hierarchy -check -top {}", proof.name, top(design, proof));
    }
    *text +=
        "proc -noopt\nflatten\ncover: chformal -assert -remove\ncover: chformal -assume2assert\n";
    for proof in proofs.iter().filter(|proof| !(proof.seen.is_empty() && proof.cut.is_empty())) {
        let name = proof.name;
        let _ = writeln!(text, "on_{name}: cd {}", top(design, proof));
        for (signal, place) in &proof.seen {
            let _ = writeln!(text, "on_{name}: connect -nounset -set {signal} dut.{place}");
        }
        for (signal, place) in &proof.cut {
            let _ = writeln!(text, "on_{name}: connect -nounset -set dut.{place} {signal}");
        }
        let _ = writeln!(text, "on_{name}: cd ..");
    }
    *text += "opt_dff -nodffe\n";
    for proof in proofs {
        if let Some(mode) = proof.register_map() {
            let _ = writeln!(text, "{}: techmap -autoproc {mode}-map {REGISTERS}", proof.name);
        }
        if let Some(register) = proof.begun {
            // The map's wires are gone before, which have the attribute, too.
            let _ = writeln!(text, "{}: opt_clean", proof.name);
            let _ = writeln!(text, "{}: setattr -unset init w:*.{register}", proof.name);
        }
    }
    *text += "opt_expr\nopt_clean\n";
}

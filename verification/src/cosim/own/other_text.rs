//! Text of a design that other tools read and Verilator does not, or the other way round.
//!
//! Macros that tools define, and comments that synthesis obeys, choose what is read. What is
//! simulated is Verilator's choice.

use std::path::Path;

/// Macros that simulators, synthesis and provers define by themselves.
const MACROS: [&str; 16] = [
    "VERILATOR",
    "verilator",
    "verilator3",
    "VERILATOR_TIMING",
    "SYNTHESIS",
    "YOSYS",
    "FORMAL",
    "__ICARUS__",
    "MODEL_TECH",
    "VCS",
    "INCA",
    "XCELIUM",
    "ALDEC",
    "XILINX_SIMULATOR",
    "ALTERA_RESERVED_QIS",
    "GHDL",
];
/// Comments that take a text away from synthesis, or bring it back.
const OFF: [&str; 3] = ["translate_off", "synthesis_off", "synopsys_off"];
const ON: [&str; 3] = ["translate_on", "synthesis_on", "synopsys_on"];
/// Comments that synthesis takes for a promise.
const PROMISES: [&str; 2] = ["full_case", "parallel_case"];
/// Words that drive nets.
const DRIVERS: [&str; 4] = ["assign", "always", "always_ff", "always_comb"];
/// Words of what only checks.
const CHECKS: [&str; 8] =
    ["assert", "assume", "cover", "restrict", "property", "endproperty", "sequence", "endsequence"];
/// First words of lines that are part of what only prints, or of no circuit at all.
const PARTS: [&str; 9] =
    ["initial", "final", "begin", "end", "if", "else", "timescale", "default_nettype", "endmodule"];

/// What is to be said of a file of which other tools may read another circuit.
pub(super) fn remark(file: &Path, text: &str) -> Option<String> {
    let (line, word) = found(text)?;
    Some(format!(
        "{}:{line}: {word} chooses: what other tools read of it was not simulated",
        file.display()
    ))
}

/// The line and the word that chooses a text of which a circuit is made: drivers, instances,
/// constants, and macros.
fn found(text: &str) -> Option<(usize, &str)> {
    // For each open `ifdef the line and the tool's macro, if it asks for one.
    let mut open: Vec<Option<(usize, &str)>> = Vec::new();
    let mut off = None;
    for (number, line) in (1..).zip(text.lines()) {
        let (code, comment) = line.split_once("//").unwrap_or((line, ""));
        let of = |list: &'static [&str], text| words(text).find(|word| list.contains(word));
        let told = of(&PROMISES, comment).or_else(|| of(&PROMISES, code));
        if let Some(promise) = told {
            return Some((number, promise));
        }
        if let Some(word) = of(&OFF, line) {
            off = Some((number, word));
        } else if of(&ON, line).is_some() {
            off = None;
        }
        let mut told = words(code);
        match told.find(|word| ["ifdef", "ifndef", "elsif", "endif"].contains(word)) {
            Some("endif") => drop(open.pop()),
            Some(directive) => {
                if directive == "elsif" {
                    open.pop();
                }
                let asked = told.next().filter(|name| MACROS.contains(name));
                open.push(asked.map(|name| (number, name)));
            }
            None if makes_a_circuit(code) => {
                if let Some(chosen) = open.iter().flatten().next().copied().or(off) {
                    return Some(chosen);
                }
            }
            None => {}
        }
    }
    None
}

/// Whether a line is more than a check, a message or the end of something.
fn makes_a_circuit(code: &str) -> bool {
    if words(code).any(|word| DRIVERS.contains(&word)) || code.contains("<=") {
        return true;
    }
    let is_check = words(code).any(|word| CHECKS.contains(&word))
        || ["|->", "|=>"].iter().any(|arrow| code.contains(arrow));
    let code = code.trim_start();
    // A system task, a string, a clocking event, or what is left of a statement.
    let is_rest = !code.starts_with(|c: char| c.is_alphanumeric() || "_.`\\".contains(c));
    let is_part = words(code).next().is_none_or(|word| PARTS.contains(&word));
    !(is_check || is_rest || is_part)
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::found;

    #[test]
    fn what_tools_choose_differently_is_named() {
        let told = |text: &str| found(text).map(|(line, word)| format!("{line} {word}"));
        for (text, expected) in [
            ("a\n`ifdef SYNTHESIS\nassign b = c;\n`endif\n", Some("2 SYNTHESIS")),
            (
                "`ifdef A\n`endif\n`ifndef VERILATOR\nx\n`else\nq <= d;\n`endif\n",
                Some("3 VERILATOR"),
            ),
            (
                "// synthesis translate_off\nassign b = c;\n// synthesis translate_on\n",
                Some("1 translate_off"),
            ),
            ("case (a) // synthesis full_case\nendcase\n", Some("1 full_case")),
            // What simulation alone makes short, by a constant or a macro.
            (
                "`ifdef SYNTHESIS\nlocalparam LAST = 6;\n`else\nlocalparam LAST = 7;\n`endif\n",
                Some("1 SYNTHESIS"),
            ),
            ("`ifndef FORMAL\n`define LAST 7\n`endif\n", Some("1 FORMAL")),
            // An instance, a port of one, a wire, and Verilator's other names.
            ("`ifdef verilator\n  quick u_a (\n`endif\n", Some("1 verilator")),
            ("a u_a (\n`ifdef verilator3\n  .i_b(c),\n`endif\n);\n", Some("2 verilator3")),
            ("`ifdef MODEL_TECH\nwire a = b;\n`endif\n", Some("1 MODEL_TECH")),
            ("always @* begin\n`ifdef VCS\na = b;\n`endif\nend\n", Some("2 VCS")),
            // Checks alone, other macros, and what stands behind.
            ("`ifndef SYNTHESIS\ninitial $display(\"x\");\n`endif\nassign b = c;\n", None),
            (
                "// synthesis translate_off\ninitial $finish;\n// synthesis translate_on\nq <= d;\n",
                None,
            ),
            (
                "`ifdef FORMAL\nproperty held;\n  @(posedge i_clk) a |-> b;\nendproperty\n\
                 assert property (held);\n`endif\n",
                None,
            ),
            (
                "`ifndef SYNTHESIS\n`timescale 1ns/1ps\ninitial begin\n  if (A > 3)\n    \
                 $fatal(1, \"A\");\nend\n`endif\n",
                None,
            ),
            ("`ifdef ECP5\nassign b = c;\n`endif\n// assign in SYNTHESIS\n", None),
        ] {
            assert_eq!(told(text).as_deref(), expected, "{text}");
        }
    }
}

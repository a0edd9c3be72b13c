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
/// Words before a statement that are none of it.
const BEFORE: [&str; 6] = ["begin", "end", "else", "endfunction", "endtask", "endgenerate"];
/// Directives that choose nothing.
const SETTINGS: [&str; 5] =
    ["timescale", "default_nettype", "resetall", "celldefine", "endcelldefine"];

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
    let mut chosen = Chosen::default();
    for (number, line) in (1..).zip(text.lines()) {
        let (code, comment) = line.split_once("//").unwrap_or((line, ""));
        let of = |list: &'static [&str], text| words(text).find(|word| list.contains(word));
        let told = of(&PROMISES, comment).or_else(|| of(&PROMISES, code));
        if let Some(promise) = told {
            return Some((number, promise));
        }
        let choice = open.iter().flatten().next().copied().or(off);
        let (code, directive) = before_directive(code);
        let turned = of(&OFF, line).or(of(&ON, line));
        if choice.is_none() {
            chosen = Chosen::default();
        } else if chosen.takes(code) || (directive.or(turned).is_some() && chosen.ends()) {
            return choice;
        }
        if let Some(word) = turned {
            off = OFF.contains(&word).then_some((number, word));
        }
        match directive.unwrap_or("else") {
            "else" => {}
            "endif" => drop(open.pop()),
            directive => {
                if directive == "elsif" {
                    open.pop();
                }
                let asked = words(line).skip_while(|&word| word != directive).nth(1);
                let asked = asked.filter(|name| MACROS.contains(name));
                open.push(asked.map(|name| (number, name)));
            }
        }
    }
    None
}

/// A line's code up to a directive that begins or ends a choice, and that.
fn before_directive(code: &str) -> (&str, Option<&str>) {
    let directives = code.match_indices('`').filter_map(|(at, _)| {
        let word = words(&code[at..]).next()?;
        ["ifdef", "ifndef", "elsif", "else", "endif"].contains(&word).then_some((at, word))
    });
    directives.min().map_or((code, None), |(at, word)| (&code[..at], Some(word)))
}

/// A text that was chosen, statement by statement.
#[derive(Default)]
struct Chosen {
    /// What stands of the present one.
    statement: String,
    /// Parentheses that are open in it.
    depth: u32,
    /// Within a module that drives nothing outside: one that only checks.
    in_module: bool,
}

impl Chosen {
    /// Takes a line; whether a circuit is made of what is whole with it.
    fn takes(&mut self, code: &str) -> bool {
        if code.trim_start().starts_with('`') {
            return !self.in_module
                && words(code).next().is_some_and(|word| !SETTINGS.contains(&word));
        }
        for c in code.chars() {
            match c {
                '(' => self.depth += 1,
                ')' => self.depth = self.depth.saturating_sub(1),
                ';' if self.depth == 0 => {
                    if self.ends() {
                        return true;
                    }
                    continue;
                }
                _ => {}
            }
            self.statement.push(c);
        }
        self.statement.push(' ');
        false
    }

    /// Whether a circuit is made of the statement that ends here.
    fn ends(&mut self) -> bool {
        self.depth = 0;
        let statement = std::mem::take(&mut self.statement);
        let mut statement = statement.trim_start();
        if let Some((_, behind)) = statement.split_once("endmodule") {
            self.in_module = false;
            statement = behind.trim_start();
        }
        self.in_module |= words(statement).next() == Some("module");
        match self.in_module {
            true => words(statement).any(|word| ["output", "inout"].contains(&word)),
            false => makes_a_circuit(statement),
        }
    }
}

/// Whether a statement is more than a check, a message or the end of something.
fn makes_a_circuit(statement: &str) -> bool {
    if words(statement).any(|word| DRIVERS.contains(&word)) || statement.contains("<=") {
        return true;
    }
    let is_check = words(statement).any(|word| CHECKS.contains(&word))
        || ["|->", "|=>"].iter().any(|arrow| statement.contains(arrow));
    let begins_with = |word: &str| {
        statement
            .strip_prefix(word)
            .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
    };
    if let Some(word) = BEFORE.iter().find(|word| begins_with(word)) {
        return makes_a_circuit(statement[word.len()..].trim_start());
    }
    // What only prints, a loop of it or a branch, a system task, a clocking event, an instance
    // without ports.
    let is_part = ["initial", "final", "if", "for"].iter().any(|word| begins_with(word))
        || !statement.starts_with(|c: char| c.is_alphanumeric() || "_.\\".contains(c))
        || statement.split_whitespace().collect::<String>().ends_with("()");
    !(is_check || is_part)
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
            (
                "`ifdef SYNTHESIS\nmodule a(output b);\nb c(b);\nendmodule\n`endif\n",
                Some("1 SYNTHESIS"),
            ),
            (
                "`ifndef SYNTHESIS\ninitial $display(1);\nlocalparam LAST = 7;\n`endif\n",
                Some("1 SYNTHESIS"),
            ),
            // A module that only checks, and its instance.
            (
                "`ifndef SYNTHESIS\nmodule check #(\n  parameter A = 1\n) (input b);\n\
                 always @* c = b;\nlocalparam D = A;\nendmodule\n`endif\n",
                None,
            ),
            ("`ifndef SYNTHESIS\ncheck #(\n  .A(3),\n  .B(4)\n) u_check ();\n`endif\n", None),
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

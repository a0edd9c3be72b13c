//! Text of a design that other tools read and Verilator does not, or the other way round.
//!
//! Macros that tools define, and comments that synthesis obeys, choose what is read. What is
//! simulated is Verilator's choice.

use std::path::Path;

/// Macros that one tool or the other defines.
const MACROS: [&str; 4] = ["VERILATOR", "SYNTHESIS", "YOSYS", "__ICARUS__"];
/// Comments that take a text away from synthesis, or bring it back.
const OFF: [&str; 3] = ["translate_off", "synthesis_off", "synopsys_off"];
const ON: [&str; 3] = ["translate_on", "synthesis_on", "synopsys_on"];
/// Comments that synthesis takes for a promise.
const PROMISES: [&str; 2] = ["full_case", "parallel_case"];
/// Words that drive nets; what only checks or prints has none of them.
const DRIVERS: [&str; 4] = ["assign", "always", "always_ff", "always_comb"];

/// What is to be said of a file of which other tools may read another circuit.
pub(super) fn remark(file: &Path, text: &str) -> Option<String> {
    let (line, word) = found(text)?;
    Some(format!(
        "{}:{line}: {word} chooses: what other tools read of it was not simulated",
        file.display()
    ))
}

/// The line and the word that chooses a text with drivers.
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
            None if words(code).any(|word| DRIVERS.contains(&word)) || code.contains("<=") => {
                if let Some(chosen) = open.iter().flatten().next().copied().or(off) {
                    return Some(chosen);
                }
            }
            None => {}
        }
    }
    None
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
            // Checks alone, other macros, and what stands behind.
            ("`ifndef SYNTHESIS\ninitial $display(\"x\");\n`endif\nassign b = c;\n", None),
            (
                "// synthesis translate_off\ninitial $finish;\n// synthesis translate_on\nq <= d;\n",
                None,
            ),
            ("`ifdef ECP5\nassign b = c;\n`endif\n// assign in SYNTHESIS\n", None),
        ] {
            assert_eq!(told(text).as_deref(), expected, "{text}");
        }
    }
}

//! Verilog that the tools do not take, in the user's own terms.

use std::path::Path;
use std::process::ExitStatus;

use super::error::CosimError;
use super::source::{RTL, SourceFile, is_users};

/// A source's name as the tools see it, and as it stands in what they and the
/// model say.
pub(super) fn in_build(source: &SourceFile) -> String {
    format!("{RTL}/{}", source.name)
}

/// A tool's failure, or the refusal of the user's Verilog if that is to blame.
pub(super) fn rejection(error: CosimError, sources: &[SourceFile]) -> CosimError {
    let CosimError::ToolFailed { tool, status, output, .. } = &error else {
        return error;
    };
    let is_said = finds_fault(*status, output, |line| blames(line, sources));
    if !(is_users(sources) && is_said) {
        return error;
    }
    CosimError::Rejected { tool, output: in_users_terms(output, sources) }
}

/// Whether a tool that failed finds fault with what it was given, in a line for which
/// `blames` holds. One that was killed or broke down says nothing of it.
pub(super) fn finds_fault(status: ExitStatus, output: &str, blames: impl Fn(&str) -> bool) -> bool {
    status.code().is_some() && !output.contains("Internal Error") && output.lines().any(blames)
}

/// Whether a line of a tool says what is wrong with the Verilog: Verilator's names
/// its file. The C++ compiler sees only what `$c` and the like have put there.
fn blames(line: &str, sources: &[SourceFile]) -> bool {
    let puts_in_cpp = |text: &str| text.contains("$c") || text.contains("`systemc_");
    if line.starts_with("%Error") {
        return !line.contains("Cannot write") && !line.contains("Cannot open");
    }
    line.contains(" error: ") && sources.iter().any(|source| puts_in_cpp(&source.text))
}

/// A text of a tool or of the model, with the user's own file names.
pub(crate) fn in_users_terms(text: &str, sources: &[SourceFile]) -> String {
    let folder = format!("{RTL}/");
    let mut told = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(&folder) {
        let (before, after) = rest.split_at(at);
        told += before;
        let name = &after[folder.len()..];
        let is_part = before.ends_with(|c: char| c.is_alphanumeric() || "/._-".contains(c));
        let named = sources
            .iter()
            .filter(|source| !is_part && name.starts_with(&source.name))
            .max_by_key(|source| source.name.len());
        match named {
            Some(source) => {
                let origin = source.origin.as_deref().unwrap_or(Path::new(&source.name));
                told += &origin.display().to_string();
                rest = &name[source.name.len()..];
            }
            None => {
                told += &folder;
                rest = name;
            }
        }
    }
    told + rest
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::ExitStatusExt as _;

    use super::*;

    fn source(name: &str, origin: Option<&str>, text: &str) -> SourceFile {
        SourceFile { name: name.to_owned(), text: text.to_owned(), origin: origin.map(Into::into) }
    }

    #[test]
    fn file_names_are_the_users_own() {
        let sources = [
            source("a.v", Some("my/rtl/a.v"), ""),
            source("a.vh", Some("my/rtl/a.vh"), ""),
            source("b.v", None, ""),
        ];
        let told = |text| in_users_terms(text, &sources);
        assert_eq!(
            told("%Error: rtl/a.v:3:1: rtl/a.vh:1: rtl/b.v:7, other_rtl/a.v rtl/c.v"),
            "%Error: my/rtl/a.v:3:1: my/rtl/a.vh:1: b.v:7, other_rtl/a.v rtl/c.v"
        );
        assert_eq!(told("$finish at rtl/a.v:3"), "$finish at my/rtl/a.v:3");
    }

    #[test]
    fn a_tool_that_breaks_down_does_not_blame_the_verilog() {
        let users = source("a.v", Some("my/a.v"), "module a; initial $c(\"x\"); endmodule");
        let plain = source("a.v", Some("my/a.v"), "module a; endmodule");
        let ours = source("a.v", None, "");
        let is_rejected = |raw_status: i32, output: &str, source: &SourceFile| {
            let failed = CosimError::ToolFailed {
                tool: "a tool",
                command: String::new(),
                status: ExitStatus::from_raw(raw_status),
                output: output.to_owned(),
            };
            let error = rejection(failed, std::slice::from_ref(source));
            matches!(error, CosimError::Rejected { .. })
        };
        let syntax = "%Error: rtl/a.v:3:1: syntax error";
        let cpp = "Vsensor_top.cpp:3:1: error: 'x' was not declared";
        assert!(is_rejected(1 << 8, syntax, &users));
        assert!(is_rejected(1 << 8, syntax, &plain));
        assert!(!is_rejected(1 << 8, syntax, &ours));
        assert!(!is_rejected(9, syntax, &users));
        assert!(is_rejected(1 << 8, cpp, &users));
        assert!(!is_rejected(1 << 8, cpp, &plain));
        for broken in [
            "out of coffee",
            "%Error: Internal Error: rtl/a.v:3:1: ../V3Ast.cpp:1: this should not happen",
            "%Error: Cannot write ./Vsensor_top.h",
        ] {
            assert!(!is_rejected(1 << 8, broken, &users), "{broken}");
        }
    }
}

//! Which files of a folder a design needs.

use std::collections::HashSet;

use super::build::SourceFile;

/// The files that the module `top` needs, in their order: the one that declares
/// it, and those that declare what a needed file names. What only names others,
/// as a testbench does, is not among them. Files that declare nothing (macros) are
/// kept, and all of them when none declares `top`.
pub fn needed_by(top: &str, sources: Vec<SourceFile>) -> Vec<SourceFile> {
    let names: Vec<Names> = sources.iter().map(|file| Names::of(&file.text)).collect();
    let mut is_needed: Vec<bool> = names
        .iter()
        .map(|names| names.declared.contains(top))
        .collect();
    if !is_needed.contains(&true) {
        return sources;
    }
    let mut waiting: Vec<usize> = (0..names.len()).filter(|&i| is_needed[i]).collect();
    waiting.extend((0..names.len()).filter(|&i| names[i].declared.is_empty()));
    while let Some(user) = waiting.pop() {
        for (other, needed) in is_needed.iter_mut().enumerate() {
            if !*needed && !names[other].declared.is_disjoint(&names[user].all) {
                *needed = true;
                waiting.push(other);
            }
        }
    }
    let declares_nothing = names.iter().map(|names| names.declared.is_empty());
    let is_kept: Vec<bool> = is_needed
        .iter()
        .zip(declares_nothing)
        .map(|(&needed, nothing)| needed || nothing)
        .collect();
    let files = sources.into_iter().zip(is_kept);
    files
        .filter_map(|(file, kept)| kept.then_some(file))
        .collect()
}

/// The identifiers of a text.
#[derive(Default)]
struct Names<'t> {
    /// Every one of them, keywords included.
    all: HashSet<&'t str>,
    /// Modules, interfaces, packages, programs and primitives declared here.
    declared: HashSet<&'t str>,
}

impl<'t> Names<'t> {
    fn of(text: &'t str) -> Names<'t> {
        let mut names = Names::default();
        let mut declares = false;
        for name in identifiers(text) {
            names.all.insert(name);
            match name {
                "module" | "macromodule" | "interface" | "package" | "program" | "primitive" => {
                    declares = true;
                }
                "automatic" | "static" => {}
                _ if declares => {
                    names.declared.insert(name);
                    declares = false;
                }
                _ => {}
            }
        }
        names
    }
}

/// Identifiers and keywords, without those in comments and strings.
fn identifiers(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            let first = rest.chars().next()?;
            if first.is_ascii_alphabetic() || first == '_' {
                let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '$';
                return Some(take(&mut rest, |c| !is_part(c)));
            }
            if first == '\\' {
                // An escaped identifier goes on to the next space.
                return Some(take(&mut rest, char::is_whitespace).trim_start_matches('\\'));
            }
            if rest.starts_with("//") {
                take(&mut rest, |c| c == '\n');
            } else if let Some(comment) = rest.strip_prefix("/*") {
                rest = comment.split_once("*/").map_or("", |(_, after)| after);
            } else if first == '"' {
                rest = after_string(&rest[1..]);
            } else {
                rest = &rest[first.len_utf8()..];
            }
        }
    })
}

/// Cuts off what comes before a character that ends it.
fn take<'t>(rest: &mut &'t str, ends: impl Fn(char) -> bool) -> &'t str {
    let (taken, after) = rest.split_at(rest.find(ends).unwrap_or(rest.len()));
    *rest = after;
    taken
}

/// What follows a string whose first quotation mark has been read.
fn after_string(text: &str) -> &str {
    let mut is_escaped = false;
    for (at, c) in text.char_indices() {
        match c {
            '"' if !is_escaped => return &text[at + 1..],
            '\\' => is_escaped = !is_escaped,
            _ => is_escaped = false,
        }
    }
    ""
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(files: &[(&str, &str)]) -> Vec<String> {
        let files = files.iter().map(|(name, text)| SourceFile {
            name: (*name).to_owned(),
            text: (*text).to_owned(),
            origin: None,
        });
        let kept = needed_by("top", files.collect());
        kept.into_iter().map(|file| file.name).collect()
    }

    #[test]
    fn benches_and_strangers_are_not_needed() {
        let files = [
            ("a.v", "`include \"m.vh\"\nmodule top; b u_b(); endmodule"),
            ("b.v", "module automatic b; \\odd+name u(); endmodule"),
            ("m.vh", "`define WIDTH pkg::W"),
            ("odd.v", "module \\odd+name ; endmodule"),
            ("pkg.sv", "package pkg; endpackage"),
            (
                "tb.v",
                "module tb; top dut(); vectors u(); initial #10; endmodule",
            ),
            ("vectors.v", "module vectors; endmodule"),
        ];
        assert_eq!(kept(&files), ["a.v", "b.v", "m.vh", "odd.v", "pkg.sv"]);
    }

    #[test]
    fn comments_and_strings_name_nothing() {
        let files = [
            (
                "a.v",
                "// b\n/* c */ module top; initial $display(\"d \\\" e\"); endmodule",
            ),
            ("b.v", "module b; endmodule"),
            ("c.v", "module c; endmodule"),
            ("d.v", "module d; endmodule"),
            ("e.v", "module e; endmodule"),
        ];
        assert_eq!(kept(&files), ["a.v"]);
        assert_eq!(
            kept(&[("a.v", "/* module top;"), ("b.v", "\"module top")]).len(),
            2
        );
    }
}

//! The manifest of a folder of Verilog.

use std::path::{Component, Path};

use serde::Deserialize;

/// The part of a manifest that names the Verilog.
#[derive(Deserialize)]
struct Manifest {
    /// Name of the top module.
    #[serde(default)]
    top: Option<String>,
    files: Vec<String>,
    /// Its scan's counters.
    #[serde(default)]
    scan_registers: serde_json::Value,
}

/// What a manifest says of the Verilog.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NamedVerilog {
    /// The top module, if it names one.
    pub top: Option<String>,
    /// The file names, in its order.
    pub files: Vec<String>,
    /// The scan's counters, as `goldtof emit` names them; null if it names none.
    pub scan_registers: serde_json::Value,
}

/// Longest name of a top module: tools make names of files from it.
const MOST_TOP_CHARACTERS: usize = 100;

/// The file names under "files" of a manifest's text, its top module, and what it says
/// of counters.
///
/// # Errors
/// What is wrong with it and what would be right: every name must be that of a
/// file in the manifest's own folder, and occur once; the top module's must be a plain
/// identifier.
pub fn file_names(text: &str) -> Result<NamedVerilog, String> {
    let manifest: Manifest = serde_json::from_str(text).map_err(|error| {
        format!(
            "{error}; a manifest is what `goldtof emit` writes, with the file names under \"files\""
        )
    })?;
    let mut names = std::collections::HashSet::new();
    for name in &manifest.files {
        let mut components = Path::new(name).components();
        let is_plain = matches!(
            (components.next(), components.next()),
            (Some(Component::Normal(only)), None) if only == name.as_str()
        ) && !name.contains(char::is_control);
        if !is_plain {
            return Err(format!(
                "files holds {name:?}, which is not the name of a file in this folder; write names \
                 without a folder, as \"sensor_top.v\""
            ));
        }
        if !names.insert(name) {
            return Err(format!("files holds {name:?} twice; name each file once"));
        }
    }
    if let Some(top) = &manifest.top {
        check_top(top)?;
    }
    Ok(NamedVerilog {
        top: manifest.top,
        files: manifest.files,
        scan_registers: manifest.scan_registers,
    })
}

/// The name goes into command lines and C++.
pub(super) fn check_top(top: &str) -> Result<(), String> {
    let is_plain = top.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && top.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && top.len() <= MOST_TOP_CHARACTERS;
    if is_plain {
        return Ok(());
    }
    Err(format!(
        "the top module is {top:?}; write the name of a module: letters, digits and underscores, at most \
         {MOST_TOP_CHARACTERS}, as \"sensor_top\""
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_top_that_is_no_plain_name_is_refused() {
        let long = "a".repeat(101);
        for top in ["", "0a", "a b", "a;b", "--top", "a$b", "\u{e4}", &long] {
            let text = format!(r#"{{"top": "{top}", "files": ["a.v"]}}"#);
            let reason = file_names(&text).unwrap_err();
            assert!(reason.contains("the name of a module"), "{reason}");
        }
        let found = file_names(r#"{"top": "left_sensor_top", "files": []}"#).unwrap();
        assert_eq!(found.top.as_deref(), Some("left_sensor_top"));
        assert_eq!(file_names(r#"{"files": []}"#).unwrap().top, None);
    }

    #[test]
    fn the_names_come_in_their_order() {
        let text = r#"{"top": "t", "files": ["b.v", "a.sv"]}"#;
        assert_eq!(file_names(text).unwrap().files, ["b.v", "a.sv"]);
    }

    #[test]
    fn what_is_no_name_of_a_file_here_is_refused() {
        for name in ["", ".", "..", "../a.v", "/a.v", "a/b.v", "a.v/", "./a.v", "a\\u0000.v"] {
            let text = format!(r#"{{"files": ["{name}"]}}"#);
            let reason = file_names(&text).unwrap_err();
            assert!(reason.contains("not the name of a file"), "{reason}");
        }
        let twice = file_names(r#"{"files": ["a.v", "a.v"]}"#).unwrap_err();
        assert!(twice.contains("twice"), "{twice}");
        for text in ["", "[]", "{}", r#"{"files": 3}"#] {
            assert!(file_names(text).unwrap_err().contains("goldtof emit"));
        }
    }
}

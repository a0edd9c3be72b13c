//! Where a verilated model makes use of an x.
//!
//! Verilator has a variable for each x of an expression, which is the same for ever. It is made one
//! that notes when it is read, and that is not part of what the model holds: so processes with
//! other bits in these can be told to be in the same state until one of them is read.

use std::fs;
use std::path::Path;

use super::cache::write;
use super::error::CosimError;

/// Name of the header that the compiler includes before all others.
pub(super) const HEADER: &str = "undefined.h";
/// Its text.
pub(super) const TEXT: &str = include_str!("../../../testbench/undefined.h");
/// Changes with what this file does.
pub(super) const VERSION: &str = "1";
/// Name of the header that `testbench/cosim.cpp` includes.
const OF_MODEL: &str = "goldtof_x.h";

/// What is in the name of each variable for an x.
const OF_X: &str = "__Vxrand";
/// Types of those that fit a word; a wider one is left in what the model holds.
const TYPES: [&str; 4] = ["CData", "SData", "IData", "QData"];
/// What a model's text calls that holds more than can be told of its state: random numbers,
/// and files.
const OUTSIDE: [&str; 4] = ["VL_RANDOM", "VL_URANDOM", "VL_FOPEN", "VL_FREAD"];
/// What it calls for an x where it has no variable.
const DRAWN: &str = "RAND_RESET";

/// Marks the variables of the model of `top` in `folder`.
pub(super) fn mark(folder: &Path, top: &str) -> Result<(), CosimError> {
    let prefix = format!("V{top}");
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(CosimError::cache(folder))? {
        let path = entry.map_err(CosimError::cache(folder))?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if name.starts_with(&prefix) && (name.ends_with(".h") || name.ends_with(".cpp")) {
            let text = fs::read_to_string(&path).map_err(CosimError::cache(&path))?;
            files.push((path, name, text));
        }
    }
    let is_told = !files.iter().any(|(_, _, text)| OUTSIDE.iter().any(|call| text.contains(call)));
    // What is slow is done once, before the first clock.
    let is_drawn = |name: &str, text: &str| {
        !name.contains("Slow") && name.ends_with(".cpp") && text.contains(DRAWN)
    };
    let mut may_read = files.iter().any(|(_, name, text)| is_drawn(name, text));
    for (path, name, text) in &files {
        if is_told && name.ends_with(".h") && text.contains(OF_X) {
            may_read = true;
            let marked: Vec<String> = text.lines().map(marked).collect();
            write(path, &(marked.join("\n") + "\n"))?;
        }
    }
    write(&folder.join(OF_MODEL), &format!("constexpr bool GOLDTOF_MAY_READ_X = {may_read};\n"))
}

/// A line of a header, where it declares a variable for an x with another type.
fn marked(line: &str) -> String {
    let start = line.trim_start();
    let of =
        TYPES.iter().find(|of| start.strip_prefix(*of).is_some_and(|rest| rest.starts_with("/*")));
    match of {
        Some(of) if line.contains(OF_X) && !line.contains('(') => {
            line.replacen(of, &format!("GoldtofX<{of}>"), 1)
        }
        _ => line.to_owned(),
    }
}

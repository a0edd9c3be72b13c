//! Somebody's own Verilog: which files it is, and what the tools make of it.
//!
//! Simulators agree on how a design is named (`-f` lists, `-y`, `-v`, `+incdir+`,
//! `+define+`), so that is how it is named here. Which file declares a module is left to
//! Verilator, whose parser will read the design anyway: another reader of Verilog beside
//! it, ours or a crate's, would only add cases in which the two disagree. What Verilator
//! took is then preprocessed into one text, so that all that follows (identity of a build,
//! lock-step, Yosys) sees the same design and needs neither folders nor macros.

mod design;
mod filelist;
mod folder;
#[doc(hidden)]
pub mod manifest;
mod preprocessed;
mod roots;
mod search;
mod wrapper;

use std::path::PathBuf;

pub use self::design::read;

use super::error::CosimError;
use super::source::SourceFile;
use crate::rtl::blocks::ScanRegisters;

/// Verilog of one's own, as simulators are told of it.
#[derive(Debug, Clone, Default)]
pub struct OwnRtl {
    /// A folder: the files that a `manifest.json` there names, or else those of it and
    /// its subfolders that the top module needs.
    pub folder: Option<PathBuf>,
    /// Lists of files and options, as simulators take them with `-f`.
    pub file_lists: Vec<PathBuf>,
    /// The top module; none for `sensor_top`.
    pub top: Option<String>,
    /// Folders in which included files are looked for, before all others.
    pub include_folders: Vec<PathBuf>,
    /// Macros: `NAME` or `NAME=VALUE`.
    pub defines: Vec<String>,
}

impl OwnRtl {
    /// The Verilog of a folder.
    pub fn folder(path: impl Into<PathBuf>) -> OwnRtl {
        OwnRtl { folder: Some(path.into()), ..OwnRtl::default() }
    }
}

/// A design that is ready to be built.
pub struct OwnDesign {
    /// The module with exactly the interface's ports.
    pub top: String,
    /// Its text, and the files that the tools may speak of.
    pub sources: Vec<SourceFile>,
    /// The scan's counters, if a manifest names them as those of the emitted design.
    pub registers: Option<ScanRegisters>,
    /// What was ignored or assumed.
    pub remarks: Vec<String>,
}

/// What the user named, before any tool has seen it.
#[derive(Debug, Default)]
struct Named {
    /// Files that are compiled.
    files: Vec<PathBuf>,
    /// Files of which only what is needed is taken (`-v`).
    libraries: Vec<PathBuf>,
    /// Folders in which a module `m` is looked for as `m.v` or `m.sv` (`-y`).
    module_folders: Vec<PathBuf>,
    /// Folders in which included files are looked for.
    include_folders: Vec<PathBuf>,
    /// Endings of the files in `module_folders`, beside `.v` and `.sv` (`+libext+`).
    endings: Vec<String>,
    /// Macros: `NAME` or `NAME=VALUE`.
    defines: Vec<String>,
    /// What is looked through for modules, file by file.
    searched: Vec<PathBuf>,
    /// What was ignored.
    remarks: Vec<String>,
}

/// Whether a text is a plain identifier.
fn is_identifier(text: &str) -> bool {
    let mut characters = text.chars();
    characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && characters.all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '$'))
}

/// Refuses a macro that is no macro.
fn check_define(define: &str) -> Result<(), String> {
    let (name, value) = define.split_once('=').unwrap_or((define, ""));
    if !is_identifier(name) {
        return Err(format!(
            "{define:?} defines no macro; write NAME or NAME=VALUE, NAME of letters, digits and _"
        ));
    }
    if value.contains(crate::printable::is_unprintable) {
        return Err(format!("the value of {name} holds a character that cannot be seen"));
    }
    Ok(())
}

/// An option of the command line that cannot be meant.
fn bad_option(option: &'static str, reason: String) -> CosimError {
    CosimError::Option { option, reason }
}

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
mod other_text;
mod preprocessed;
mod roots;
mod search;
mod wrapper;

use std::path::PathBuf;

pub use self::design::{read, read_board};

use super::error::CosimError;

/// Verilog to check in place of the emitted one, as simulators are told of it.
#[derive(Debug, Clone, Default, PartialEq, clap::Args)]
#[command(group = clap::ArgGroup::new("own").args(["folder", "file_lists"]).multiple(true))]
pub struct OwnRtl {
    /// Folder with Verilog to check in place of the emitted one, with the same ports. Its
    /// files are those that a manifest.json there lists, else those below it that the top
    /// module needs, for example --rtl my_rtl
    #[arg(long = "rtl", value_name = "DIR")]
    pub folder: Option<PathBuf>,
    /// File list of the Verilog to check, as for the option -f of simulators; may be
    /// repeated. Paths are relative to the list's folder, for example
    /// --filelist my_rtl/files.f
    #[arg(long = "filelist", value_name = "FILE")]
    pub file_lists: Vec<PathBuf>,
    /// Top module of the Verilog to check, for example --top my_top [default: sensor_top]
    #[arg(long, value_name = "NAME", requires = "own")]
    pub top: Option<String>,
    /// Folder to search first for included files; may be repeated, for example
    /// --include my_rtl/include
    #[arg(short = 'I', long = "include", value_name = "DIR", requires = "own")]
    pub include_folders: Vec<PathBuf>,
    /// Macro to define for the Verilog to check; may be repeated, for example
    /// --define WIDTH=8
    #[arg(short = 'D', long = "define", value_name = "NAME[=VALUE]", requires = "own")]
    pub defines: Vec<String>,
}

impl OwnRtl {
    /// The Verilog of a folder.
    pub fn folder(path: impl Into<PathBuf>) -> OwnRtl {
        OwnRtl { folder: Some(path.into()), ..OwnRtl::default() }
    }

    /// Whether any Verilog is named; else the emitted one is meant.
    pub fn is_given(&self) -> bool {
        self.folder.is_some() || !self.file_lists.is_empty()
    }
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
    /// What Verilator is told beside.
    flags: Vec<&'static str>,
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

/// Refuses a macro that is not a macro.
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

//! Verilog to be built.

use std::path::PathBuf;

use crate::deliver::EmittedFile;

/// Folder of the Verilog in that of a build.
pub(super) const RTL: &str = "rtl";

/// One file of Verilog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFile {
    /// File name without folder.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Where it was read; none of what was made here.
    pub origin: Option<PathBuf>,
}

impl SourceFile {
    /// Whether a file of this name is compiled by itself: `.v` and `.sv`, and not a
    /// header.
    pub fn is_compiled(&self) -> bool {
        self.name.ends_with(".v") || self.name.ends_with(".sv")
    }
}

/// Whether the Verilog is the user's own.
pub fn is_users(sources: &[SourceFile]) -> bool {
    sources.iter().any(|source| source.origin.is_some())
}

/// The Verilog of an emitted design.
pub fn sources_of(files: &[EmittedFile]) -> Vec<SourceFile> {
    files
        .iter()
        .map(|file| SourceFile { name: file.name.clone(), text: file.text.clone(), origin: None })
        .collect()
}

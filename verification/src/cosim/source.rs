//! Verilog to be built.

use std::path::PathBuf;

use super::TOP;
use super::cache::cache_dir;
use super::error::CosimError;
use crate::deliver::EmittedFile;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::Sensor;

/// Folder of the Verilog in that of a build.
pub(super) const RTL: &str = "rtl";

/// The Verilog of a design, ready to be built.
#[derive(Debug, Clone)]
pub struct Verilog {
    /// Its top module, with exactly the interface's ports.
    pub top: String,
    /// Its text, and the files that the tools may speak of.
    pub sources: Vec<SourceFile>,
    /// The scan's counters in it, if they may be moved on: with them the adversary shortens
    /// steps and scans.
    pub registers: Option<ScanRegisters>,
    /// Where its built models are kept.
    pub cache: PathBuf,
}

impl Verilog {
    /// What was emitted for a sensor, without a prefix.
    ///
    /// # Errors
    /// When there is no place for built models.
    pub fn emitted(sensor: &Sensor, files: &[EmittedFile]) -> Result<Verilog, CosimError> {
        Ok(Verilog {
            top: TOP.to_owned(),
            sources: sources_of(files),
            registers: Some(ScanRegisters::of(sensor.interface())),
            cache: cache_dir()?,
        })
    }

    /// Whether it is the user's own.
    pub fn is_users(&self) -> bool {
        is_users(&self.sources)
    }
}

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

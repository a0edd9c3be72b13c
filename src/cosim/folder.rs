//! Reads a folder of somebody's Verilog.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::Path;

use super::TOP;
use super::build::SourceFile;
use super::error::CosimError;
use super::manifest::{Named, file_names};
use super::needed::needed_by;
use crate::files::read_regular;
use crate::printable::is_unprintable;
use crate::rtl::back::Prefix;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::interface::Interface;

/// Largest file of Verilog, and largest manifest, that is read.
const MOST_BYTES: u64 = 64 << 20;
/// Most of Verilog in all: what a folder of one sensor never has.
const MOST_MIB_IN_ALL: u64 = 256;
/// Verilog, and what it may include.
const ENDINGS: [&str; 4] = [".v", ".sv", ".vh", ".svh"];

/// The Verilog of a folder.
pub struct FolderRtl {
    /// Its top module: the one that its manifest names, or else [`TOP`].
    pub top: String,
    /// Its files.
    pub sources: Vec<SourceFile>,
    /// The scan's counters, as its manifest names them.
    registers: serde_json::Value,
}

impl FolderRtl {
    /// The scan's counters, if the manifest names those that a design emitted for
    /// `interface` has.
    pub fn registers(&self, interface: &Interface) -> Option<ScanRegisters> {
        let registers = ScanRegisters::of(interface);
        let is_named = serde_json::to_value(&registers).is_ok_and(|named| named == self.registers);
        let prefix = match self.top.strip_suffix(TOP)? {
            "" => Prefix::default(),
            prefix => prefix.parse().ok()?,
        };
        is_named.then(|| registers.in_design_of(&prefix))
    }
}

/// Reads the files that `DIR/manifest.json` names and its top module, or those of the folder that
/// the top module needs, in the order of their names: a testbench among them is left
/// out.
///
/// # Errors
/// When the folder or a file cannot be read, or there is no Verilog in it.
pub fn read(folder: &Path) -> Result<FolderRtl, CosimError> {
    let named = manifest(folder)?;
    let has_manifest = named.is_some();
    let Named {
        top,
        files: names,
        scan_registers: registers,
    } = match named {
        Some(named) => named,
        None => Named {
            files: listing(folder)?,
            ..Named::default()
        },
    };
    let mut sources = Vec::new();
    let mut bytes = 0;
    for name in names {
        if !ENDINGS.iter().any(|ending| name.ends_with(ending)) {
            continue;
        }
        check_name(folder, &name)?;
        let path = folder.join(&name);
        let text = read_file(&path)?;
        bytes += text.len() as u64;
        if bytes > MOST_MIB_IN_ALL << 20 {
            return Err(CosimError::TooMuchVerilog {
                folder: folder.to_owned(),
                most_mib: MOST_MIB_IN_ALL,
            });
        }
        sources.push(SourceFile {
            name,
            text,
            origin: Some(path),
        });
    }
    if !sources.iter().any(SourceFile::is_compiled) {
        return Err(CosimError::NoVerilog(folder.to_owned()));
    }
    let sources = if has_manifest {
        sources
    } else {
        needed_by(TOP, sources)
    };
    Ok(FolderRtl {
        top: top.unwrap_or_else(|| TOP.to_owned()),
        sources,
        registers,
    })
}

fn manifest(folder: &Path) -> Result<Option<Named>, CosimError> {
    let path = folder.join("manifest.json");
    if !path.exists() {
        return Ok(None);
    }
    let names = file_names(&read_file(&path)?);
    names
        .map(Some)
        .map_err(|reason| CosimError::Manifest { path, reason })
}

/// Reads a file, but neither a folder nor a pipe that nobody may ever fill.
fn read_file(path: &Path) -> Result<String, CosimError> {
    read_regular(path, MOST_BYTES).map_err(unreadable(path))
}

/// The names in a folder. One that a tool would not take for a name is refused.
fn listing(folder: &Path) -> Result<Vec<String>, CosimError> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable(folder))? {
        let name = entry.map_err(unreadable(folder))?.file_name();
        match name.into_string() {
            Ok(name) => names.push(name),
            Err(name) => {
                let bytes = name.as_encoded_bytes();
                if ENDINGS.iter().any(|end| bytes.ends_with(end.as_bytes())) {
                    return Err(file_name(folder, name, "it is not UTF-8"));
                }
            }
        }
    }
    names.retain(|name| ENDINGS.iter().any(|ending| name.ends_with(ending)));
    names.sort();
    Ok(names)
}

/// Names go into command lines, C++ strings and messages.
fn check_name(folder: &Path, name: &str) -> Result<(), CosimError> {
    let reason = if name.contains(is_unprintable) {
        "it holds a character that cannot be seen"
    } else if name.contains(['"', '\\']) {
        "it holds a quotation mark or a backslash"
    } else {
        return Ok(());
    };
    Err(file_name(folder, name.into(), reason))
}

fn file_name(folder: &Path, name: OsString, reason: &'static str) -> CosimError {
    CosimError::FileName {
        folder: folder.to_owned(),
        name,
        reason,
    }
}

fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> CosimError {
    |source| CosimError::Unreadable {
        path: path.to_owned(),
        source,
    }
}

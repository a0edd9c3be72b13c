//! What a folder of Verilog holds.

use std::collections::HashSet;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use super::Named;
use super::manifest::{NamedVerilog as Manifest, file_names};
use crate::cosim::error::CosimError;
use crate::files::read_regular;

/// Largest file of Verilog, and largest manifest, that is read.
const MOST_BYTES: u64 = 64 << 20;
/// Most of Verilog in all: what a folder of one sensor never has.
const MOST_MIB_IN_ALL: u64 = 256;
/// Most files and folders that are looked at.
const MOST_ENTRIES: usize = 100_000;
/// Files that are compiled; all others are there to be included.
const ENDINGS: [&str; 2] = [".v", ".sv"];

/// Adds what a folder holds: the files that its manifest names, or else all files of it
/// and its subfolders, to be searched. Gives what a manifest says.
///
/// # Errors
/// When the folder or its manifest cannot be read, or there is no Verilog in it.
pub fn read(folder: &Path, named: &mut Named) -> Result<Manifest, CosimError> {
    let path = folder.join("manifest.json");
    if !path.exists() {
        search(folder, named)?;
        return Ok(Manifest::default());
    }
    let text = read_regular(&path, MOST_BYTES).map_err(unreadable(&path))?;
    let manifest = file_names(&text).map_err(|reason| CosimError::Manifest { path, reason })?;
    let compiled = manifest.files.iter().filter(|name| is_compiled(name));
    let files: Vec<PathBuf> = compiled.map(|name| folder.join(name)).collect();
    if files.is_empty() {
        return Err(CosimError::NoVerilog(folder.to_owned()));
    }
    check_size(folder, &files)?;
    named.files.extend(files);
    named.include_folders.push(folder.to_owned());
    Ok(manifest)
}

/// Adds all files of a folder and its subfolders, the folder's own first, by name.
pub(super) fn search(folder: &Path, named: &mut Named) -> Result<(), CosimError> {
    let mut files = Vec::new();
    let mut seen = HashSet::new();
    let mut waiting = vec![folder.to_owned()];
    let mut entries = 0;
    while let Some(present) = waiting.pop() {
        let found = fs::metadata(&present).map_err(unreadable(&present))?;
        // A link may lead back to where it stands.
        if !seen.insert((found.dev(), found.ino())) {
            continue;
        }
        let (names, mut folders) = listing(&present, &mut entries)?;
        if entries > MOST_ENTRIES {
            return Err(too_much(folder));
        }
        files.extend(names);
        named.include_folders.push(present);
        // The next to be taken is the last.
        folders.sort_by(|a, b| b.cmp(a));
        waiting.append(&mut folders);
    }
    if files.is_empty() {
        return Err(CosimError::NoVerilog(folder.to_owned()));
    }
    check_size(folder, &files)?;
    named.searched.extend(files);
    Ok(())
}

/// The Verilog and the folders in a folder. What is hidden is nobody's design.
fn listing(folder: &Path, entries: &mut usize) -> Result<(Vec<PathBuf>, Vec<PathBuf>), CosimError> {
    let (mut files, mut folders) = (Vec::new(), Vec::new());
    for entry in fs::read_dir(folder).map_err(unreadable(folder))? {
        let entry = entry.map_err(unreadable(folder))?;
        let (name, path) = (entry.file_name(), entry.path());
        *entries += 1;
        let bytes = name.as_encoded_bytes();
        if bytes.starts_with(b".") {
            continue;
        }
        let is_verilog = ENDINGS.iter().any(|end| bytes.ends_with(end.as_bytes()));
        // A link that leads nowhere is a file that cannot be read.
        let is_folder = fs::metadata(&path).is_ok_and(|found| found.is_dir());
        match (is_verilog, is_folder) {
            (true, false) if name.to_str().is_none() => {
                return Err(not_text(folder, name));
            }
            (true, false) => files.push(path),
            (_, true) => folders.push(path),
            (false, false) => {}
        }
    }
    files.sort();
    Ok((files, folders))
}

fn is_compiled(name: &str) -> bool {
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}

/// Refuses what a tool would choke on: more than anyone's sensor has, and what is no
/// regular file.
pub(super) fn check_size(folder: &Path, files: &[PathBuf]) -> Result<(), CosimError> {
    let mut bytes = 0;
    for file in files {
        let found = fs::metadata(file).map_err(unreadable(file))?;
        if !found.is_file() {
            let error = io::Error::other("it is not a regular file");
            return Err(unreadable(file)(error));
        }
        fs::File::open(file).map_err(unreadable(file))?;
        if found.len() > MOST_BYTES {
            let error = io::Error::new(
                io::ErrorKind::FileTooLarge,
                format!("it has more than {} MiB, the most that is read", MOST_BYTES >> 20),
            );
            return Err(unreadable(file)(error));
        }
        bytes += found.len();
    }
    if bytes > MOST_MIB_IN_ALL << 20 {
        return Err(too_much(folder));
    }
    Ok(())
}

fn too_much(folder: &Path) -> CosimError {
    CosimError::TooMuchVerilog { folder: folder.to_owned(), most_mib: MOST_MIB_IN_ALL }
}

fn not_text(folder: &Path, name: OsString) -> CosimError {
    CosimError::FileName { folder: folder.to_owned(), name, reason: "it is not UTF-8" }
}

fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> CosimError {
    |source| CosimError::Unreadable { path: path.to_owned(), source }
}

//! Reads the Verilog of `--rtl DIR`.

use std::fs;
use std::io;
use std::path::Path;

use crate::cosim::build::SourceFile;
use crate::cosim::error::CosimError;
use crate::cosim::manifest::file_names;
use crate::files::read_text;

/// Largest file of Verilog, and largest manifest, that is read.
const MOST_BYTES: u64 = 64 << 20;

/// Reads the files that `DIR/manifest.json` names, or every .v and .sv file of
/// the folder, in the order of their names.
///
/// # Errors
/// When the folder or a file cannot be read, or there is no Verilog in it.
pub(super) fn read(folder: &Path) -> Result<Vec<SourceFile>, CosimError> {
    let names = match manifest(folder)? {
        Some(names) => names,
        None => listing(folder)?,
    };
    let sources: Vec<SourceFile> = names
        .into_iter()
        .filter(|name| name.ends_with(".v") || name.ends_with(".sv"))
        .map(|name| {
            let text = read_file(&folder.join(&name))?;
            Ok(SourceFile { name, text })
        })
        .collect::<Result<_, CosimError>>()?;
    if sources.is_empty() {
        return Err(CosimError::NoVerilog(folder.to_owned()));
    }
    Ok(sources)
}

fn manifest(folder: &Path) -> Result<Option<Vec<String>>, CosimError> {
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
    let text = fs::metadata(path).and_then(|found| {
        if found.is_file() {
            read_text(path, MOST_BYTES)
        } else {
            Err(io::Error::other("it is not a regular file"))
        }
    });
    text.map_err(unreadable(path))
}

fn listing(folder: &Path) -> Result<Vec<String>, CosimError> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .map_err(unreadable(folder))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    Ok(names)
}

fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> CosimError {
    |source| CosimError::Unreadable {
        path: path.to_owned(),
        source,
    }
}

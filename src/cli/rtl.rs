//! Reads the Verilog of `--rtl DIR`.

use std::fs;
use std::io;
use std::path::Path;

use crate::cosim::TOP;
use crate::cosim::build::SourceFile;
use crate::cosim::error::CosimError;
use crate::cosim::manifest::file_names;
use crate::cosim::needed::needed_by;
use crate::files::read_regular;
use crate::printable::is_unprintable;

/// Largest file of Verilog, and largest manifest, that is read.
const MOST_BYTES: u64 = 64 << 20;
/// Verilog, and what it may include.
const ENDINGS: [&str; 4] = [".v", ".sv", ".vh", ".svh"];

/// Reads the files that `DIR/manifest.json` names, or those of the folder that
/// the top module needs, in the order of their names: a bench among them is left
/// out.
///
/// # Errors
/// When the folder or a file cannot be read, or there is no Verilog in it.
pub(super) fn read(folder: &Path) -> Result<Vec<SourceFile>, CosimError> {
    let named = manifest(folder)?;
    let has_manifest = named.is_some();
    let names = match named {
        Some(names) => names,
        None => listing(folder)?,
    };
    let sources: Vec<SourceFile> = names
        .into_iter()
        .filter(|name| ENDINGS.iter().any(|ending| name.ends_with(ending)))
        .map(|name| {
            let text = read_file(&folder.join(&name))?;
            Ok(SourceFile { name, text })
        })
        .collect::<Result<_, CosimError>>()?;
    if !sources.iter().any(SourceFile::is_compiled) {
        return Err(CosimError::NoVerilog(folder.to_owned()));
    }
    Ok(if has_manifest {
        sources
    } else {
        needed_by(TOP, sources)
    })
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
    read_regular(path, MOST_BYTES).map_err(unreadable(path))
}

/// The names in a folder. One that a tool would not take for a name is refused.
fn listing(folder: &Path) -> Result<Vec<String>, CosimError> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .map_err(unreadable(folder))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.retain(|name| ENDINGS.iter().any(|ending| name.ends_with(ending)));
    if let Some(name) = names.iter().find(|name| name.contains(is_unprintable)) {
        let reason = "its name has characters that cannot be seen; rename it";
        return Err(unreadable(&folder.join(name))(io::Error::other(reason)));
    }
    names.sort();
    Ok(names)
}

fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> CosimError {
    |source| CosimError::Unreadable {
        path: path.to_owned(),
        source,
    }
}

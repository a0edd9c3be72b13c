//! Reads the Verilog of `--rtl DIR`.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::cosim::build::SourceFile;
use crate::cosim::error::CosimError;

/// The part of a manifest that matters here.
#[derive(Deserialize)]
struct Manifest {
    files: Vec<String>,
}

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
            let path = folder.join(&name);
            let text = fs::read_to_string(&path).map_err(CosimError::file(&path))?;
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
    let wrong = |reason: String| CosimError::Manifest {
        path: path.clone(),
        reason,
    };
    let text = fs::read_to_string(&path).map_err(CosimError::file(&path))?;
    let manifest: Manifest = serde_json::from_str(&text).map_err(|error| {
        wrong(format!(
            "{error}; a manifest is what `goldtof emit` writes, with the file names under \"files\""
        ))
    })?;
    for name in &manifest.files {
        if Path::new(name).components().count() != 1 || name == ".." {
            return Err(wrong(format!(
                "files holds {name:?}, which is not the name of a file in this folder"
            )));
        }
    }
    Ok(Some(manifest.files))
}

fn listing(folder: &Path) -> Result<Vec<String>, CosimError> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .map_err(CosimError::file(folder))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    Ok(names)
}

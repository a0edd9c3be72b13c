//! Emitted files on disk, whole or not at all.

use std::fs;
use std::path::Path;

use super::emission::Emission;
use super::error::HdlError;

const MANIFEST: &str = "manifest.json";

/// Writes the design, what goes with it, then `manifest.json`, into `folder`.
///
/// Each file is written under another name and renamed, the manifest last, so
/// that a folder with a manifest has all that it names. Verilog files of the
/// design that an older manifest names and this one does not are removed; the
/// other files have the same names for every scene.
pub fn write(emission: &Emission, folder: &Path) -> Result<(), HdlError> {
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    let manifest_path = folder.join(MANIFEST);
    let old_files = files_of_manifest(&manifest_path);
    if manifest_path.exists() {
        fs::remove_file(&manifest_path).map_err(|error| failed(&manifest_path, error))?;
    }
    for file in emission.files.iter().chain(emission.flow.files()) {
        write_whole(&folder.join(&file.name), &file.text)?;
    }
    for stale in old_files {
        let path = folder.join(&stale);
        let is_plain_name = !stale.contains(['/', '\\']) && stale.ends_with(".v");
        if is_plain_name && path.is_file() && !emission.files.iter().any(|f| f.name == stale) {
            fs::remove_file(&path).map_err(|error| failed(&path, error))?;
        }
    }
    let mut manifest = serde_json::to_string_pretty(emission)
        .map_err(|error| failed(&manifest_path, error.into()))?;
    manifest.push('\n');
    write_whole(&manifest_path, &manifest)
}

fn failed(path: &Path, error: std::io::Error) -> HdlError {
    HdlError::Write {
        path: path.to_owned(),
        error,
    }
}

fn write_whole(path: &Path, text: &str) -> Result<(), HdlError> {
    let partial = path.with_extension(format!("partial-{}", std::process::id()));
    let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, path));
    written.map_err(|error| {
        // Nothing half-written stays; the first error is the one to report.
        let _ = fs::remove_file(&partial);
        failed(path, error)
    })
}

/// Names of the files in a manifest; none if there is no readable one.
fn files_of_manifest(path: &Path) -> Vec<String> {
    let Ok(text) = fs::read_to_string(path) else {
        return Vec::new();
    };
    let Ok(manifest) = serde_json::from_str::<serde_json::Value>(&text) else {
        return Vec::new();
    };
    manifest["files"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|file| Some(file.as_str()?.to_owned()))
        .collect()
}

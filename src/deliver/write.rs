//! Emitted files on disk, whole or not at all.

use std::fs;
use std::path::Path;

use super::emission::Emission;
use super::error::HdlError;
use super::formal::Formal;
use crate::files::{FileError, OutputFolder, Staged, read_regular};

const MANIFEST: &str = "manifest.json";
/// Largest manifest that is read.
const MOST_MANIFEST_BYTES: u64 = 16 << 20;

/// Writes the design, what goes with it, then `manifest.json`, into the folder
/// `folder`, which is made when missing; waits while another run writes there.
///
/// All files are complete under hidden names before the first gets its name, so
/// a full disk leaves an older design as it was. The older manifest goes before
/// that and the new one comes last: a folder with a manifest has all that it
/// names. Verilog files of the design that an older manifest names and this one
/// does not are removed; the other files have the same names for every scene.
///
/// # Errors
/// When a file cannot be written.
pub fn write(emission: &Emission, folder: &Path) -> Result<(), HdlError> {
    write_into(emission, &OutputFolder::open(folder, |_| ())?)
}

/// [`write()`] into a folder that is open.
///
/// # Errors
/// When a file cannot be written.
pub fn write_into(emission: &Emission, folder: &OutputFolder) -> Result<(), HdlError> {
    let stage_text =
        |name: &str, text: &str| folder.stage(name, |out| out.write_all(text.as_bytes()));
    let mut manifest =
        serde_json::to_string_pretty(&emission.document()).map_err(HdlError::Manifest)?;
    manifest.push('\n');
    let staged = emission
        .files
        .iter()
        .chain(emission.flow.files())
        .map(|file| stage_text(&file.name, &file.text))
        .collect::<Result<Vec<Staged>, FileError>>()?;
    let manifest = stage_text(MANIFEST, &manifest)?;
    let formal = folder.subfolder(Formal::FOLDER, |_| ())?;
    let proofs = emission
        .formal
        .files()
        .map(|file| formal.stage(&file.name, |out| out.write_all(file.text.as_bytes())))
        .collect::<Result<Vec<Staged>, FileError>>()?;
    for file in staged.iter().chain(&proofs).chain([&manifest]) {
        file.sync()?;
    }

    let stale = stale_files(emission, &folder.join(MANIFEST));
    // The older manifest must not come back after a power cut, among newer files.
    folder.remove(MANIFEST)?;
    folder.sync()?;
    folder.publish(staged)?;
    formal.publish(proofs)?;
    for name in stale {
        folder.remove(&name)?;
    }
    Ok(folder.publish(vec![manifest])?)
}

/// Verilog files of the older manifest's design that the new one has not.
fn stale_files(emission: &Emission, older_manifest: &Path) -> Vec<String> {
    let Ok(text) = read_regular(older_manifest, MOST_MANIFEST_BYTES) else {
        return Vec::new();
    };
    let Ok(manifest) = serde_json::from_str::<serde_json::Value>(&text) else {
        return Vec::new();
    };
    let is_stale = |name: &str| {
        let is_plain_name = !name.contains(['/', '\\']) && name.ends_with(".v");
        is_plain_name && !emission.files.iter().any(|file| file.name == name)
    };
    manifest["files"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|file| file.as_str())
        .filter(|name| is_stale(name) && is_file(&older_manifest.with_file_name(name)))
        .map(str::to_owned)
        .collect()
}

fn is_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
}

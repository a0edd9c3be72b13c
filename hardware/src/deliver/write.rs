//! Emitted files on disk, whole or not at all.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use super::board::BOARD;
use super::design::EmittedFile;
use super::emission::Emission;
use super::error::HdlError;
use super::formal::Formal;
use crate::files::{FileError, OutputFolder, Staged, read_regular, sync_all};

const MANIFEST: &str = "manifest.json";
/// Where a manifest names the files of its folder.
const FILES: &[&str] = &[
    "/files",
    "/testbench/files",
    "/testbench/file_list",
    "/testbench/vectors",
    "/constraints/sdc",
    "/constraints/lpf",
    "/constraints/xdc",
    "/header",
    "/vhdl",
    "/file_list",
    "/core",
];
/// Where it names those of the folder with the proofs.
const PROOFS: &[&str] = &[
    "/formal/properties",
    "/formal/emptied",
    "/formal/registers",
    "/formal/script",
    "/formal/abc",
];
/// Where it names those of the folder with a board's project.
const PROJECT: &[&str] = &["/board/files"];
/// Endings of all of them, and the name of the one that has none.
const ENDINGS: &[&str] = &[
    "v", "vh", "vhd", "sv", "f", "hex", "sdc", "lpf", "xdc", "core", "sby", "sh", "cst", "pcf",
    "tcl", "cpp", "h", "toml",
];
const MAKEFILE: &str = "Makefile";
/// Largest manifest that is read.
const MOST_MANIFEST_BYTES: u64 = 16 << 20;

/// Writes the design, what goes with it, then `manifest.json`, into the folder
/// `folder`, which is made when missing; waits while another run writes there.
///
/// All files are complete under hidden names before the first gets its name, so
/// a full disk leaves an older design as it was. The older manifest goes before
/// that and the new one comes last: a folder with a manifest has all that it
/// names. Files that an older manifest names and this one does not are removed;
/// files that stand there as they are to be keep their times.
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
    let mut manifest =
        serde_json::to_string_pretty(&emission.document()).map_err(HdlError::Manifest)?;
    manifest.push('\n');
    let own: Vec<&EmittedFile> = emission.files.iter().chain(emission.flow.files()).collect();
    let staged = stage_changed(folder, &own)?;
    let changed_manifest = folder.stage_changed(MANIFEST, &manifest)?;
    let older = older_manifest(folder);
    let own_stale = stale(&older, FILES, &own, folder.path());
    let mut beside = Vec::new();
    for part in Part::all(emission) {
        let part_stale = stale(&older, part.places, &part.files, &folder.join(part.folder));
        if part.files.is_empty() && part_stale.is_empty() {
            continue;
        }
        let subfolder = folder.subfolder(part.folder, |_| ())?;
        let staged = stage_changed(&subfolder, &part.files)?;
        beside.push((subfolder, staged, part_stale));
    }
    let stays = |staged: &[Staged], stale: &[String]| staged.is_empty() && stale.is_empty();
    let all_stay = stays(&staged, &own_stale)
        && beside.iter().all(|(_, staged, part_stale)| stays(staged, part_stale));
    let manifest = match changed_manifest {
        None if all_stay => return Ok(()),
        Some(manifest) => manifest,
        None => folder.stage(MANIFEST, |out| out.write_all(manifest.as_bytes()))?,
    };
    let staged_beside = beside.iter().flat_map(|(_, staged, _)| staged);
    sync_all(staged.iter().chain(staged_beside).chain([&manifest]))?;

    // The older manifest must not come back after a power cut, among newer files.
    folder.remove(MANIFEST)?;
    folder.sync()?;
    folder.name(staged)?;
    for name in &own_stale {
        folder.remove(name)?;
    }
    for (subfolder, staged, part_stale) in beside {
        subfolder.name(staged)?;
        for name in &part_stale {
            subfolder.remove(name)?;
        }
    }
    Ok(folder.name(vec![manifest])?)
}

/// Those of some files that do not stand in a folder already, under hidden names.
fn stage_changed(folder: &OutputFolder, files: &[&EmittedFile]) -> Result<Vec<Staged>, FileError> {
    let stage = |file: &&EmittedFile| folder.stage_changed(&file.name, &file.text).transpose();
    files.iter().filter_map(stage).collect()
}

/// What an emission has in a folder beside the design.
struct Part<'e> {
    folder: &'static str,
    /// Where the manifest names its files.
    places: &'static [&'static str],
    files: Vec<&'e EmittedFile>,
}

impl Part<'_> {
    fn all(emission: &Emission) -> [Part<'_>; 2] {
        [
            Part {
                folder: Formal::FOLDER,
                places: PROOFS,
                files: emission.formal.files().collect(),
            },
            Part {
                folder: BOARD,
                places: PROJECT,
                files: emission.board.iter().flat_map(|board| &board.files).collect(),
            },
        ]
    }
}

/// The manifest of an earlier emission, which names what may have become stale; nothing if there
/// is none.
fn older_manifest(folder: &OutputFolder) -> Value {
    let text = read_regular(&folder.join(MANIFEST), MOST_MANIFEST_BYTES);
    text.ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

/// The files that a manifest names in its `places`, that are there, and that are none of
/// the new ones.
fn stale(manifest: &Value, places: &[&str], own: &[&EmittedFile], folder: &Path) -> Vec<String> {
    let own: HashSet<&str> = own.iter().map(|file| file.name.as_str()).collect();
    let named = places.iter().filter_map(|place| manifest.pointer(place));
    let names = named.flat_map(|named| match named {
        Value::Array(names) => names.iter().filter_map(Value::as_str).collect(),
        name => Vec::from_iter(name.as_str()),
    });
    names
        .filter(|name| is_ours(name) && !own.contains(name) && is_file(&folder.join(name)))
        .map(str::to_owned)
        .collect()
}

/// Whether a name is one that an emission may have given: that of a file in the folder
/// itself, with one of our endings or names.
fn is_ours(name: &str) -> bool {
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    !name.contains(['/', '\\'])
        && (name == MAKEFILE || ending.is_some_and(|ending| ENDINGS.contains(&ending)))
}

fn is_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
}

//! Reads a design: what the user names of it, and what its top module's ports are.

use std::fs;
use std::path::{Path, PathBuf};

use super::manifest::{NamedVerilog as Manifest, check_top};
use super::search::{FileSearch, Taken, check_folders};
use super::wrapper::wrapper;
use super::{Named, OwnRtl, bad_option, check_define, filelist, folder};
use crate::cosim::TOP;
use crate::cosim::build::BOARD_FLAG;
use crate::cosim::cache::{cache_dir, write};
use crate::cosim::error::CosimError;
use crate::cosim::ports;
use crate::cosim::source::{SourceFile, Verilog};
use crate::cosim::tools::Tools;
use crate::printable::printable_path;
use crate::rtl::back::Prefix;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::interface::Interface;

/// Reads a design, as far as it is needed; and what was ignored of it, or assumed. A manifest may
/// name its counters as those of the emitted design.
///
/// # Errors
/// When a file is missing or cannot be read, when Verilator does not take the Verilog, or
/// when the top module's ports are not the interface's.
pub fn read(own: &OwnRtl, interface: &Interface) -> Result<(Verilog, Vec<String>), CosimError> {
    if let Some(top) = &own.top {
        check_top(top).map_err(|reason| bad_option("--top", reason))?;
    }
    let mut named = Named::default();
    named.include_folders.extend(own.include_folders.iter().cloned());
    for define in &own.defines {
        check_define(define).map_err(|reason| bad_option("-D", reason))?;
        named.defines.push(define.clone());
    }
    for list in &own.file_lists {
        filelist::read(list, &mut named)?;
    }
    let manifest = match &own.folder {
        Some(path) => folder::read(path, &mut named)?,
        None => Manifest::default(),
    };
    let top = own.top.as_deref().or(manifest.top.as_deref());
    let top = top.unwrap_or(TOP);
    check_folders(&named.include_folders)?;
    let cache = cache_dir()?;
    let tools = Tools::find(&cache)?;
    let (taken, ports) = FileSearch::new(&tools, top, named)?.find()?;
    let differences = ports::differences(&interface.ports(), &ports);
    if !differences.is_empty() {
        let top = top.to_owned();
        return Err(CosimError::Ports { top, differences });
    }
    let (mut sources, mut remarks) = taken;
    let mut design_top = top.to_owned();
    if let Some(wrapper) = wrapper(top, &interface.ports(), &ports) {
        sources[0].text += &wrapper.text;
        remarks.extend(wrapper.remarks);
        design_top = wrapper.name;
    }
    let registers = match design_top == top {
        true => registers(top, &manifest, interface),
        false => None,
    };
    Ok((Verilog { top: design_top, sources, registers, cache }, remarks))
}

/// Reads a board of the folder that the user names, whose top module `top` is in `models`, which go
/// with it. What the folder has of modules in files called as `others` is left out.
///
/// # Errors
/// When a file is missing or cannot be read, or Verilator does not take the Verilog.
pub fn read_board(
    own: &OwnRtl,
    top: &str,
    models: &[SourceFile],
    others: &[&str],
    defines: &[String],
) -> Result<Taken, CosimError> {
    let (Some(path), None, true) = (&own.folder, &own.top, own.file_lists.is_empty()) else {
        let reason = "a board's Verilog is a folder, as `goldtof emit --board` writes it; name it with --rtl";
        return Err(bad_option("--board", reason.to_owned()));
    };
    let place = tempfile::tempdir().map_err(CosimError::memory(path))?;
    let mut named = Named::default();
    named.include_folders.extend(own.include_folders.iter().cloned());
    named.defines.extend(own.defines.iter().chain(defines).cloned());
    named.flags.push(BOARD_FLAG);
    folder::search(path, &mut named)?;
    let has =
        |name: &str| named.searched.iter().any(|file| file.file_name() == Some(name.as_ref()));
    if !["board_top.v", "board.vh"].into_iter().any(has) {
        let reason = format!(
            "no board_top.v and no board.vh in {}: --board wants a folder that `goldtof emit --board` wrote",
            printable_path(path)
        );
        return Err(bad_option("--rtl", reason));
    }
    let is_other =
        |file: &PathBuf| others.iter().any(|other| file.file_stem() == Some(other.as_ref()));
    let (left_out, searched) = named.searched.into_iter().partition::<Vec<_>, _>(is_other);
    named.searched = searched;
    for model in models {
        let is_other = |file: &&PathBuf| {
            file.file_stem() == Path::new(&model.name).file_stem()
                && fs::read(file).ok().as_deref() != Some(model.text.as_bytes())
        };
        named.remarks.extend(left_out.iter().filter(is_other).map(|file| {
            format!("{} is not read: goldtof has its own {}", file.display(), model.name)
        }));
        let file = place.path().join(&model.name);
        write(&file, &model.text)?;
        named.files.push(file);
    }
    let cache = cache_dir()?;
    let tools = Tools::find(&cache)?;
    let found = FileSearch::new(&tools, top, named)?.find();
    Ok(found.map_err(|error| without(error, place.path()))?.0)
}

/// A refusal without the names of files that the user does not have.
fn without(error: CosimError, place: &Path) -> CosimError {
    let CosimError::Rejected { tool, output } = error else { return error };
    let folder = format!("{}/", place.display());
    let is_looked_in = |line: &&str| line.trim_start().starts_with(&folder) && !line.contains(": ");
    let lines = output.lines().filter(|line| !is_looked_in(line));
    let told: Vec<String> = lines.map(|line| line.replace(&folder, "goldtof's ")).collect();
    CosimError::Rejected { tool, output: told.join("\n") }
}

/// The scan's counters, if the manifest names those that a design emitted for `interface`
/// has.
fn registers(top: &str, manifest: &Manifest, interface: &Interface) -> Option<ScanRegisters> {
    let registers = ScanRegisters::of(interface);
    let wanted = serde_json::to_value(&registers).ok()?;
    let prefix = match top.strip_suffix(TOP)? {
        "" => Prefix::default(),
        prefix => prefix.parse().ok()?,
    };
    (wanted == manifest.scan_registers).then(|| registers.in_design_of(&prefix))
}

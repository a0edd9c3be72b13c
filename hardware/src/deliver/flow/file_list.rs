//! File lists for `-f` of simulators and linters.

use crate::deliver::design::{EmittedDesign, EmittedFile};

/// The design's files, one a line.
pub(super) fn file_list(design: &EmittedDesign) -> EmittedFile {
    EmittedFile {
        name: design.file_name(".f"),
        text: listed(&design.top(), design.files.iter(), design.made_by),
    }
}

/// The design's files and those of the testbench, whose top module is `top`, one a line.
pub(super) fn testbench_file_list(
    design: &EmittedDesign,
    top: &str,
    testbench_files: &[EmittedFile],
) -> EmittedFile {
    EmittedFile {
        name: format!("{top}.f"),
        text: listed(top, design.files.iter().chain(testbench_files), design.made_by),
    }
}

fn listed<'a>(top: &str, files: impl Iterator<Item = &'a EmittedFile>, made_by: &str) -> String {
    let names: String = files.map(|file| format!("{}\n", file.name)).collect();
    format!(
        "// Verilog of {top}, the top module last; paths are relative to this folder\n// \
         Made by  {made_by}\n{names}"
    )
}

//! From Verilog to gates, by Yosys.

use std::fmt::Write as _;
use std::path::Path;

use super::LaneRefusal;
use super::yosys::{self, Memories};
use crate::cosim::cache::{hash, once, write};
use crate::cosim::error::CosimError;
use crate::cosim::source::{RTL, SourceFile};
use crate::cosim::tools::Tool;

const NETLIST: &str = "netlist.json";

/// The netlist of a design as Yosys writes it.
pub(super) fn synthesise(
    top: &str,
    sources: &[SourceFile],
    memories: Memories,
    cache: &Path,
) -> Result<String, LaneRefusal> {
    let yosys = Tool::yosys();
    let version = yosys_version(&yosys, cache)?;
    let to_gates = memories.to_gates();
    let mut parts = vec!["netlist", version.as_str()];
    parts.extend([yosys::TO_WORDS, to_gates.as_str(), top]);
    for source in sources {
        parts.extend([source.name.as_str(), source.text.as_str()]);
    }
    let mut unfit = None;
    let name = format!("netlist-{}", hash(&parts));
    let made = once(cache, &name, NETLIST, |folder| {
        write_sources(folder, sources)?;
        let script = format!(
            "{}{}\n{to_gates}\nwrite_json {NETLIST}\n",
            script_of_sources(top, sources),
            yosys::TO_WORDS,
        );
        write(&folder.join("to_gates.ys"), &script)?;
        let done =
            yosys.run(|command| command.current_dir(folder).args(["-q", "-s", "to_gates.ys"]));
        done.map(|_| ()).inspect_err(|error| {
            unfit = Some(first_error(error));
        })
    });
    failed_in_yosys(made, unfit)
}

/// What Yosys says of its version.
pub(super) fn yosys_version(yosys: &Tool, cache: &Path) -> Result<String, LaneRefusal> {
    let version = yosys.version("-V", cache);
    version.map(|version| version.trim().to_owned()).map_err(|error| match error {
        CosimError::MissingTool { install, .. } => {
            LaneRefusal::unfit(format!("Yosys is missing; install it with: {install}"))
        }
        other => LaneRefusal::unfit(format!("Yosys cannot be asked: {other}")),
    })
}

/// What Yosys does not take has no place in lanes.
pub(super) fn failed_in_yosys(
    made: Result<Vec<u8>, CosimError>,
    unfit: Option<String>,
) -> Result<String, LaneRefusal> {
    match (made, unfit) {
        (Ok(bytes), _) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        (Err(_), Some(reason)) => {
            Err(LaneRefusal::unfit(format!("Yosys does not take it: {reason}")))
        }
        (Err(error), None) => Err(error.into()),
    }
}

pub(super) fn write_sources(folder: &Path, sources: &[SourceFile]) -> Result<(), CosimError> {
    let rtl = folder.join(RTL);
    std::fs::create_dir(&rtl).map_err(CosimError::cache(&rtl))?;
    for source in sources {
        write(&rtl.join(&source.name), &source.text)?;
    }
    Ok(())
}

/// The start of a script: the design read.
pub(super) fn script_of_sources(top: &str, sources: &[SourceFile]) -> String {
    let mut text = format!("read_verilog -sv -I {RTL}");
    for source in sources.iter().filter(|source| source.is_compiled()) {
        let _ = write!(text, " \"{RTL}/{}\"", source.name);
    }
    let _ = writeln!(text, "\nhierarchy -check -top {top}");
    text
}

/// What a tool said was wrong, in one line.
pub(super) fn first_error(error: &CosimError) -> String {
    let text = error.to_string();
    let line = text.lines().find(|line| line.contains("ERROR")).or(text.lines().next());
    line.unwrap_or_default().trim().to_owned()
}

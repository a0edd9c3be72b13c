//! What can go wrong around a co-simulation.

use std::path::PathBuf;

use crate::printable::printable_path;

/// A co-simulation that could not be done. A mismatch is not an error.
#[derive(Debug, thiserror::Error)]
pub enum CosimError {
    /// An external tool is not there.
    #[error("{tool} is missing ({program}: {reason}); install it with: {install}")]
    MissingTool {
        /// What it is.
        tool: &'static str,
        /// The program that could not be started.
        program: String,
        /// The system's answer.
        reason: std::io::Error,
        /// How to get it.
        install: &'static str,
    },
    /// Verilator is there, but too old.
    #[error(
        "{program} says that it is \"{found}\", but goldtof needs Verilator 5.000 or newer; install it \
         with: {install}"
    )]
    OldVerilator {
        /// The program that was asked.
        program: String,
        /// What it said.
        found: String,
        /// How to get it.
        install: &'static str,
    },
    /// An external tool failed.
    #[error("{tool} failed: {command}\nended with {status}; it wrote:\n{}", output.trim_end())]
    ToolFailed {
        /// What it is.
        tool: &'static str,
        /// The command as it was run.
        command: String,
        /// Its exit status.
        status: std::process::ExitStatus,
        /// What it wrote to both its outputs: of much the start and the end.
        output: String,
    },
    /// An external tool did not come to an end.
    #[error(
        "{tool} was not done after {} s and was ended (--tool-timeout gives it more time): \
         {command}\nit wrote:\n{}",
        limit.as_secs_f64(),
        output.trim_end()
    )]
    ToolTimeout {
        /// What it is.
        tool: &'static str,
        /// The command as it was run.
        command: String,
        /// The time that it had.
        limit: std::time::Duration,
        /// What it wrote to both its outputs: of much the start and the end.
        output: String,
    },
    /// Waveforms were asked for that the run does not come to.
    #[error(
        "waveforms from clock {asked} on are beyond the run, which has {clocks} clocks, 0 to {}; \
         give a lower --vcd-from, or more --cycles",
        clocks - 1
    )]
    BeyondTheRun {
        /// The first clock that was asked for.
        asked: u64,
        /// Clocks of the run.
        clocks: u64,
    },
    /// The user's Verilog does not compile.
    #[error("{tool} does not take the Verilog to check:\n{}", output.trim_end())]
    Rejected {
        /// Who says so.
        tool: &'static str,
        /// Its words, with the user's own file names.
        output: String,
    },
    /// The user's Verilog does not have the scene's ports.
    #[error(
        "the ports of module {top} do not fit the scene:\n  {}\n(`goldtof emit` writes a \
         manifest.json that lists them)",
        differences.join("\n  ")
    )]
    Ports {
        /// The top module.
        top: String,
        /// One sentence per difference.
        differences: Vec<String>,
    },
    /// No file declares the module to check.
    #[error(
        "no module {top} is in the Verilog to check; --top names another one, and a --filelist says \
         which files belong to it"
    )]
    NoTop {
        /// The module's name.
        top: String,
    },
    /// Two files may be meant.
    #[error(
        "{what}: it may be {} or {}; a --filelist says which (with +incdir+ for included files)",
        printable_path(first),
        printable_path(second)
    )]
    Ambiguous {
        /// What is asked for.
        what: String,
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// An option cannot be meant.
    #[error("{option}: {reason}")]
    Option {
        /// The option.
        option: &'static str,
        /// What is wrong with it and what would be right.
        reason: String,
    },
    /// A list of files says what is not understood.
    #[error("{}:{line}:{column}: {reason}", printable_path(path))]
    FileList {
        /// The list.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// Its column in characters, from 1.
        column: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// `--rtl` names a folder without Verilog.
    #[error("{} holds no .v or .sv file; --rtl wants the folder of the Verilog to check", printable_path(.0))]
    NoVerilog(PathBuf),
    /// `--rtl` names a folder with more than anyone's sensor has.
    #[error(
        "{}: more than {most_mib} MiB of Verilog in all; --rtl wants the folder of one sensor",
        printable_path(folder)
    )]
    TooMuchVerilog {
        /// The folder.
        folder: PathBuf,
        /// The most that is read.
        most_mib: u64,
    },
    /// A file of Verilog has a name that cannot be handed to the tools.
    #[error(
        "{}: a file of Verilog cannot be named {name:?} here: {reason}; rename it",
        folder.display()
    )]
    FileName {
        /// The folder.
        folder: PathBuf,
        /// The file's name.
        name: std::ffi::OsString,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// `--rtl` names a folder whose manifest cannot be used.
    #[error("{}: {reason}", printable_path(path))]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A file of the Verilog to check could not be read.
    #[error(
        "{}: cannot read it: {source}; --rtl wants the folder, --filelist the list of the Verilog to \
         check",
        printable_path(path)
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Built models cannot be kept.
    #[error(
        "{}: cannot keep built models here: {source}; set GOLDTOF_CACHE_DIR to a folder that you, \
         and nobody else, can write to",
        printable_path(path)
    )]
    Cache {
        /// The file or folder of the cache.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// There is no place to keep built models.
    #[error(
        "there is no folder to keep built models in: the user has no home; set GOLDTOF_CACHE_DIR to \
         a folder that only this user can write"
    )]
    NoCache,
    /// A built model cannot be put into memory.
    #[error("{}: cannot put the built model into memory: {source}", printable_path(path))]
    Memory {
        /// The shared library.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The waveforms could not be written.
    #[error(transparent)]
    Waveforms(#[from] crate::files::FileError),
    /// The built model cannot be started.
    #[error("{}: cannot start the verilated model: {source}", printable_path(path))]
    Load {
        /// The program.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The Verilog ended the simulation.
    #[error("the Verilog ended the simulation {when}: {reason}")]
    Halted {
        /// How far it was.
        when: When,
        /// `$finish`, `$stop` or `$fatal`, and where; or how its process ended.
        reason: String,
    },
    /// What was to be done in lanes cannot be.
    #[error("this has no place in lanes: {0}; --engine auto takes lock-step for it")]
    NoLanes(String),
    /// Lanes have run and tell nothing of the design.
    #[error("lanes come to no verdict: {0}; --engine auto goes on in lock-step")]
    NoVerdict(String),
    /// A design whose faults cannot be told.
    #[error("this cannot be graded: {0}")]
    NotGraded(String),
    /// A design whose outputs are no measure of faults.
    #[error(
        "the Verilog differs from the reference model at clock {clock}, and so its faults cannot \
         be told; goldtof cosim shows how it differs"
    )]
    Differs {
        /// The first such clock.
        clock: u64,
    },
    /// The hardware is not modelled.
    #[error(transparent)]
    Reference(#[from] crate::reference::predictor::ReferenceError),
}

/// How far a simulation was when the Verilog ended it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// Its initial blocks had not ended.
    Start,
    /// In the block of clocks that begins with this one.
    BlockFrom(u64),
    /// In its final blocks.
    End,
}

impl std::fmt::Display for When {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            When::Start => f.write_str("before its first clock"),
            When::BlockFrom(clock) => write!(f, "in the block after clock {clock}"),
            When::End => f.write_str("in a final block"),
        }
    }
}

impl CosimError {
    /// An error of the cache's file `path`.
    pub fn cache(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> CosimError {
        let path = path.into();
        |source| CosimError::Cache { path, source }
    }

    /// An error of putting the library `path` into memory.
    pub fn memory(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> CosimError {
        let path = path.into();
        |source| CosimError::Memory { path, source }
    }

    /// Whether an external tool is to blame.
    pub fn is_tool(&self) -> bool {
        matches!(
            self,
            CosimError::MissingTool { .. }
                | CosimError::OldVerilator { .. }
                | CosimError::ToolFailed { .. }
                | CosimError::ToolTimeout { .. }
        )
    }
}

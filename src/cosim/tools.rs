//! Verilator and the C++ compiler as external programs.

use std::io;
use std::path::PathBuf;
use std::process::Command;

use super::error::CosimError;

const INSTALL_VERILATOR: &str = "apt-get install verilator";
const INSTALL_COMPILER: &str = "apt-get install g++";

/// The programs that build a model, found and asked for their versions.
#[derive(Debug, Clone)]
pub struct Tools {
    verilator: String,
    compiler: String,
    /// What both said of their versions; part of the build's identity.
    pub versions: String,
    /// Where Verilator keeps its run-time library.
    pub include: PathBuf,
}

impl Tools {
    /// Finds the tools: `$VERILATOR` or `verilator`, `$CXX` or `g++`.
    ///
    /// # Errors
    /// When one is missing, too old or fails; the message says how to get it.
    pub fn find() -> Result<Tools, CosimError> {
        let verilator = program("VERILATOR", "verilator");
        let compiler = program("CXX", "g++");
        let version = first_line(&ask(
            "Verilator",
            INSTALL_VERILATOR,
            &verilator,
            &["--version"],
        )?);
        let major = version
            .split_whitespace()
            .nth(1)
            .and_then(|number| number.split('.').next()?.parse::<u32>().ok());
        if !version.starts_with("Verilator") || major.is_none_or(|major| major < 5) {
            return Err(CosimError::OldVerilator {
                program: verilator,
                found: version,
                install: INSTALL_VERILATOR,
            });
        }
        let root = ask(
            "Verilator",
            INSTALL_VERILATOR,
            &verilator,
            &["--getenv", "VERILATOR_ROOT"],
        )?;
        let compiler_version = ask(
            "a C++ compiler",
            INSTALL_COMPILER,
            &compiler,
            &["--version"],
        )?;
        Ok(Tools {
            versions: format!("{version}\n{}", first_line(&compiler_version)),
            include: PathBuf::from(first_line(&root)).join("include"),
            verilator,
            compiler,
        })
    }

    /// A Verilator command without arguments.
    pub fn verilator(&self) -> Command {
        Command::new(&self.verilator)
    }

    /// A compiler command without arguments.
    pub fn compiler(&self) -> Command {
        Command::new(&self.compiler)
    }
}

fn program(variable: &str, default: &str) -> String {
    std::env::var(variable)
        .ok()
        .filter(|value| !value.trim().is_empty())
        .unwrap_or_else(|| default.to_owned())
}

fn ask(
    tool: &'static str,
    install: &'static str,
    program: &str,
    arguments: &[&str],
) -> Result<String, CosimError> {
    run(Command::new(program).args(arguments)).map_err(|error| match error {
        RunError::NotStarted(reason) => CosimError::MissingTool {
            tool,
            program: program.to_owned(),
            reason,
            install,
        },
        RunError::Failed(failed) => failed,
    })
}

/// Runs a command that is known to exist.
///
/// # Errors
/// When it cannot be started or ends with a failure; with all that it wrote.
pub fn must_run(command: &mut Command) -> Result<(), CosimError> {
    match run(command) {
        Ok(_) => Ok(()),
        Err(RunError::Failed(failed)) => Err(failed),
        Err(RunError::NotStarted(source)) => Err(CosimError::File {
            path: command.get_program().into(),
            source,
        }),
    }
}

enum RunError {
    NotStarted(io::Error),
    Failed(CosimError),
}

fn run(command: &mut Command) -> Result<String, RunError> {
    let output = command.output().map_err(RunError::NotStarted)?;
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        return Ok(stdout);
    }
    Err(RunError::Failed(CosimError::ToolFailed {
        command: format!("{command:?}"),
        status: output.status,
        output: stdout + &String::from_utf8_lossy(&output.stderr),
    }))
}

fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().trim().to_owned()
}

//! Verilator and the C++ compiler as external programs.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use super::cache::{file_identity, hash, once, write};
use super::error::CosimError;
use crate::programs;

/// What Verilator is called.
const VERILATOR: &str = "verilator";

/// What the compiler is told of every model.
const COMPILER_FLAGS: &[&str] = &[
    "-std=c++17",
    "-O2",
    "-DVL_USER_FINISH",
    "-DVL_USER_STOP",
    "-DVL_USER_FATAL",
    "-DVM_COVERAGE=0",
    "-DVM_SC=0",
    "-DVM_TRACE=0",
];

/// File of what a tool said of its version.
const VERSION: &str = "version.txt";

/// An external program.
#[derive(Debug, Clone)]
pub struct Tool {
    /// What it is.
    name: &'static str,
    /// How to get it.
    install: &'static str,
    program: String,
}

/// The programs that build a model, found and asked for their versions.
#[derive(Debug, Clone)]
pub struct Tools {
    /// Verilator.
    pub verilator: Tool,
    /// The C++ compiler.
    pub compiler: Tool,
    /// What it is told of every model; part of the build's identity.
    pub compiler_flags: Vec<String>,
    /// What both said of their versions; part of the build's identity.
    pub versions: String,
}

impl Tools {
    /// Finds the tools: `$VERILATOR` or `verilator`, `$CXX` or `g++`, and what flags of its own
    /// `$GOLDTOF_CXXFLAGS` gives the compiler. The cache keeps what they say of their versions.
    ///
    /// # Errors
    /// When one is missing, too old or fails; the message says how to get it.
    pub fn find(cache: &Path) -> Result<Tools, CosimError> {
        let verilator = Tool {
            name: "Verilator",
            install: "apt-get install verilator",
            program: program("VERILATOR", VERILATOR),
        };
        let compiler = Tool {
            name: "a C++ compiler",
            install: "apt-get install g++",
            program: program("CXX", "g++"),
        };
        let version = first_line(&verilator.itself().version("--version", cache)?);
        let major = version
            .split_whitespace()
            .nth(1)
            .and_then(|number| number.split('.').next()?.parse::<u32>().ok());
        if !version.starts_with("Verilator") || major.is_none_or(|major| major < 5) {
            return Err(CosimError::OldVerilator {
                program: verilator.program,
                found: version,
                install: verilator.install,
            });
        }
        let compiler_version = compiler.version("--version", cache)?;
        let flags = std::env::var_os("GOLDTOF_CXXFLAGS").unwrap_or_default();
        Ok(Tools {
            versions: format!("{version}\n{}", first_line(&compiler_version)),
            compiler_flags: compiler_flags(&flags.to_string_lossy()),
            verilator,
            compiler,
        })
    }

    /// The same, optimising with this flag unless the user's flags say otherwise.
    pub fn optimising(&self, flag: &str) -> Tools {
        let mut tools = self.clone();
        tools.compiler_flags.insert(COMPILER_FLAGS.len(), flag.to_owned());
        tools
    }

    /// Where Verilator keeps its run-time library. It is asked only where something is built:
    /// what is found built has no use for it.
    ///
    /// # Errors
    /// When Verilator fails.
    pub fn include(&self) -> Result<PathBuf, CosimError> {
        let root = self.verilator.ask(&["--getenv", "VERILATOR_ROOT"])?;
        Ok(PathBuf::from(first_line(&root)).join("include"))
    }
}

impl Tool {
    /// Yosys: `$YOSYS` or `yosys`. Nobody has asked yet whether it is there.
    pub fn yosys() -> Tool {
        Tool { name: "Yosys", install: "apt-get install yosys", program: program("YOSYS", "yosys") }
    }

    /// Yosys's ABC: `$ABC` or `yosys-abc`.
    pub fn abc() -> Tool {
        Tool {
            name: "Yosys's ABC",
            install: "apt-get install yosys",
            program: program("ABC", "yosys-abc"),
        }
    }

    /// The program behind Verilator's wrapper, if it stands beside it: the wrapper is a
    /// script whose interpreter takes longer to start than a version to be told.
    fn itself(&self) -> Tool {
        let folders = match Path::new(&self.program).parent() {
            Some(folder) if !folder.as_os_str().is_empty() => vec![folder.to_owned()],
            _ => std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).collect(),
        };
        let is_wrapper = Path::new(&self.program).file_name() == Some(VERILATOR.as_ref());
        let behind = folders
            .iter()
            .find(|folder| folder.join(VERILATOR).is_file())
            .map(|folder| folder.join(format!("{VERILATOR}_bin")))
            .filter(|program| is_wrapper && program.is_file());
        let mut tool = self.clone();
        if let Some(program) = behind.and_then(|path| path.into_os_string().into_string().ok()) {
            tool.program = program;
        }
        tool
    }

    /// What it says when it is asked with this argument for its version. The cache keeps that as
    /// long as the program's file is the same: its path, its size and its times.
    ///
    /// # Errors
    /// When it fails, or the cache cannot be had.
    pub fn version(&self, argument: &str, cache: &Path) -> Result<String, CosimError> {
        let Some(file) = self.file_identity() else {
            return self.ask(&[argument]);
        };
        let name = format!("version-{}", hash(&["version", self.name, argument, &file]));
        let said = once(cache, &name, VERSION, |folder| {
            write(&folder.join(VERSION), &self.ask(&[argument])?)
        })?;
        Ok(String::from_utf8_lossy(&said).into_owned())
    }

    /// What changes with the program's file. None if there is no such file, or if what it starts
    /// may change without it: a script, or a program that goes by another's name.
    fn file_identity(&self) -> Option<String> {
        let called = Path::new(&self.program).file_name()?.to_str()?;
        let path = match self.program.contains('/') {
            true => PathBuf::from(&self.program),
            false => std::env::split_paths(&std::env::var_os("PATH")?)
                .map(|folder| folder.join(&self.program))
                .find(|path| path.is_file())?,
        };
        let path = fs::canonicalize(path).ok()?;
        let mut magic = [0; 4];
        let mut file = File::open(&path).ok()?;
        file.read_exact(&mut magic).ok()?;
        let identity = file_identity(&path).ok()?;
        let path = path.to_str()?;
        let is_program = magic == *b"\x7fELF" && path.rsplit('/').next()?.contains(called);
        is_program.then(|| format!("{path} {identity}"))
    }

    fn ask(&self, arguments: &[&str]) -> Result<String, CosimError> {
        self.run(|command| command.args(arguments))
    }

    /// Runs it with the arguments that `arguments` adds; gives its stdout.
    ///
    /// # Errors
    /// When it cannot be started or ends with a failure; with all that it wrote.
    pub fn run(
        &self,
        arguments: impl FnOnce(&mut Command) -> &mut Command,
    ) -> Result<String, CosimError> {
        self.run_into(arguments, Stdio::piped())
    }

    /// [`Tool::run`] with another place for its stdout, which may then be long.
    ///
    /// # Errors
    /// As [`Tool::run`].
    pub fn run_into(
        &self,
        arguments: impl FnOnce(&mut Command) -> &mut Command,
        stdout: Stdio,
    ) -> Result<String, CosimError> {
        self.run_for(arguments, stdout, programs::time_limit())
    }

    /// [`Tool::run_into`] with a time limit of its own.
    ///
    /// # Errors
    /// As [`Tool::run`].
    pub fn run_for(
        &self,
        arguments: impl FnOnce(&mut Command) -> &mut Command,
        stdout: Stdio,
        limit: Duration,
    ) -> Result<String, CosimError> {
        let mut command = Command::new(&self.program);
        arguments(&mut command);
        let finished = programs::run(&mut command, stdout, limit).map_err(|reason| {
            CosimError::MissingTool {
                tool: self.name,
                program: self.program.clone(),
                reason,
                install: self.install,
            }
        })?;
        let tool = self.name;
        let command = format!("{command:?}");
        match finished.status {
            Some(status) if status.success() => Ok(finished.stdout),
            Some(status) => Err(CosimError::ToolFailed {
                tool,
                command,
                status,
                output: finished.stdout + &finished.stderr,
            }),
            None => Err(CosimError::ToolTimeout {
                tool,
                command,
                limit,
                output: finished.stdout + &finished.stderr,
            }),
        }
    }
}

/// A program's name. One with a folder is where it is from here, wherever it is
/// started.
fn program(variable: &str, default: &str) -> String {
    let chosen = std::env::var(variable)
        .ok()
        .filter(|value| !value.trim().is_empty())
        .unwrap_or_else(|| default.to_owned());
    if !chosen.contains('/') {
        return chosen;
    }
    let absolute = std::path::absolute(&chosen).ok();
    absolute.and_then(|path| path.into_os_string().into_string().ok()).unwrap_or(chosen)
}

/// Ours and then the user's, parted by spaces: of two that contradict each other a compiler
/// takes the last.
fn compiler_flags(users: &str) -> Vec<String> {
    let ours = COMPILER_FLAGS.iter().copied();
    ours.chain(users.split_whitespace()).map(str::to_owned).collect()
}

fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A program in the place of another. A process of its own writes it: a program that we hold
    /// open for writing cannot be started ("text file busy"), and what a test beside this one
    /// starts just then holds a copy of our descriptor for a moment.
    fn install(source: &Path, path: &Path) {
        let mut install = std::process::Command::new("install");
        install.args(["-m", "755"]).args([source, path]);
        assert!(install.status().unwrap().success());
    }

    #[test]
    fn a_version_is_asked_for_again_when_the_program_is_another() {
        let folder = tempfile::tempdir().unwrap();
        let cache = folder.path().join("cache");
        let program = folder.path().join("true");
        let tool =
            Tool { name: "a tool", install: "", program: program.to_str().unwrap().to_owned() };
        // Two programs that answer differently, and are no scripts.
        install(Path::new("/bin/echo"), &program);
        assert_eq!(tool.version("one", &cache).unwrap(), "one\n");
        install(Path::new("/bin/true"), &program);
        assert_eq!(tool.version("one", &cache).unwrap(), "");
        // What is kept is what is told, and only of this file.
        let kept = || fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().path());
        let folders: Vec<PathBuf> = kept().filter(|path| path.is_dir()).collect();
        assert_eq!(folders.len(), 2);
        assert_eq!(tool.version("one", &cache).unwrap(), "");
        assert_eq!(kept().filter(|path| path.is_dir()).count(), 2);
        // A script may start anything: it is asked each time.
        let script = folder.path().join("script");
        fs::write(&script, "#!/bin/sh\ncat \"$0.says\"\n").unwrap();
        install(&script, &program);
        for said in ["1", "2"] {
            fs::write(folder.path().join("true.says"), said).unwrap();
            assert_eq!(tool.version("one", &cache).unwrap(), said);
        }
    }

    #[test]
    fn the_users_flags_come_last_and_so_win() {
        let ours = compiler_flags("");
        let all = compiler_flags(" -O1  -march=native ");
        assert!(ours.contains(&"-O2".to_owned()));
        assert_eq!(all[..ours.len()], ours);
        assert_eq!(all[ours.len()..], ["-O1", "-march=native"]);
        let tool = Tool { name: "", install: "", program: String::new() };
        let tools = Tools {
            verilator: tool.clone(),
            compiler: tool,
            compiler_flags: all,
            versions: String::new(),
        };
        assert_eq!(
            tools.optimising("-O3").compiler_flags[ours.len()..],
            ["-O3", "-O1", "-march=native"]
        );
    }
}

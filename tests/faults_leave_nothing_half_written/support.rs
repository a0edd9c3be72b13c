//! Runs of the program, what they leave, and programs that stand in for tools.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

pub const QUICK: &str = "scenes/quick.toml";

/// Longest time that anything here may take.
const PATIENCE: Duration = Duration::from_secs(120);

pub fn goldtof(arguments: &[&str]) -> Command {
    let mut command = listening(env!("CARGO_BIN_EXE_goldtof"));
    command.args(arguments);
    command
}

/// A program that takes signals, also where the tests run in the background of a
/// shell that has them ignored: what is ignored at the start stays so.
pub fn listening(program: &str) -> Command {
    let mut command = Command::new("/usr/bin/env");
    command.args(["--default-signal=HUP,INT,QUIT,TERM", program]);
    command
}

pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs a command that must end with `status`, and gives its stderr. A panic
/// would end with 101.
pub fn ends_with(status: i32, command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{}", stderr(&output));
    stderr(&output)
}

/// Starts a command whose outputs are kept.
pub fn start(command: &mut Command) -> Child {
    let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    piped.spawn().unwrap()
}

pub fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

pub fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let started = Instant::now();
    while !holds() {
        assert!(started.elapsed() < PATIENCE, "no end of waiting: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Every file below a folder, hidden ones too, with its contents.
pub fn files_below(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                files.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    files
}

pub fn is_hidden(path: &Path) -> bool {
    let name = path.file_name().unwrap().to_str().unwrap();
    name.starts_with('.')
}

/// What an undisturbed `emit` of a scene leaves.
pub fn emitted(scene: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    ends_with(0, &mut goldtof(&["emit", scene, "--out", text(folder.path())]));
    files_below(folder.path())
}

/// Writes the scene [`QUICK`] with another integration time: a design of which some files are the same.
pub fn integrating_for(time: &str, scene: &Path) {
    let quick = fs::read_to_string(QUICK).unwrap();
    let own = "integration = \"";
    let (before, after) = quick.split_once(own).unwrap();
    let after = after.split_once('"').unwrap().1;
    fs::write(scene, format!("{before}{own}{time}\"{after}")).unwrap();
}

/// A program of these bytes. Another process writes it: a program that we hold open
/// for writing cannot be started ("text file busy"), and whatever a test beside this
/// one starts just then holds a copy of our descriptor until it has become a program.
pub fn program(path: &Path, bytes: impl Into<Stdio>) {
    let mut install = Command::new("install");
    install.args(["-m", "755", "/dev/stdin"]).arg(path).stdin(bytes);
    ends_with(0, &mut install);
}

/// A shell script in the place of a program.
pub fn script(path: &Path, lines: &str) {
    let mut text = tempfile::tempfile().unwrap();
    write!(text, "#!/bin/sh\n{lines}\n").unwrap();
    text.rewind().unwrap();
    program(path, text);
}

/// A scene of `quick`'s hardware whose scan takes hours to simulate.
pub fn endless_scene(folder: &Path) -> PathBuf {
    let quick = fs::read_to_string(QUICK).unwrap();
    let at = quick.find("integration = \"").unwrap();
    let end = at + quick[at..].find('\n').unwrap();
    let path = folder.join("endless.toml");
    let endless = format!("{}integration = \"100 s\"{}", &quick[..at], &quick[end..]);
    fs::write(&path, endless).unwrap();
    path
}

/// A cache with Verilator's compiled run-time library and headers but no model.
pub fn cache_without_models() -> tempfile::TempDir {
    ends_with(0, &mut goldtof(&["cosim", QUICK, "--quiet"]));
    let cache = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(goldtof::cosim::build::cache_dir().unwrap()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let is_of_verilator = name.starts_with("runtime-") || name.starts_with("header-");
        if !is_of_verilator || !entry.path().is_dir() || name.contains("building") {
            continue;
        }
        let copy = cache.path().join(name);
        fs::create_dir(&copy).unwrap();
        for file in fs::read_dir(entry.path()).unwrap() {
            let file = file.unwrap();
            fs::copy(file.path(), copy.join(file.file_name())).unwrap();
        }
    }
    cache
}

/// The names in a cache that begin with `prefix`, locks left out.
pub fn entries(cache: &Path, prefix: &str) -> Vec<PathBuf> {
    fs::read_dir(cache)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let name = path.file_name().unwrap().to_str().unwrap();
            name.starts_with(prefix) && !name.ends_with(".lock")
        })
        .collect()
}

/// A compiler that does as g++ does, but when it links a model first appends its
/// process id to the file `linking` and then waits for `seconds`.
pub fn slow_linker(folder: &Path, seconds: u32) -> (PathBuf, PathBuf) {
    let (compiler, linking) = (folder.join("slow-g++"), folder.join("linking"));
    let lines = format!(
        "case \" $* \" in *\" -o sensor \"*) echo $$ >> {}; sleep {seconds};; esac\nexec g++ \"$@\"",
        linking.display()
    );
    script(&compiler, &lines);
    (compiler, linking)
}

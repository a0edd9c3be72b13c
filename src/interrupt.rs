//! An end from outside: Ctrl-C, SIGTERM, a file-size limit.
//!
//! What is unfinished is known here: files and folders under their hidden
//! names, and external programs. When a signal comes these are removed and
//! ended, and the program ends with 128 + the signal's number, as a shell
//! reports it (130 for Ctrl-C). Nothing is published after that.

use std::fs;
use std::io::{self, Write as _};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustix::process::{Pid, Signal, kill_process_group};
use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;

/// What must not outlive an interrupted run.
#[derive(Debug)]
struct State {
    unfinished: Vec<Arc<Path>>,
    programs: Vec<Pid>,
}

static STATE: Mutex<State> = Mutex::new(State {
    unfinished: Vec::new(),
    programs: Vec::new(),
});

impl State {
    /// Forgets a path, and says whether it was still known. It is told apart by
    /// identity: as soon as a hidden file has its name, another thread may take the
    /// same hidden name.
    fn forget(&mut self, path: &Arc<Path>) -> bool {
        let place = self
            .unfinished
            .iter()
            .position(|other| Arc::ptr_eq(other, path));
        place
            .map(|place| self.unfinished.swap_remove(place))
            .is_some()
    }
}

fn state() -> MutexGuard<'static, State> {
    // Every change of the state is a single one, so a panic cannot leave it half-made.
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Watches for SIGINT and SIGTERM from now on. A file-size limit becomes an
/// error of the write that exceeds it.
///
/// # Errors
/// When the system takes no handler.
pub fn watch() -> io::Result<()> {
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            if let Some(signal) = signals.forever().next() {
                end(signal);
            }
        })?;
    Ok(())
}

/// Ends the program at once. The lock is kept: no file gets its name, and no
/// program starts, after this.
fn end(signal: i32) -> ! {
    let state = state();
    for &group in &state.programs {
        // One that has ended by itself is as good.
        let _ = kill_process_group(group, Signal::KILL);
    }
    for path in &state.unfinished {
        remove(path);
    }
    let name = if signal == SIGINT {
        "interrupted"
    } else {
        "terminated"
    };
    let _ = writeln!(
        io::stderr(),
        "\nerror: {name}; unfinished files are removed, finished ones are whole"
    );
    // Without the destructors of statics: other threads still run.
    signal_hook::low_level::exit(128 + signal)
}

fn remove(path: &Path) {
    let _ = match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => fs::remove_dir_all(path),
        _ => fs::remove_file(path),
    };
}

/// A file or folder under a hidden name; removed when dropped or interrupted.
#[derive(Debug)]
pub struct Unfinished {
    path: Arc<Path>,
}

impl Unfinished {
    /// Takes over what is, or is about to be, at `path`.
    pub fn new(path: &Path) -> Unfinished {
        let path: Arc<Path> = path.into();
        state().unfinished.push(Arc::clone(&path));
        Unfinished { path }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives it its name; from then on it stays.
    ///
    /// # Errors
    /// When it cannot be renamed; it is removed then.
    pub fn rename(self, name: &Path) -> io::Result<()> {
        let mut state = state();
        fs::rename(&self.path, name)?;
        state.forget(&self.path);
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut state = state();
        if state.forget(&self.path) {
            remove(&self.path);
        }
    }
}

/// Runs an external program to its end, in a process group of its own, which
/// ends with this program when that is interrupted.
///
/// # Errors
/// When it cannot be started.
pub fn run_program(command: &mut Command) -> io::Result<Output> {
    let (child, group) = start(command)?;
    let output = child.wait_with_output();
    state().programs.retain(|other| *other != group);
    output
}

fn start(command: &mut Command) -> io::Result<(Child, Pid)> {
    let mut state = state();
    let child = command
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let group = Pid::from_child(&child);
    state.programs.push(group);
    Ok((child, group))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_renamed_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let (kept, gone) = (folder.path().join("kept"), folder.path().join("gone"));
        for path in [&kept, &gone] {
            fs::create_dir(path).unwrap();
            fs::write(path.join("file"), "").unwrap();
        }
        let name = folder.path().join("name");
        Unfinished::new(&kept).rename(&name).unwrap();
        drop(Unfinished::new(&gone));
        assert!(name.join("file").exists());
        assert!(!gone.exists() && !kept.exists());
    }

    #[test]
    fn a_hidden_name_that_is_taken_again_belongs_to_its_new_owner() {
        let folder = tempfile::tempdir().unwrap();
        let hidden = folder.path().join("hidden");
        fs::write(&hidden, "first").unwrap();
        let (first, second) = (Unfinished::new(&hidden), Unfinished::new(&hidden));
        first.rename(&folder.path().join("name")).unwrap();
        fs::write(&hidden, "second").unwrap();
        drop(second);
        assert!(!hidden.exists());
    }

    #[test]
    fn a_program_gives_its_outputs_and_its_status() {
        let output = run_program(Command::new("sh").args(["-c", "echo $$; echo b >&2; exit 7"]));
        let output = output.unwrap();
        assert_eq!(output.stderr, b"b\n");
        assert_eq!(output.status.code(), Some(7));
        let said = String::from_utf8(output.stdout).unwrap();
        let program = Pid::from_raw(said.trim().parse().unwrap()).unwrap();
        assert!(!state().programs.contains(&program));
        assert!(run_program(&mut Command::new("/nonexistent/tool")).is_err());
    }
}

//! An end from outside: Ctrl-C, SIGTERM, SIGHUP, a file-size limit.
//!
//! What is unfinished is known here: files and folders under their hidden
//! names, and external programs. When a signal comes these are removed and
//! ended, and the program ends with 128 + the signal's number, as a shell
//! reports it (130 for Ctrl-C). Nothing is published after that.

use std::fs;
use std::io::{self, Write as _};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;

/// What must not outlive an interrupted run.
#[derive(Debug)]
struct State {
    unfinished: Vec<Arc<Path>>,
    programs: Vec<Pid>,
}

static STATE: Mutex<State> = Mutex::new(State { unfinished: Vec::new(), programs: Vec::new() });

impl State {
    /// Forgets a path, and says whether it was still known. It is told apart by
    /// identity: as soon as a hidden file has its name, another thread may take the
    /// same hidden name.
    fn forget(&mut self, path: &Arc<Path>) -> bool {
        let place = self.unfinished.iter().position(|other| Arc::ptr_eq(other, path));
        place.map(|place| self.unfinished.swap_remove(place)).is_some()
    }
}

fn state() -> MutexGuard<'static, State> {
    // Every change of the state is a single one, so a panic cannot leave it half-made.
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Signals that end a run.
const ENDING: [i32; 4] = [SIGHUP, SIGINT, SIGTERM, SIGQUIT];

/// Watches for the signals that end a run from now on, but for those that whoever
/// started this program wanted ignored, as nohup does. A file-size limit becomes
/// an error of the write that exceeds it.
///
/// # Errors
/// When the system takes no handler.
pub fn watch() -> io::Result<()> {
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mut signals = Signals::new(listened_to(&status))?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            end(signal);
        }
    })?;
    Ok(())
}

/// The signals to watch for, from the system's account of this process.
fn listened_to(status: &str) -> Vec<i32> {
    let ignored = status
        .lines()
        .find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok())
        .unwrap_or(0);
    let is_wanted = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    ENDING.into_iter().filter(is_wanted).collect()
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
    let name = match signal {
        SIGINT => "interrupted",
        SIGHUP => "hung up",
        SIGQUIT => "quit",
        _ => "terminated",
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

/// A program that was started, in a process group of its own. The group ends
/// with this program when that is interrupted, and when this value is dropped.
#[derive(Debug)]
pub struct Program {
    child: Child,
    group: Pid,
}

impl Program {
    /// Starts it.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(command: &mut Command) -> io::Result<Program> {
        let mut state = state();
        let child = command.process_group(0).spawn()?;
        let group = Pid::from_child(&child);
        state.programs.push(group);
        Ok(Program { child, group })
    }

    /// The process itself, for its outputs; to be waited for by
    /// [`Program::end`] alone.
    pub fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Whether it has ended; its status stays to be had.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn has_ended(&self) -> io::Result<bool> {
        let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        Ok(waitid(WaitId::Pid(self.group), look)?.is_some())
    }

    /// Ends what is left of its group, and gives how it ended.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn end(&mut self) -> io::Result<ExitStatus> {
        let mut state = state();
        if let Some(place) = state.programs.iter().position(|&group| group == self.group) {
            state.programs.swap_remove(place);
            // Before it is waited for: until then nobody else has its number.
            let _ = kill_process_group(self.group, Signal::KILL);
        }
        drop(state);
        self.child.wait()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::ExitStatusExt as _;

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
    fn a_program_is_known_until_its_end_and_ends_when_dropped() {
        let start = || Program::start(Command::new("sleep").arg("1000")).unwrap();
        let known = |program: &Program| state().programs.contains(&program.group);
        let mut program = start();
        assert!(known(&program) && !program.has_ended().unwrap());
        assert_eq!(program.end().unwrap().signal(), Some(9));
        assert!(!known(&program));
        assert_eq!(program.end().unwrap().signal(), Some(9));
        let group = start().group;
        assert!(rustix::process::test_kill_process(group).is_err());
        assert!(Program::start(&mut Command::new("/nonexistent/tool")).is_err());
    }

    #[test]
    fn signals_that_were_ignored_stay_so() {
        let status = "Name:\tx\nSigIgn:\t0000000000000003\nSigCgt:\t0\n";
        assert_eq!(listened_to(status), [SIGTERM, SIGQUIT]);
        assert_eq!(listened_to(""), ENDING);
    }
}

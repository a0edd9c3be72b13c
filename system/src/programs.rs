//! External programs: in a process group of their own, for a limited time, with
//! as much of their words as anyone reads.

use std::collections::VecDeque;
use std::io::{self, Read};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::interrupt::Program;

/// Longest time of a program, unless [`set_time_limit`] says otherwise.
pub const DEFAULT_TIME_LIMIT: Duration = Duration::from_secs(600);
/// Bytes of an output that are kept of its start, and as many of its end.
const KEPT_BYTES: usize = 32 << 10;
/// How often a program is asked whether it has ended while one of its children
/// keeps its outputs open.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// How long to wait for what a program that has ended wrote last.
const LAST_WORDS: Duration = Duration::from_secs(2);

static TIME_LIMIT_MS: AtomicU64 = AtomicU64::new(DEFAULT_TIME_LIMIT.as_millis() as u64);

/// Sets the longest time of each program that is started from now on.
pub fn set_time_limit(limit: Duration) {
    let milliseconds = u64::try_from(limit.as_millis()).unwrap_or(u64::MAX);
    TIME_LIMIT_MS.store(milliseconds, Ordering::Relaxed);
}

/// The longest time of a program.
pub fn time_limit() -> Duration {
    Duration::from_millis(TIME_LIMIT_MS.load(Ordering::Relaxed))
}

/// How a program ended, and what it said.
#[derive(Debug)]
pub struct Finished {
    /// Its exit status; none when its time was up and it was ended.
    pub status: Option<ExitStatus>,
    /// What it wrote to its standard output.
    pub stdout: String,
    /// What it wrote to its standard error.
    pub stderr: String,
}

/// Runs a program to its end, or to the end of its time `limit`. Its children end with
/// it, and all of them with this program when that is interrupted. What it writes to its
/// standard output goes to `stdout`, and is in [`Finished`] if that is a pipe.
///
/// # Errors
/// When it cannot be started or watched.
pub fn run(command: &mut Command, stdout: Stdio, limit: Duration) -> io::Result<Finished> {
    let piped = command.stdin(Stdio::null()).stdout(stdout).stderr(Stdio::piped());
    let mut program = Program::start(piped)?;
    let (closed, closings) = channel();
    let child = program.child();
    let outputs = [
        child.stdout.take().map(|out| listen(out, closed.clone())),
        child.stderr.take().map(|out| listen(out, closed)),
    ];
    let in_time = wait(&program, &closings, Instant::now(), limit)?;
    let status = program.end()?;
    // Those who could still write have been ended, but for a process that has left
    // the group.
    while closings.recv_timeout(LAST_WORDS).is_ok() {}
    let [stdout, stderr] = outputs.map(|said| said.map(|said| lock(&said).text()));
    Ok(Finished {
        status: in_time.then_some(status),
        stdout: stdout.unwrap_or_default(),
        stderr: stderr.unwrap_or_default(),
    })
}

/// Waits until the program has ended; false when its time is up before.
fn wait(
    program: &Program,
    closings: &Receiver<()>,
    started: Instant,
    limit: Duration,
) -> io::Result<bool> {
    loop {
        if program.has_ended()? {
            return Ok(true);
        }
        let Some(left) = limit.checked_sub(started.elapsed()) else {
            return Ok(false);
        };
        let pause = left.min(LOOK_EVERY);
        if closings.recv_timeout(pause) == Err(std::sync::mpsc::RecvTimeoutError::Disconnected) {
            // Both outputs are closed: as a rule it ends in the same moment.
            thread::sleep(pause.min(Duration::from_millis(1)));
        }
    }
}

/// Listens to an output in a thread of its own; `closed` is told of its end.
fn listen(mut output: impl Read + Send + 'static, closed: Sender<()>) -> Arc<Mutex<Said>> {
    let said = Arc::new(Mutex::new(Said::default()));
    let heard = Arc::clone(&said);
    thread::spawn(move || {
        let mut bytes = [0; 8192];
        loop {
            match output.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => lock(&heard).add(&bytes[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => break,
            }
        }
        let _ = closed.send(());
    });
    said
}

fn lock(said: &Mutex<Said>) -> std::sync::MutexGuard<'_, Said> {
    said.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The start and the end of what a program said, however much it was.
#[derive(Debug, Default)]
struct Said {
    start: Vec<u8>,
    end: VecDeque<u8>,
    left_out: u64,
}

impl Said {
    fn add(&mut self, bytes: &[u8]) {
        let room = KEPT_BYTES - self.start.len();
        let (first, rest) = bytes.split_at(room.min(bytes.len()));
        self.start.extend_from_slice(first);
        self.end.extend(rest);
        let too_many = self.end.len().saturating_sub(KEPT_BYTES);
        self.end.drain(..too_many);
        self.left_out += too_many as u64;
    }

    fn text(&mut self) -> String {
        let start = String::from_utf8_lossy(&self.start).into_owned();
        let end = self.end.make_contiguous();
        if self.left_out == 0 {
            // In one piece, so that no character is cut in two.
            let whole = [&self.start, &*end].concat();
            return String::from_utf8_lossy(&whole).into_owned();
        }
        let left_out = self.left_out;
        let end = String::from_utf8_lossy(end);
        format!("{start}\n[... {left_out} bytes left out ...]\n{end}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(lines: &str) -> Finished {
        let mut command = Command::new("sh");
        run(command.args(["-c", lines]), Stdio::piped(), DEFAULT_TIME_LIMIT).unwrap()
    }

    #[test]
    fn a_program_gives_its_outputs_and_its_status() {
        let finished = shell("echo a; echo b >&2; exit 7");
        assert_eq!(finished.status.unwrap().code(), Some(7));
        assert_eq!((&*finished.stdout, &*finished.stderr), ("a\n", "b\n"));
        let mut missing = Command::new("/nonexistent/tool");
        assert!(run(&mut missing, Stdio::piped(), DEFAULT_TIME_LIMIT).is_err());
    }

    #[test]
    fn of_a_flood_the_start_and_the_end_are_kept() {
        let finished = shell("echo first; yes | head -c 20000000; echo last");
        assert!(finished.status.unwrap().success());
        assert!(finished.stdout.starts_with("first\ny\n"));
        assert!(finished.stdout.ends_with("y\nlast\n"));
        let left_out = 20_000_000 + 6 + 5 - 2 * KEPT_BYTES;
        let remark = format!("\n[... {left_out} bytes left out ...]\n");
        assert!(finished.stdout.contains(&remark));
        assert_eq!(finished.stdout.len(), 2 * KEPT_BYTES + remark.len());
    }

    #[test]
    fn what_just_fits_is_whole() {
        let mut said = Said::default();
        let text = "\u{b5}".repeat(KEPT_BYTES);
        // Odd pieces, so that characters are cut.
        text.as_bytes().chunks(777).for_each(|piece| said.add(piece));
        assert_eq!(said.text(), text);
    }

    #[test]
    fn children_that_outlive_a_program_end_with_it() {
        let started = Instant::now();
        let finished = shell("sleep 1000 & echo $!");
        assert!(finished.status.unwrap().success());
        assert!(started.elapsed() < Duration::from_secs(60));
        let child = finished.stdout.trim().to_owned();
        while std::fs::read_to_string(format!("/proc/{child}/stat"))
            .is_ok_and(|stat| !stat.contains(") Z "))
        {
            assert!(started.elapsed() < Duration::from_secs(60), "it is left");
            thread::sleep(LOOK_EVERY);
        }
    }
}

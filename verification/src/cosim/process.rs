//! A verilated model's process, and the talk with it.
//!
//! The Verilog may be a stranger's: it may end its process, crash, or never come
//! back, and print what it likes. `testbench/process.h` is the other side.
//!
//! Words go through a file in memory, which is written and read here and mapped
//! there: so nothing that the other side does to it reaches this one's memory.

use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt as _;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::build::Built;
use super::error::{CosimError, When};
use crate::interrupt::Program;
use crate::programs::time_limit;
use crate::reference::blocks::BLOCK_CLOCKS;

/// How often a model that does not answer is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// How long to wait for the last words of a model that has ended.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Longest text of an answer that is read.
const MOST_TEXT_BYTES: u32 = 1 << 16;

/// The process of a verilated model, and the words that both share.
#[derive(Debug)]
pub(super) struct Process {
    program: Program,
    line: UnixStream,
    shared: File,
    /// Closed when all that the model prints has been passed on.
    words: Receiver<()>,
}

impl Process {
    /// Starts a built model with so many shared words, and waits until it is ready.
    ///
    /// # Errors
    /// When it cannot be started, or ends before its first clock.
    pub(super) fn load(built: &Built, shared_words: u64) -> Result<Process, CosimError> {
        Process::load_another(built, shared_words, 0)
    }

    /// [`Process::load`], of the process `number` of a model. What others than the first print is
    /// not told: it prints the same. The second takes the opposite of every bit that the Verilog
    /// leaves undefined, those behind take others.
    ///
    /// # Errors
    /// As [`Process::load`].
    pub(super) fn load_another(
        built: &Built,
        shared_words: u64,
        number: u32,
    ) -> Result<Process, CosimError> {
        let failed = |source| CosimError::Load { path: built.path.clone(), source };
        let mut process = Process::start(built, shared_words, number).map_err(failed)?;
        match process.answer() {
            Ok(()) => Ok(process),
            Err(reason) => Err(CosimError::Halted { when: When::Start, reason }),
        }
    }

    fn start(built: &Built, shared_words: u64, number: u32) -> io::Result<Process> {
        let shared =
            File::from(rustix::fs::memfd_create("goldtof", rustix::fs::MemfdFlags::CLOEXEC)?);
        shared.set_len(shared_words * size_of::<u64>() as u64)?;
        let (line, other_end) = UnixStream::pair()?;
        line.set_read_timeout(Some(LOOK_EVERY))?;
        line.set_write_timeout(Some(LOOK_EVERY))?;
        let (words, theirs) = io::pipe()?;
        // The command keeps its ends of the line and the pipe until it is dropped.
        let program = Program::start(
            Command::new(built.image.path())
                .arg0(&built.path)
                .arg(number.to_string())
                .stdin(OwnedFd::from(other_end))
                .stdout(shared.try_clone()?)
                .stderr(theirs),
        )?;
        let words =
            if number > 0 { pass_on(words, io::sink()) } else { pass_on(words, io::stderr()) };
        Ok(Process { program, line, shared, words })
    }

    /// Writes shared words from word `at` on.
    ///
    /// # Errors
    /// When the memory fails.
    pub(super) fn write<T: bytemuck::NoUninit>(&self, at: u64, words: &[T]) -> Result<(), String> {
        let written =
            self.shared.write_all_at(bytemuck::cast_slice(words), at * size_of::<u64>() as u64);
        written.map_err(|error| format!("the memory that it shares fails: {error}"))
    }

    /// Reads shared words from word `at` on.
    ///
    /// # Errors
    /// When the memory fails.
    pub fn read(&self, at: u64, words: &mut [u64]) -> Result<(), String> {
        let read = self
            .shared
            .read_exact_at(bytemuck::cast_slice_mut(words), at * size_of::<u64>() as u64);
        read.map_err(|error| format!("the memory that it shares fails: {error}"))
    }

    /// Sends a request; its answer is due.
    ///
    /// # Errors
    /// The reason when the model has ended.
    pub(super) fn ask(&mut self, what: u64, arguments: [u64; 5]) -> Result<(), String> {
        let mut request = [what; 6];
        request[1..].copy_from_slice(&arguments);
        let sent = self.line.write_all(bytemuck::bytes_of(&request));
        sent.map_err(|_| self.how_it_ended(true))
    }

    /// Waits for an answer.
    ///
    /// # Errors
    /// The reason when the model has ended.
    pub(super) fn answer(&mut self) -> Result<(), String> {
        let started = Instant::now();
        let mut header = [0u32; 2];
        self.hear(bytemuck::bytes_of_mut(&mut header), started)?;
        let [status, length] = header;
        if status == 0 {
            return Ok(());
        }
        let mut text = vec![0; length.min(MOST_TEXT_BYTES) as usize];
        self.hear(&mut text, started)?;
        self.how_it_ended(true);
        Err(String::from_utf8_lossy(&text).into_owned())
    }

    /// Reads from the line as long as the model is there and its time is not up.
    fn hear(&mut self, mut bytes: &mut [u8], started: Instant) -> Result<(), String> {
        while !bytes.is_empty() {
            match self.line.read(bytes) {
                Ok(0) => return Err(self.how_it_ended(true)),
                Ok(count) => bytes = &mut bytes[count..],
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    // One of its children may keep the line open.
                    if self.program.has_ended().unwrap_or(true) {
                        return Err(self.how_it_ended(true));
                    }
                    if started.elapsed() > time_limit() {
                        return Err(self.how_it_ended(false));
                    }
                }
                Err(_) => return Err(self.how_it_ended(true)),
            }
        }
        Ok(())
    }

    /// Ends the process, and waits for its last words and how it ended.
    fn how_it_ended(&mut self, in_time: bool) -> String {
        if !in_time {
            let _ = self.program.end();
            let limit = time_limit().as_secs_f64();
            return format!(
                "it has not answered for {limit} s, as Verilog in an endless loop does; a block has \
                 {BLOCK_CLOCKS} clocks, and --tool-timeout gives it more time"
            );
        }
        // Without this, it might be killed between its last words and its end.
        let started = Instant::now();
        while !self.program.has_ended().unwrap_or(true) && started.elapsed() < LAST_WORDS {
            thread::sleep(Duration::from_millis(1));
        }
        let status = self.program.end();
        let _ = self.words.recv_timeout(LAST_WORDS);
        match status.map(|status| (status.code(), status.signal())) {
            Ok((Some(code), _)) => format!("it ended its own process with exit status {code}"),
            Ok((None, Some(signal))) => {
                let name = signal_hook::low_level::signal_name(signal).unwrap_or("a signal");
                format!("its process was ended by {name} (signal {signal})")
            }
            _ => "its process is gone".to_owned(),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.program.end();
        // So that what it said does not come after what is said of it.
        let _ = self.words.recv_timeout(LAST_WORDS);
    }
}

/// Passes what the Verilog prints on, in a thread of its own, without what would steer a
/// terminal.
fn pass_on(
    mut words: impl io::Read + Send + 'static,
    mut to: impl io::Write + Send + 'static,
) -> Receiver<()> {
    let (closed, closing) = channel();
    thread::spawn(move || {
        // Moved in, and so dropped at the end.
        let _closed = closed;
        let mut bytes = [0; 8192];
        let mut previous = 0;
        loop {
            match words.read(&mut bytes) {
                Ok(0) => return,
                Ok(count) => {
                    let said = &mut bytes[..count];
                    for byte in &mut *said {
                        // Of one byte, or (0xc2 and) of two.
                        let steers = byte.is_ascii_control() && !matches!(byte, b'\n' | b'\t')
                            || previous == 0xc2 && (0x80..0xa0).contains(byte);
                        previous = *byte;
                        if steers {
                            *byte = b'?';
                        }
                    }
                    // Nobody may be there to read it, which is no reason to end.
                    let _ = to.write_all(said);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => return,
            }
        }
    });
    closing
}

//! A verilated model, as a process of its own.
//!
//! The Verilog may be a stranger's: it may end its process, crash, or never come
//! back, and print what it likes. `testbench/cosim.cpp` is the other side.
//!
//! Words go through a file in memory, which is written and read here and mapped
//! there: so nothing that the other side does to it reaches this one's memory.

use std::collections::VecDeque;
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
use crate::reference::predictor::Skip;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::layout::Layout;

/// Blocks that the model may have at once: one being clocked, one waiting.
pub const BLOCKS_AT_ONCE: usize = 2;

/// How often a model that does not answer is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// How long to wait for the last words of a model that has ended.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Most skips in a block.
const MOST_SKIPS: usize = BLOCK_CLOCKS as usize / 8;
/// Words of a skip: the clock in its block, and what goes into the two counters.
const SKIP_WORDS: usize = 3;

/// Longest text of an answer that is read.
const MOST_TEXT_BYTES: u32 = 1 << 16;

/// What the model is asked for; `testbench/cosim.cpp` has the same.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
enum What {
    Run = 0,
    RunBare = 1,
    Finish = 2,
}

/// One instance of a verilated model.
#[derive(Debug)]
pub struct Verilated {
    program: Program,
    line: UnixStream,
    shared: File,
    /// Closed when all that the model prints has been passed on.
    words: Receiver<()>,
    input_words: usize,
    output_words: usize,
    /// Whether its Verilog is the user's own.
    pub(super) is_users: bool,
    /// What moves its scan's counters on.
    registers: Option<ScanRegisters>,
    /// Where the next block goes.
    next_place: usize,
    /// Places and clocks of the blocks that it has.
    under_way: VecDeque<(usize, usize)>,
}

impl Verilated {
    /// Starts the program that [`super::build::build`] made for this layout.
    ///
    /// # Errors
    /// When it cannot be started, or ends before its first clock.
    pub fn load(built: &Built, layout: &Layout) -> Result<Verilated, CosimError> {
        let failed = |source| CosimError::Load {
            path: built.path.clone(),
            source,
        };
        let (input_words, output_words) = (layout.inputs.words, layout.outputs.words);
        let mut model = Verilated::start(built, input_words, output_words).map_err(failed)?;
        match model.answer() {
            Ok(()) => Ok(model),
            Err(reason) => Err(CosimError::Halted {
                when: When::Start,
                reason,
            }),
        }
    }

    fn start(built: &Built, input_words: usize, output_words: usize) -> io::Result<Verilated> {
        let shared = File::from(rustix::fs::memfd_create(
            "goldtof",
            rustix::fs::MemfdFlags::CLOEXEC,
        )?);
        let block_words = place_words(input_words, output_words);
        shared.set_len((BLOCKS_AT_ONCE * block_words * size_of::<u64>()) as u64)?;
        let (line, other_end) = UnixStream::pair()?;
        line.set_read_timeout(Some(LOOK_EVERY))?;
        line.set_write_timeout(Some(LOOK_EVERY))?;
        let (words, theirs) = io::pipe()?;
        // The command keeps its ends of the line and the pipe until it is dropped.
        let program = Program::start(
            Command::new(built.image.path())
                .arg0(&built.path)
                .stdin(OwnedFd::from(other_end))
                .stdout(shared.try_clone()?)
                .stderr(theirs),
        )?;
        Ok(Verilated {
            program,
            line,
            shared,
            words: pass_on(words),
            input_words,
            output_words,
            is_users: built.is_users,
            registers: built.registers.clone(),
            next_place: 0,
            under_way: VecDeque::new(),
        })
    }

    /// Hands over the input records of a block, one per clock, and does not wait
    /// for its end. At most [`BLOCKS_AT_ONCE`] may be under way. `skips` are those of
    /// the block, which begins with `first_clock`.
    ///
    /// # Errors
    /// The reason when the model has ended.
    ///
    /// # Panics
    /// When the block is too long, too many are under way, or there are skips of a
    /// model that was built without the scan's counters.
    pub fn submit(
        &mut self,
        input: &[u64],
        first_clock: u64,
        skips: &[Skip],
    ) -> Result<(), String> {
        let clocks = input.len() / self.input_words;
        assert_eq!(input.len(), clocks * self.input_words);
        assert!(clocks as u64 <= BLOCK_CLOCKS && self.under_way.len() < BLOCKS_AT_ONCE);
        let place = self.next_place;
        self.next_place = (place + 1) % BLOCKS_AT_ONCE;
        let written = self
            .shared
            .write_all_at(bytemuck::cast_slice(input), self.input_at(place));
        written.map_err(|error| format!("the memory that it shares fails: {error}"))?;
        self.write_skips(first_clock, skips, place)?;
        self.ask(What::Run, clocks as u64, place, skips.len())?;
        self.under_way.push_back((place, clocks));
        Ok(())
    }

    fn write_skips(
        &mut self,
        first_clock: u64,
        skips: &[Skip],
        place: usize,
    ) -> Result<(), String> {
        if skips.is_empty() {
            return Ok(());
        }
        assert!(skips.len() <= MOST_SKIPS);
        let registers = self.registers.as_mut().expect("a model with counters");
        let mut words = Vec::with_capacity(skips.len() * SKIP_WORDS);
        for skip in skips {
            let chips = registers.chips.as_mut();
            let groups = registers.groups.as_mut();
            words.extend([
                skip.clock - first_clock,
                chips.map_or(0, |register| register.difference(skip.chip, skip.chips)),
                groups.map_or(0, |register| register.difference(skip.group.0, skip.groups)),
            ]);
        }
        let written = self
            .shared
            .write_all_at(bytemuck::cast_slice(&words), self.skips_at(place));
        written.map_err(|error| format!("the memory that it shares fails: {error}"))
    }

    /// Waits for the end of the block that was handed over first, and writes its
    /// output records, one per clock.
    ///
    /// # Errors
    /// The reason when the model has ended.
    ///
    /// # Panics
    /// When no block is under way, or it has another length.
    pub fn collect(&mut self, output: &mut [u64]) -> Result<(), String> {
        let (place, clocks) = self.under_way.pop_front().expect("a block is under way");
        assert_eq!(output.len(), clocks * self.output_words);
        self.answer()?;
        let read = self
            .shared
            .read_exact_at(bytemuck::cast_slice_mut(output), self.output_at(place));
        read.map_err(|error| format!("the memory that it shares fails: {error}"))
    }

    /// Waits for the end of the blocks that are under way, and for nothing of what
    /// they give.
    pub fn discard(&mut self) {
        while self.under_way.pop_front().is_some() && self.answer().is_ok() {}
    }

    /// Runs clocks with one constant input record and reads nothing: the speed
    /// that co-simulation is measured against.
    ///
    /// # Errors
    /// As [`Verilated::collect`].
    ///
    /// # Panics
    /// When `input` is not one record.
    pub fn run_bare(&mut self, input: &[u64], clocks: u64) -> Result<(), String> {
        assert_eq!(input.len(), self.input_words);
        let written = self
            .shared
            .write_all_at(bytemuck::cast_slice(input), self.input_at(0));
        written.map_err(|error| error.to_string())?;
        self.ask(What::RunBare, clocks, 0, 0)?;
        self.answer()
    }

    /// Runs the final blocks. The last that may be asked for.
    ///
    /// # Errors
    /// The reason when one of them ends the simulation with more than `$finish`,
    /// which a final block may call.
    pub fn finish(&mut self) -> Result<(), String> {
        let asked = self.ask(What::Finish, 0, 0, 0);
        match asked.and_then(|()| self.answer()) {
            Err(reason) if !reason.starts_with("$finish") => Err(reason),
            _ => Ok(()),
        }
    }

    fn ask(&mut self, what: What, clocks: u64, place: usize, skips: usize) -> Result<(), String> {
        let word = |byte: u64| byte / size_of::<u64>() as u64;
        let request = [
            what as u64,
            clocks,
            word(self.input_at(place)),
            word(self.output_at(place)),
            word(self.skips_at(place)),
            skips as u64,
        ];
        let sent = self.line.write_all(bytemuck::bytes_of(&request));
        sent.map_err(|_| self.how_it_ended(true))
    }

    /// First byte of a place's inputs in the shared file.
    fn input_at(&self, place: usize) -> u64 {
        let words = place_words(self.input_words, self.output_words);
        (place * words * size_of::<u64>()) as u64
    }

    /// First byte of a place's skips.
    fn skips_at(&self, place: usize) -> u64 {
        self.output_at(place) + BLOCK_CLOCKS * (self.output_words * size_of::<u64>()) as u64
    }

    /// First byte of a place's outputs.
    fn output_at(&self, place: usize) -> u64 {
        self.input_at(place) + BLOCK_CLOCKS * (self.input_words * size_of::<u64>()) as u64
    }

    /// Waits for an answer.
    fn answer(&mut self) -> Result<(), String> {
        let started = Instant::now();
        let mut header = [0u32; 2];
        self.read(bytemuck::bytes_of_mut(&mut header), started)?;
        let [status, length] = header;
        if status == 0 {
            return Ok(());
        }
        let mut text = vec![0; length.min(MOST_TEXT_BYTES) as usize];
        self.read(&mut text, started)?;
        self.how_it_ended(true);
        Err(String::from_utf8_lossy(&text).into_owned())
    }

    /// Reads from the line as long as the model is there and its time is not up.
    fn read(&mut self, mut bytes: &mut [u8], started: Instant) -> Result<(), String> {
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

/// Words of a place in the shared file.
fn place_words(input_words: usize, output_words: usize) -> usize {
    BLOCK_CLOCKS as usize * (input_words + output_words) + MOST_SKIPS * SKIP_WORDS
}

impl Drop for Verilated {
    fn drop(&mut self) {
        let _ = self.program.end();
        // So that what it said does not come after what is said of it.
        let _ = self.words.recv_timeout(LAST_WORDS);
    }
}

/// Passes what the Verilog prints on to standard error, in a thread of its own,
/// without what would steer a terminal.
fn pass_on(mut words: impl io::Read + Send + 'static) -> Receiver<()> {
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
                    let _ = io::stderr().write_all(said);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => return,
            }
        }
    });
    closing
}

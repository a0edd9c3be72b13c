use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write};

use goldtof_wire::{Identity, Loss, ResultsFrame};
use thiserror::Error;

use crate::{PlacedCount, ResultOrder};

/// Where lines go: a file, which can be cut where the last whole line ends.
pub trait Sink: Write {
    /// Takes back what is behind the first `length` bytes.
    ///
    /// # Errors
    ///
    /// As of the file.
    fn cut(&mut self, length: u64) -> io::Result<()>;
}

impl Sink for File {
    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.seek(SeekFrom::Start(length)).map(drop)
    }
}

/// Something could not be written.
#[derive(Debug, Error)]
#[error("after {results} results, which are written: {error}")]
pub struct RecordError {
    /// Results that are in the file, whole.
    pub results: u64,
    /// What happened, a full disk for one.
    pub error: io::Error,
}

/// Writes counts as CSV, a line for each count, and losses into a file of their own. A frame is in the file
/// whole or not at all.
#[derive(Debug)]
pub struct Recorder<S> {
    counts: Lines<S>,
    losses: Losses<S>,
    order: ResultOrder,
    results: u64,
}

impl<S: Sink> Recorder<S> {
    /// Writes the headings.
    ///
    /// # Errors
    ///
    /// They cannot be written.
    pub fn new(counts: S, losses: S, identity: Identity) -> Result<Recorder<S>, RecordError> {
        let order = ResultOrder::new(identity);
        let total = if order.has_totals() { ",total_count" } else { "" };
        let heading = format!("time_s,scan,detector,phase_step,count{total}\n");
        let told = |error| RecordError { results: 0, error };
        let counts = Lines::new(counts, &heading).map_err(told)?;
        let losses = Losses::new(losses).map_err(told)?;
        Ok(Recorder { counts, losses, order, results: 0 })
    }

    /// Writes the results of a frame that came at `time_s` (seconds since 1970).
    ///
    /// # Errors
    ///
    /// They cannot be written; those before are.
    pub fn results(&mut self, frame: &ResultsFrame, time_s: f64) -> Result<(), RecordError> {
        let mut lines = String::new();
        self.order.rows(frame, |row| {
            let PlacedCount { scan, detector, phase_step, count, .. } = row;
            let _ = write!(lines, "{time_s:.6},{scan},{detector},{phase_step},{count}");
            if let Some(total) = row.total {
                let _ = write!(lines, ",{total}");
            }
            lines.push('\n');
        });
        self.counts.append(&lines).map_err(|error| RecordError { results: self.results, error })?;
        self.results += frame.results.len() as u64;
        Ok(())
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        self.order.interrupted();
    }

    /// Writes that something is missing.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    pub fn loss(&mut self, loss: &Loss, time_s: f64) -> Result<(), RecordError> {
        let written = self.losses.write(loss, self.order.scan(), time_s);
        written.map_err(|error| RecordError { results: self.results, error })
    }

    /// Results that are written.
    pub fn written(&self) -> u64 {
        self.results
    }

    /// The files.
    pub fn into_sinks(self) -> (S, S) {
        (self.counts.sink, self.losses.0.sink)
    }
}

/// What is missing, as CSV.
#[derive(Debug)]
pub struct Losses<S>(Lines<S>);

impl<S: Sink> Losses<S> {
    /// Writes the heading.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    pub fn new(sink: S) -> io::Result<Losses<S>> {
        Lines::new(sink, "time_s,scan,frames,results,dropped\n").map(Losses)
    }

    /// Writes what is missing before the next results of a scan.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    pub fn write(&mut self, loss: &Loss, scan: u64, time_s: f64) -> io::Result<()> {
        let results = loss.results.map_or(String::new(), |results| results.to_string());
        let (frames, dropped) = (loss.frames, loss.dropped);
        self.0.append(&format!("{time_s:.6},{scan},{frames},{results},{dropped}\n"))
    }
}

/// Lines of a file, each of which is there whole or not at all.
#[derive(Debug)]
struct Lines<S> {
    sink: S,
    bytes: u64,
}

impl<S: Sink> Lines<S> {
    fn new(sink: S, heading: &str) -> io::Result<Lines<S>> {
        let mut lines = Lines { sink, bytes: 0 };
        lines.append(heading)?;
        Ok(lines)
    }

    fn append(&mut self, lines: &str) -> io::Result<()> {
        if let Err(error) = self.sink.write_all(lines.as_bytes()).and_then(|()| self.sink.flush()) {
            // A half line is worse than none. If even that fails, the first error says why.
            let _ = self.sink.cut(self.bytes);
            return Err(error);
        }
        self.bytes += lines.len() as u64;
        Ok(())
    }
}

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write};

use goldtof_wire::{Identity, Loss, ResultsFrame};
use thiserror::Error;

use crate::{Places, Row};

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
    counts: S,
    losses: S,
    places: Places,
    counts_bytes: u64,
    losses_bytes: u64,
    results: u64,
}

impl<S: Sink> Recorder<S> {
    /// Writes the headings.
    ///
    /// # Errors
    ///
    /// They cannot be written.
    pub fn new(counts: S, losses: S, identity: Identity) -> Result<Recorder<S>, RecordError> {
        let mut recorder = Recorder {
            counts,
            losses,
            places: Places::new(identity),
            counts_bytes: 0,
            losses_bytes: 0,
            results: 0,
        };
        let total = if recorder.places.has_totals() { ",total_count" } else { "" };
        recorder.append_counts(&format!("time_s,scan,detector,phase_step,count{total}\n"), 0)?;
        recorder.append_loss("time_s,scan,frames,results,dropped\n")?;
        Ok(recorder)
    }

    /// Writes the results of a frame that came at `time_s` (seconds since 1970).
    ///
    /// # Errors
    ///
    /// They cannot be written; those before are.
    pub fn results(&mut self, frame: &ResultsFrame, time_s: f64) -> Result<(), RecordError> {
        let mut lines = String::new();
        self.places.rows(frame, |row| {
            let Row { scan, detector, phase_step, count, .. } = row;
            let _ = write!(lines, "{time_s:.6},{scan},{detector},{phase_step},{count}");
            if let Some(total) = row.total {
                let _ = write!(lines, ",{total}");
            }
            lines.push('\n');
        });
        self.append_counts(&lines, frame.results.len() as u64)
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        self.places.interrupted();
    }

    /// Writes that something is missing.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    pub fn loss(&mut self, loss: &Loss, time_s: f64) -> Result<(), RecordError> {
        let results = loss.results.map_or(String::new(), |results| results.to_string());
        self.append_loss(&format!(
            "{time_s:.6},{},{},{results},{}\n",
            self.places.scan(),
            loss.frames,
            loss.dropped
        ))
    }

    /// Results that are written.
    pub fn written(&self) -> u64 {
        self.results
    }

    /// The files.
    pub fn into_sinks(self) -> (S, S) {
        (self.counts, self.losses)
    }

    fn append_counts(&mut self, lines: &str, results: u64) -> Result<(), RecordError> {
        append(&mut self.counts, &mut self.counts_bytes, lines)
            .map_err(|error| RecordError { results: self.results, error })?;
        self.results += results;
        Ok(())
    }

    fn append_loss(&mut self, line: &str) -> Result<(), RecordError> {
        append(&mut self.losses, &mut self.losses_bytes, line)
            .map_err(|error| RecordError { results: self.results, error })
    }
}

/// Appends whole lines, or nothing.
fn append(sink: &mut impl Sink, bytes: &mut u64, lines: &str) -> io::Result<()> {
    if let Err(error) = sink.write_all(lines.as_bytes()).and_then(|()| sink.flush()) {
        // A half line is worse than none. If even that fails, the first error says why.
        let _ = sink.cut(*bytes);
        return Err(error);
    }
    *bytes += lines.len() as u64;
    Ok(())
}

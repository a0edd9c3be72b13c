//! Counts as a folder of Parquet files, which every reader takes as one table. A Parquet file is none before its last
//! byte is there, so each part is written whole under a hidden name and renamed: whatever happens, all parts
//! before can be read. The room for a part is taken before its results come, so that a disk that is full says so
//! while all of them still have a place.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use goldtof::report::parquet::{self, ParquetFailed};
use goldtof::report::table::Table;
use goldtof::version::VERSION;
use goldtof_device::{Losses, PlacedCount, RecordError, ResultOrder, hexadecimal};
use goldtof_wire::{Identity, Loss, ResultsFrame};
use rustix::fs::{FallocateFlags, fallocate};

/// Most rows of a part, and the longest time that rows wait for the rest of it.
const ROWS: usize = 1 << 17;
const WAITS: Duration = Duration::from_secs(10);

/// Most bytes of a part, of eight-byte numbers in six columns: each as it is, or as a place (at most three bytes) in a
/// dictionary, which ends at 1 MiB; and what the file says of itself.
const MOST_BYTES: u64 = 6 * (ROWS as u64 * (8 + 3) + (1 << 20)) + (1 << 20);

/// The hidden name of the part that comes next.
const NEXT: &str = ".next.parquet";

/// A folder of Parquet files in the making.
pub(crate) struct Parts {
    folder: PathBuf,
    losses: Losses<File>,
    order: ResultOrder,
    about: String,
    /// Rows that wait, with the time of each; and when the first of them came.
    rows: Vec<(f64, PlacedCount)>,
    since: Instant,
    /// The file with room for them.
    next: File,
    part: u32,
    /// Results that are written, and those that wait.
    written: u64,
    waiting: u64,
}

impl Parts {
    /// Makes the folder, and takes the first part's room.
    pub fn new(folder: &Path, losses: File, identity: Identity) -> Result<Parts, RecordError> {
        let told = |error| RecordError { results: 0, error };
        fs::create_dir(folder).map_err(told)?;
        let next = with_room(folder).map_err(told)?;
        Ok(Parts {
            folder: folder.to_owned(),
            losses: Losses::new(losses).map_err(told)?,
            order: ResultOrder::new(identity),
            about: about(&identity),
            rows: Vec::with_capacity(ROWS),
            since: Instant::now(),
            next,
            part: 0,
            written: 0,
            waiting: 0,
        })
    }

    /// Takes the results of a frame that came at `time_s` (seconds since 1970).
    pub fn results(&mut self, frame: &ResultsFrame, time_s: f64) -> Result<(), RecordError> {
        if self.rows.is_empty() {
            self.since = Instant::now();
        }
        self.order.rows(frame, |row| self.rows.push((time_s, row)));
        self.waiting += frame.results.len() as u64;
        // A frame has at most 255 results of 64 counts.
        if self.rows.len() > ROWS - 255 * 64 { self.write() } else { self.write_if_due() }
    }

    /// Writes that something is missing.
    pub fn loss(&mut self, loss: &Loss, time_s: f64) -> Result<(), RecordError> {
        let written = self.losses.write(loss, self.order.scan(), time_s);
        written.map_err(|error| self.told(error))
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        self.order.interrupted();
    }

    /// Results that are in whole files.
    pub fn written(&self) -> u64 {
        self.written
    }

    /// Writes what waits, if it has waited for long.
    pub fn write_if_due(&mut self) -> Result<(), RecordError> {
        let is_due = !self.rows.is_empty() && self.since.elapsed() >= WAITS;
        if is_due { self.write() } else { Ok(()) }
    }

    /// Writes what waits; nothing comes after it.
    pub fn end(&mut self) -> Result<(), RecordError> {
        self.finish().map_err(|error| self.told(error))
    }

    /// Writes a part, and takes the room of the next one.
    fn write(&mut self) -> Result<(), RecordError> {
        let written = self.finish().and_then(|()| {
            self.next = with_room(&self.folder)?;
            Ok(())
        });
        written.map_err(|error| self.told(error))
    }

    /// Writes the rows that wait into their room.
    fn finish(&mut self) -> io::Result<()> {
        let next = self.folder.join(NEXT);
        if self.rows.is_empty() {
            return match fs::remove_file(next) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
                _ => Ok(()),
            };
        }
        if let Err(error) = self.fill() {
            // Half a file is none.
            let _ = fs::remove_file(next);
            return Err(error);
        }
        fs::rename(next, self.folder.join(format!("{:06}.parquet", self.part)))?;
        self.part += 1;
        self.written += std::mem::take(&mut self.waiting);
        self.rows.clear();
        Ok(())
    }

    /// Writes the rows into the file that has room for them, and gives back what they leave.
    fn fill(&mut self) -> io::Result<()> {
        let tables = std::iter::once(Ok::<Table, ParquetFailed>(table(&self.rows)));
        parquet::write(BufWriter::new(&self.next), "counts", &self.about, &table(&[]), tables)
            .map_err(io::Error::other)?;
        let length = self.next.stream_position()?;
        self.next.set_len(length)?;
        self.next.sync_all()
    }

    fn told(&self, error: io::Error) -> RecordError {
        RecordError { results: self.written, error }
    }
}

/// A file with room for a part.
fn with_room(folder: &Path) -> io::Result<File> {
    let file = OpenOptions::new().write(true).create_new(true).open(folder.join(NEXT))?;
    match fallocate(&file, FallocateFlags::empty(), 0, MOST_BYTES) {
        Ok(()) => Ok(file),
        // The file system cannot promise it: the part may fail when it is written.
        Err(rustix::io::Errno::OPNOTSUPP) => Ok(file),
        Err(error) => {
            // What is told is that there is no room.
            let _ = fs::remove_file(folder.join(NEXT));
            Err(error.into())
        }
    }
}

/// The rows in columns; without total counts, these are null.
fn table(rows: &[(f64, PlacedCount)]) -> Table {
    Table::of(rows)
        .column("time_s", |row| row.0)
        .column("scan", |row| row.1.scan)
        .column("detector", |row| row.1.detector)
        .column("phase_step", |row| row.1.phase_step)
        .column("count", |row| row.1.count)
        .column("total_count", |row| row.1.total)
        .table()
}

/// What each file says of itself, as JSON.
fn about(identity: &Identity) -> String {
    let (scene, period_fs) = (hexadecimal(&identity.scene), identity.chip_period_fs);
    format!(
        "{{\"goldtof\": \"{VERSION}\", \"scene_sha256_begins\": \"{scene}\", \"chip_period_fs\": {period_fs}, \
         \"samples_per_chip\": {}, \"units\": {{\"time_s\": \"s\"}}}}",
        identity.samples_per_chip
    )
}

//! The folder of a sweep: what it is, and the points that are done.

use std::borrow::Cow;

use super::points::{Sweep, SweepOptions};
use super::table::empty;
use crate::differences::{differences, other_version};
use crate::document::Document;
use crate::files::{FileError, Log, OutputFolder, read_regular};
use crate::printable::printable_path;
use crate::report::table::Table;

/// What the sweep of a folder is.
const DEFINITION: &str = "sweep.json";
/// Its points that are done, a line each: its number and its rows as CSV.
const POINTS: &str = "points.log";
/// Largest definition that is read back.
const MOST_BYTES: u64 = 64 << 20;
/// In place of a line of a point that is not done.
const NOWHERE: u64 = u64::MAX;

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// What is there cannot be read.
    #[error(
        "{path}: cannot read what the sweep left there: {reason}; remove the folder, or name another"
    )]
    Unreadable {
        /// The file.
        path: String,
        /// Why not.
        reason: String,
    },
    /// Another sweep's points are there.
    #[error(
        "{path} has the points of another sweep: {differences} (there: in that folder); name \
         another folder with --out, or remove this one to begin anew"
    )]
    Other {
        /// The folder.
        path: String,
        /// What differs.
        differences: String,
    },
}

/// The points of a sweep that are done, in one file that only grows. A place of 8 bytes for each
/// point is all that is held of them.
pub struct Store {
    log: Log,
    path: String,
    /// Where the line of each point stands.
    places: Vec<u64>,
}

impl Store {
    /// Takes a folder for a sweep: an empty one, or one with its points. `command` is that of the
    /// run that begins the sweep.
    ///
    /// # Errors
    /// When it has another sweep's, or a file cannot be read or written.
    pub fn open(folder: &OutputFolder, sweep: &Sweep, command: &str) -> Result<Store, StoreError> {
        let definition = sweep.definition(command);
        let path = folder.join(DEFINITION);
        let unreadable =
            |reason: String| StoreError::Unreadable { path: printable_path(&path), reason };
        if path.exists() {
            let text =
                read_regular(&path, MOST_BYTES).map_err(|error| unreadable(error.to_string()))?;
            let there: Document<SweepOptions> =
                serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
            let mut differences = differences(&bare(&definition), &bare(&there));
            differences.extend(other_version(&definition.goldtof, &there.goldtof));
            if !differences.is_empty() {
                let path = printable_path(folder.path());
                return Err(StoreError::Other { path, differences: differences.join("; ") });
            }
        } else {
            let text = serde_json::to_string_pretty(&definition)
                .map_err(|error| unreadable(error.to_string()))?;
            // Points of nobody knows what.
            folder.remove(POINTS)?;
            folder.sync()?;
            folder.write(DEFINITION, &(text + "\n"))?;
        }
        let path = printable_path(&folder.join(POINTS));
        let mut places = vec![NOWHERE; sweep.len()];
        let mut unknown = None;
        let log = Log::open(folder, POINTS, |place, text| {
            let number = read_line(text).map(|(number, _)| number);
            match number.and_then(|number| places.get_mut(number)) {
                Some(known) => *known = place,
                None => unknown = Some(place),
            }
        })?;
        match unknown {
            None => Ok(Store { log, path, places }),
            Some(place) => {
                let reason = format!("the line at byte {place} has no point of this sweep");
                Err(StoreError::Unreadable { path, reason })
            }
        }
    }

    /// How many points are done.
    pub fn done(&self) -> usize {
        self.places.iter().filter(|&&place| place != NOWHERE).count()
    }

    /// Whether a point is done.
    pub fn has(&self, number: usize) -> bool {
        self.places.get(number).is_some_and(|&place| place != NOWHERE)
    }

    /// Keeps finished points, each with its rows as CSV. No kill takes them away from then on;
    /// a power cut may take those of the last second, until [`Store::sync`].
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn keep(&mut self, points: &[(usize, String)]) -> Result<(), StoreError> {
        let lines = points.iter().map(|point| serde_json::to_string(point).unwrap_or_default());
        let lines: Vec<String> = lines.collect();
        let places = self.log.append(lines.iter().map(String::as_str))?;
        for ((number, _), place) in points.iter().zip(places) {
            self.places[*number] = place;
        }
        Ok(())
    }

    /// Waits until all points that are done are on the disk.
    ///
    /// # Errors
    /// When they cannot be written there.
    pub fn sync(&mut self) -> Result<(), StoreError> {
        Ok(self.log.sync()?)
    }

    /// The rows of a point that is done, as CSV without a heading.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn rows_csv(&self, number: usize) -> Result<String, StoreError> {
        let line = self.log.line(self.places[number])?;
        let rows = read_line(&line).map(|(_, rows)| rows);
        rows.ok_or_else(|| self.unreadable(number, "it has no rows"))
    }

    /// The rows of some points that are done.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn table(
        &self,
        sweep: &Sweep,
        numbers: impl Iterator<Item = usize>,
    ) -> Result<Table, StoreError> {
        let mut table = empty(&sweep.options.over);
        for number in numbers {
            let read = table.read_rows(&self.rows_csv(number)?);
            read.map_err(|reason| self.unreadable(number, &reason.to_string()))?;
        }
        Ok(table)
    }

    fn unreadable(&self, number: usize, reason: &str) -> StoreError {
        StoreError::Unreadable {
            path: self.path.clone(),
            reason: format!("point {number}: {reason}"),
        }
    }

    /// Removes all that a sweep has in `folder`, if it has anything: the points stand
    /// elsewhere.
    ///
    /// # Errors
    /// When a file cannot be removed.
    pub fn clear(folder: &OutputFolder) -> Result<(), StoreError> {
        folder.remove(POINTS)?;
        Ok(folder.remove(DEFINITION)?)
    }
}

/// What two runs of one sweep have in common, but for the version.
fn bare(definition: &Document<SweepOptions>) -> Document<SweepOptions> {
    Document { goldtof: Cow::Borrowed(""), command: String::new(), ..definition.clone() }
}

fn read_line(text: &str) -> Option<(usize, String)> {
    serde_json::from_str(text).ok()
}

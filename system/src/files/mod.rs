//! Files that are there whole or not at all, whatever happens to the run.
//!
//! A file is written under a hidden name beside its own ([`stage`]) and renamed
//! when it is complete. The hidden name follows from the file's, and whoever
//! writes it holds a lock, so that two runs do not mix and what a killed run
//! left is taken over by the next one. An [`OutputFolder`] is locked as a
//! whole: its files are those of one run.
//!
//! What stands under a name that others can foresee is never followed, shortened
//! or waited for ([`open_ours`]), and what has its name is on the disk.

mod durable;
mod folder;
mod guarded;
mod log;
mod private;
mod read;
mod staged;
mod target;

use std::io;
use std::path::{Path, PathBuf};

use crate::printable::printable_path;

pub use folder::OutputFolder;
pub use guarded::open_ours;
pub use log::Log;
pub use private::{check_private, private_folder};
pub use read::{read_bytes, read_regular, read_text, utf8_text};
pub use staged::check_target;
pub use staged::{Staged, stage, sync_all};

/// A file or folder that could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}: {source}", printable_path(path))]
pub struct FileError {
    /// The file or folder, under the name that the user gave it.
    pub path: PathBuf,
    /// What could not be done.
    pub problem: &'static str,
    /// The system's answer.
    pub source: io::Error,
}

/// Writes a text into a file of its own.
///
/// # Errors
/// When it cannot be written. What was there before is there then.
pub fn write(path: &Path, text: &str) -> Result<(), FileError> {
    stage(path, |out| out.write_all(text.as_bytes()))?.publish()
}

/// Makes a folder, and those above it, when missing; without a lock, for files of which
/// each appears whole.
///
/// # Errors
/// When it cannot be made.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    durable::make_folders(path).map_err(FileError::new(path, "cannot make the folder"))
}

impl FileError {
    fn new(path: &Path, problem: &'static str) -> impl FnOnce(io::Error) -> FileError {
        move |source| FileError { path: path.to_owned(), problem, source }
    }
}

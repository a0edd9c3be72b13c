//! What stands under the name that a file is to get.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{FileTypeExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};

use super::guarded::{flags, kind_of};

/// As the kernel's own limit.
const MOST_LINKS: u32 = 40;

/// Whose choice a file's name is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NameOrigin {
    /// The user's: a link is followed, because it is its target that the user
    /// means, and a device or a pipe is written as it stands.
    Given,
    /// Ours, in the user's folder: a link is replaced and not followed, because
    /// nobody asked for a file elsewhere.
    Ours,
}

/// Where a file goes.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum FileTarget {
    /// To this name, by a rename.
    File(PathBuf),
    /// Into this device or pipe, byte by byte.
    Stream(PathBuf),
}

impl FileTarget {
    /// Finds out without opening anything.
    ///
    /// # Errors
    /// When a file cannot stand there.
    pub fn of(path: &Path, name: NameOrigin) -> io::Result<FileTarget> {
        let found = match name {
            NameOrigin::Given => fs::metadata(path),
            NameOrigin::Ours => fs::symlink_metadata(path),
        };
        let found = match found {
            Ok(found) => found,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(FileTarget::File(where_it_leads(path)?));
            }
            Err(error) => return Err(error),
        };
        let kind = found.file_type();
        let is_stream = kind.is_char_device() || kind.is_fifo();
        match name {
            _ if kind.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            NameOrigin::Given if kind.is_file() => Ok(FileTarget::File(fs::canonicalize(path)?)),
            NameOrigin::Given if is_stream => Ok(FileTarget::Stream(path.to_owned())),
            NameOrigin::Ours if kind.is_file() || kind.is_symlink() => {
                Ok(FileTarget::File(path.to_owned()))
            }
            _ => Err(io::Error::other(format!(
                "{} is there, which goldtof does not replace",
                kind_of(&found)
            ))),
        }
    }
}

/// The file that is to be made: `path`, or what it leads to if it is a link.
fn where_it_leads(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(target) => {
                path.pop();
                path.push(target);
            }
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("its links lead nowhere"))
}

/// Opens a device or pipe, without waiting for somebody who reads it.
///
/// # Errors
/// When it cannot be written, or nobody reads the pipe.
pub(super) fn open_stream(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new()
        .write(true)
        .custom_flags(flags(OFlags::NONBLOCK | OFlags::NOCTTY))
        .open(path)
        .map_err(|error| match error.raw_os_error() {
            Some(code) if code == rustix::io::Errno::NXIO.raw_os_error() => {
                io::Error::other("nobody reads this pipe")
            }
            _ => error,
        })?;
    // A reader that is there may be slow.
    fcntl_setfl(&file, fcntl_getfl(&file)? - OFlags::NONBLOCK)?;
    Ok(file)
}

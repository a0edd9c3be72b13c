//! Text files of bounded size.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;

use rustix::fs::OFlags;

use super::guarded::flags;

/// Reads a text file of at most `most_bytes`: a device without end, or a file
/// that cannot be meant, must not fill the memory.
///
/// # Errors
/// When it cannot be read, is larger, or is not UTF-8.
pub fn read_text(path: &Path, most_bytes: u64) -> io::Result<String> {
    utf8_text(read_bytes(path, most_bytes)?)
}

/// [`read_text`] of a file that need not be text.
///
/// # Errors
/// When it cannot be read, or is larger.
pub fn read_bytes(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    bytes_of(File::open(path)?, most_bytes)
}

/// [`read_text`] of a file, but neither of a folder nor of a pipe that nobody may
/// ever fill.
///
/// # Errors
/// As [`read_text`], and when it is not a regular file.
pub fn read_regular(path: &Path, most_bytes: u64) -> io::Result<String> {
    let file = OpenOptions::new()
        .read(true)
        .custom_flags(flags(OFlags::NONBLOCK | OFlags::NOCTTY))
        .open(path)?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    utf8_text(bytes_of(file, most_bytes)?)
}

fn bytes_of(file: File, most_bytes: u64) -> io::Result<Vec<u8>> {
    let length = file.metadata()?.len().min(most_bytes);
    let mut bytes = Vec::with_capacity(length as usize + 1);
    file.take(most_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        let mebibytes = most_bytes >> 20;
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it has more than {mebibytes} MiB, the most that is read"),
        ));
    }
    Ok(bytes)
}

/// The text that bytes are.
///
/// # Errors
/// When they are not UTF-8, with the byte at which that shows.
pub fn utf8_text(bytes: Vec<u8>) -> io::Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        io::Error::new(
            io::ErrorKind::InvalidData,
            format!("it is not UTF-8 text: byte {at} begins no character"),
        )
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_file_is_read_up_to_the_bound_and_not_beyond() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "0123456789").unwrap();
        assert_eq!(read_text(&path, 10).unwrap(), "0123456789");
        let error = read_text(&path, 9).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert!(read_text(Path::new("/dev/zero"), 1 << 20).is_err());
    }

    #[test]
    fn bytes_that_are_no_text_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, b"ab\xff").unwrap();
        let error = read_text(&path, 10).unwrap_err().to_string();
        assert!(error.contains("byte 2"), "{error}");
    }
}

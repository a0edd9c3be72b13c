//! A file that grows by whole lines.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::FileError;
use super::durable::sync_file;
use super::folder::OutputFolder;
use super::guarded::open_ours;
use crate::digest::sha256;

/// Longest line.
const MOST_BYTES: u64 = 16 << 20;
/// Digits of a line's check.
const DIGITS: usize = 16;
/// A power cut loses no more than what was appended in this time.
const SYNC_EVERY: Duration = Duration::from_secs(1);
/// Bytes of a line that are read at once.
const PIECE: usize = 1024;

/// A file of an [`OutputFolder`] that only grows. Each line begins with a check, the first half
/// of its SHA-256's digits; a last line that was torn by a kill or a power cut is dropped when
/// the file is opened.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
    end: u64,
    synced: Instant,
}

impl Log {
    /// Opens the file `name` of a folder, which is made when missing. `on_line` gets the place
    /// and the text of each line.
    ///
    /// # Errors
    /// When it cannot be read, or a line but the last is not what was written.
    pub fn open(
        folder: &OutputFolder,
        name: &str,
        mut on_line: impl FnMut(u64, &str),
    ) -> Result<Log, FileError> {
        let path = folder.join(name);
        let read = read(&path, &mut on_line);
        let (file, end) = read.map_err(FileError::new(&path, "cannot read the file"))?;
        folder.sync()?;
        Ok(Log { path, file, end, synced: Instant::now() })
    }

    /// Appends lines, whose texts have no line ends, and gives their places.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn append<'t>(
        &mut self,
        texts: impl IntoIterator<Item = &'t str>,
    ) -> Result<Vec<u64>, FileError> {
        let mut lines = String::new();
        let mut places = Vec::new();
        for text in texts {
            places.push(self.end + lines.len() as u64);
            lines += &format!("{} {text}\n", check(text));
        }
        // What is written in part is written over, or dropped as torn.
        let written = self.file.write_all_at(lines.as_bytes(), self.end);
        written.map_err(FileError::new(&self.path, "cannot write the file"))?;
        self.end += lines.len() as u64;
        if self.synced.elapsed() >= SYNC_EVERY {
            self.sync()?;
        }
        Ok(places)
    }

    /// Waits until all lines are on the disk.
    ///
    /// # Errors
    /// When they cannot be written there.
    pub fn sync(&mut self) -> Result<(), FileError> {
        self.synced = Instant::now();
        sync_file(&self.file).map_err(FileError::new(&self.path, "cannot write the file"))
    }

    /// The text of the line at a place.
    ///
    /// # Errors
    /// When it cannot be read, or is not what was written.
    pub fn line(&self, place: u64) -> Result<String, FileError> {
        let mut line = Vec::new();
        let mut piece = [0; PIECE];
        let read = loop {
            match self.file.read_at(&mut piece, place + line.len() as u64) {
                Ok(0) => break Err(changed(place)),
                Ok(length) => line.extend_from_slice(&piece[..length]),
                Err(error) => break Err(error),
            }
            if let Some(end) = line.iter().position(|&byte| byte == b'\n') {
                break checked(&line[..=end]).map(str::to_owned).ok_or_else(|| changed(place));
            }
        };
        read.map_err(FileError::new(&self.path, "cannot read the file"))
    }
}

/// Reads all lines of a file, and cuts off a torn last one. Gives where they end.
fn read(path: &Path, on_line: &mut impl FnMut(u64, &str)) -> io::Result<(File, u64)> {
    let file = open_ours(path, 0o666)?;
    let mut reader = BufReader::new(&file);
    let (mut end, mut line) = (0, Vec::new());
    loop {
        line.clear();
        let length = reader.by_ref().take(MOST_BYTES).read_until(b'\n', &mut line)?;
        match checked(&line) {
            Some(text) => on_line(end, text),
            None if reader.fill_buf()?.is_empty() => break,
            None => return Err(changed(end)),
        }
        end += length as u64;
    }
    drop(reader);
    file.set_len(end)?;
    Ok((file, end))
}

fn changed(place: u64) -> io::Error {
    let reason = format!(
        "the line at byte {place} is not what was written; remove the folder, or name another"
    );
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

fn check(text: &str) -> String {
    sha256(text)[..DIGITS].to_owned()
}

/// The text of a line, if it is whole.
fn checked(line: &[u8]) -> Option<&str> {
    let line = std::str::from_utf8(line).ok()?.strip_suffix('\n')?;
    let (told, text) = line.split_once(' ')?;
    (told == check(text)).then_some(text)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_torn_last_line_is_dropped_and_any_other_change_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(folder.path(), |_| ()).unwrap();
        let open = || {
            let mut lines = Vec::new();
            let opened =
                Log::open(&folder, "log", |place, text| lines.push((place, text.to_owned())));
            opened.map(|log| (log, lines)).map_err(|error| error.to_string())
        };
        let texts = ["first", "", "\u{e4} and more", &"long".repeat(PIECE)];
        let (mut log, before) = open().unwrap();
        assert!(before.is_empty());
        let mut places = log.append(texts[..1].iter().copied()).unwrap();
        places.extend(log.append(texts[1..].iter().copied()).unwrap());
        let whole = fs::read(folder.join("log")).unwrap();
        let ends: Vec<usize> = places.iter().skip(1).map(|&place| place as usize).collect();
        // Cut off anywhere, even within a character, it has the lines before the cut.
        for cut in (0..ends[2] + 30).chain([whole.len() - 1, whole.len()]) {
            fs::write(folder.join("log"), &whole[..cut]).unwrap();
            let (mut log, lines) = open().unwrap();
            let kept = ends.iter().chain([&whole.len()]).filter(|&&end| end <= cut).count();
            let expected = places.iter().copied().zip(texts.map(str::to_owned)).take(kept);
            assert_eq!(lines, expected.collect::<Vec<_>>(), "{cut}");
            // What follows is whole again.
            log.append(texts[kept..].iter().copied()).unwrap();
            assert_eq!(fs::read(folder.join("log")).unwrap(), whole, "{cut}");
            for (&place, text) in places.iter().zip(texts) {
                assert_eq!(log.line(place).unwrap(), text);
            }
        }
        // A disk that lost a stretch of zeros at the end.
        fs::write(folder.join("log"), [&whole[..], &[0; 4096]].concat()).unwrap();
        assert_eq!(open().unwrap().1.len(), texts.len());
        // One other bit before the last line is not a torn end.
        for at in [0, DIGITS, DIGITS + 1, ends[0] + 3, ends[1] + DIGITS + 2] {
            let mut other = whole.clone();
            other[at] ^= 1;
            fs::write(folder.join("log"), &other).unwrap();
            let told = open().err().unwrap();
            assert!(told.contains("is not what was written; remove the folder"), "{at}: {told}");
            assert_eq!(fs::read(folder.join("log")).unwrap(), other, "it is left as it is");
        }
    }
}

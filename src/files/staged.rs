//! One file: hidden until it is whole.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::FileError;
use crate::interrupt::Unfinished;

/// A complete file that does not yet have its name; dropped, it is gone.
#[derive(Debug)]
pub struct Staged {
    path: PathBuf,
    /// Removes the hidden file, unless it has been renamed. `None` for a device
    /// or a pipe, which is written as it stands.
    hidden: Option<Unfinished>,
    /// Holds the lock until the file has its name.
    _file: File,
}

/// Writes a file under a hidden name beside `path`; [`Staged::publish`] gives it
/// its name. A path that is a device or a pipe is written at once.
///
/// # Errors
/// When it cannot be written. Nothing is left behind.
pub fn stage(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<Staged, FileError> {
    let failed = |source| FileError::new(path, "cannot write the file")(source);
    let (file, hidden) = match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            return Err(failed(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        Ok(found) if !found.is_file() => {
            let file = OpenOptions::new().write(true).open(path).map_err(failed)?;
            (file, None)
        }
        _ => {
            let (file, hidden) = open_hidden(path).map_err(failed)?;
            (file, Some(hidden))
        }
    };
    let mut out = BufWriter::new(file);
    // Declared after the open file, so that it is removed before its lock is
    // given up.
    let hidden = hidden;
    fill(&mut out).map_err(failed)?;
    let file = out
        .into_inner()
        .map_err(|error| failed(error.into_error()))?;
    Ok(Staged {
        path: path.to_owned(),
        hidden,
        _file: file,
    })
}

impl Staged {
    /// Gives the file its name, in place of what stood there.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn publish(self) -> Result<(), FileError> {
        let Some(hidden) = self.hidden else {
            return Ok(());
        };
        // A link is followed: it is its target that the user means.
        let target = fs::canonicalize(&self.path).unwrap_or_else(|_| self.path.clone());
        hidden
            .rename(&target)
            .map_err(FileError::new(&self.path, "cannot write the file"))
    }
}

/// Opens the hidden file of `path`, empty and locked.
fn open_hidden(path: &Path) -> io::Result<(File, Unfinished)> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
    let mut hidden_name = std::ffi::OsString::from(".");
    hidden_name.push(name);
    hidden_name.push(".goldtof-partial");
    let hidden = target.with_file_name(hidden_name);
    loop {
        let file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&hidden)?;
        match file.lock() {
            // Some network file systems have no locks; then there is none.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => return Err(error),
            _ => {}
        }
        // While this run waited, the one before may have renamed or removed it.
        if is_at(&file, &hidden)? {
            let unfinished = Unfinished::new(&hidden);
            file.set_len(0)?;
            return Ok((file, unfinished));
        }
    }
}

/// Whether the open file is the one that has the name `path`.
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    let opened = file.metadata()?;
    match fs::symlink_metadata(path) {
        Ok(named) => Ok((named.dev(), named.ino()) == (opened.dev(), opened.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::super::write;
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_has_its_name_only_when_it_is_published() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let staged = stage(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        staged.publish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_file_that_cannot_be_filled_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let full = stage(&path, |out| {
            out.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(full.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_a_killed_run_left_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join(".a.txt.goldtof-partial");
        fs::write(&left, "half of something longer").unwrap();
        write(&folder.path().join("a.txt"), "new").unwrap();
        assert_eq!(names(folder.path()), ["a.txt"]);
        assert_eq!(
            fs::read_to_string(folder.path().join("a.txt")).unwrap(),
            "new"
        );
    }

    #[test]
    fn writers_at_once_do_not_mix() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let texts: Vec<String> = (0..8)
            .map(|i| i.to_string().repeat(100_000 + i * 1_000))
            .collect();
        std::thread::scope(|scope| {
            for text in &texts {
                scope.spawn(|| write(&path, text).unwrap());
            }
        });
        assert!(texts.contains(&fs::read_to_string(&path).unwrap()));
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn links_are_followed_and_devices_written_as_they_stand() {
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.txt"), folder.path().join("link"));
        fs::write(&path, "old").unwrap();
        symlink("a.txt", &link).unwrap();
        write(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");

        let device = folder.path().join("null");
        symlink("/dev/null", &device).unwrap();
        write(&device, "gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        let error = write(folder.path(), "a folder").unwrap_err().to_string();
        assert!(error.contains("is a directory"), "{error}");
    }
}

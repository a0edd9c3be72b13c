//! One file: hidden until it is whole.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::thread;

use super::FileError;
use super::durable::{sync_file, sync_folder};
use super::guarded::open_ours;
use super::target::{FileTarget, NameOrigin, open_stream};
use crate::interrupt::Unfinished;
use crate::printable::printable_path;

/// How often a hidden file may vanish before its lock is had.
const MOST_TRIES: u32 = 1000;

/// A complete file that does not yet have its name; dropped, it is gone.
#[derive(Debug)]
pub struct Staged {
    path: PathBuf,
    /// `None` for a device or a pipe, which is written as it stands.
    hidden: Option<Hidden>,
    /// Holds the lock until the file has its name.
    file: File,
}

/// A file under its hidden name.
#[derive(Debug)]
struct Hidden {
    /// Removes it, unless it has been renamed.
    unfinished: Unfinished,
    /// The name that it is to get.
    target: PathBuf,
}

/// Writes a file under a hidden name beside `path`, which the user chose;
/// [`Staged::publish`] gives it its name. A link is followed, and a device or a
/// pipe is written at once.
///
/// # Errors
/// When it cannot be written. Nothing is left behind.
pub fn stage(
    path: &Path,
    fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
) -> Result<Staged, FileError> {
    stage_as(NameOrigin::Given, path, fill)
}

/// Whether a file of the user's name `path` can be made, found out without
/// disturbing what reads a pipe there.
///
/// # Errors
/// When it cannot.
pub fn check_target(path: &Path) -> Result<(), FileError> {
    match FileTarget::of(path, NameOrigin::Given) {
        Ok(FileTarget::Stream(_)) => Ok(()),
        _ => stage(path, |_| Ok(())).map(drop),
    }
}

pub(super) fn stage_as(
    name: NameOrigin,
    path: &Path,
    fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
) -> Result<Staged, FileError> {
    let failed = |source| cannot_write(path)(source);
    let (file, hidden) = match FileTarget::of(path, name).map_err(failed)? {
        FileTarget::Stream(stream) => (open_stream(&stream).map_err(failed)?, None),
        FileTarget::File(target) => {
            let (file, hidden) = open_hidden(target).map_err(|error| match error.kind() {
                io::ErrorKind::NotFound => failed(io::Error::other("its folder does not exist")),
                _ => failed(error),
            })?;
            (file, Some(hidden))
        }
    };
    let mut out = BufWriter::new(file);
    // Declared after the open file, so that it is removed before its lock is
    // given up.
    let hidden = hidden;
    fill(&mut out).map_err(failed)?;
    let file = out.into_inner().map_err(|error| failed(error.into_error()))?;
    Ok(Staged { path: path.to_owned(), hidden, file })
}

/// Files whose contents are waited for at once.
const AT_ONCE: usize = 8;

/// Waits until the contents of some files are on the disk: of several at once, since for each that is asked for
/// alone the disk finishes all that it has begun.
///
/// # Errors
/// When they cannot be written there.
pub fn sync_all<'s>(files: impl IntoIterator<Item = &'s Staged>) -> Result<(), FileError> {
    let files: Vec<&Staged> = files.into_iter().collect();
    let sync = |files: &[&Staged]| files.iter().try_for_each(|file| file.sync());
    thread::scope(|scope| {
        let shares = files.chunks(files.len().div_ceil(AT_ONCE).max(1));
        let threads: Vec<_> = shares.map(|share| scope.spawn(move || sync(share))).collect();
        threads.into_iter().try_for_each(|thread| {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    })
}

fn cannot_write(path: &Path) -> impl FnOnce(io::Error) -> FileError {
    FileError::new(path, "cannot write the file")
}

impl Staged {
    /// Gives the file its name, in place of what stood there, and waits until
    /// both are on the disk.
    ///
    /// # Errors
    /// When it cannot be synced or renamed.
    pub fn publish(self) -> Result<(), FileError> {
        self.sync()?;
        let path = self.path.clone();
        match self.rename()? {
            Some(folder) => sync_folder(&folder).map_err(cannot_write(&path)),
            None => Ok(()),
        }
    }

    /// Waits until the contents are on the disk.
    ///
    /// # Errors
    /// When they cannot be written there.
    pub fn sync(&self) -> Result<(), FileError> {
        match self.hidden {
            Some(_) => sync_file(&self.file).map_err(cannot_write(&self.path)),
            None => Ok(()),
        }
    }

    /// Gives the file its name, and says in which folder that stands.
    pub(super) fn rename(self) -> Result<Option<PathBuf>, FileError> {
        let Some(Hidden { unfinished, target }) = self.hidden else {
            return Ok(None);
        };
        unfinished.rename(&target).map_err(cannot_write(&self.path))?;
        Ok(target.parent().map(Path::to_owned))
    }
}

/// Opens the hidden file of `target`, empty and locked.
fn open_hidden(target: PathBuf) -> io::Result<(File, Hidden)> {
    let name = target.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
    let mut hidden_name = std::ffi::OsString::from(".");
    hidden_name.push(name);
    hidden_name.push(".goldtof-partial");
    let hidden = target.with_file_name(hidden_name);
    for _ in 0..MOST_TRIES {
        let file = open_ours(&hidden, 0o666).map_err(|error| at_hidden(&hidden, error))?;
        match file.lock() {
            // Some network file systems have no locks; then there is none.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => return Err(error),
            _ => {}
        }
        // While this run waited, the one before may have renamed or removed it.
        if is_at(&file, &hidden)? {
            let unfinished = Unfinished::new(&hidden);
            file.set_len(0)?;
            return Ok((file, Hidden { unfinished, target }));
        }
    }
    let reason = io::Error::other("other runs replace it without end");
    Err(at_hidden(&hidden, reason))
}

/// The same error, of the hidden file. One of the system's own kinds is about
/// its folder as well.
fn at_hidden(hidden: &Path, error: io::Error) -> io::Error {
    match error.raw_os_error() {
        Some(_) => error,
        None => io::Error::new(error.kind(), format!("{}: {error}", printable_path(hidden))),
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

    use super::*;

    fn write(path: &Path, text: &str) -> Result<(), FileError> {
        stage(path, |out| out.write_all(text.as_bytes()))?.publish()
    }

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
        assert_eq!(fs::read_to_string(folder.path().join("a.txt")).unwrap(), "new");
    }

    #[test]
    fn writers_at_once_do_not_mix() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let texts: Vec<String> =
            (0..8).map(|i| i.to_string().repeat(100_000 + i * 1_000)).collect();
        std::thread::scope(|scope| {
            for text in &texts {
                scope.spawn(|| write(&path, text).unwrap());
            }
        });
        assert!(texts.contains(&fs::read_to_string(&path).unwrap()));
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_name_of_ours_is_never_followed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("victim"), "precious").unwrap();
        for (link, target) in [("link", "victim"), ("dangling", "nowhere")] {
            symlink(target, at(link)).unwrap();
            let staged = stage_as(NameOrigin::Ours, &at(link), |out| out.write_all(b"ours"));
            staged.unwrap().publish().unwrap();
            assert!(!at(link).is_symlink());
            assert_eq!(fs::read_to_string(at(link)).unwrap(), "ours");
        }
        let null = stage_as(NameOrigin::Ours, Path::new("/dev/null"), |_| Ok(()));
        assert!(null.unwrap_err().to_string().contains("a device is there"));
        assert_eq!(fs::read_to_string(at("victim")).unwrap(), "precious");
        assert_eq!(names(folder.path()), ["dangling", "link", "victim"]);
    }

    #[test]
    fn a_hidden_name_that_is_taken_by_something_else_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("victim"), "precious").unwrap();
        symlink("victim", at(".a.goldtof-partial")).unwrap();
        symlink("nowhere", at(".b.goldtof-partial")).unwrap();
        fs::hard_link(at("victim"), at(".c.goldtof-partial")).unwrap();
        let before = names(folder.path());
        for name in ["a", "b", "c"] {
            let error = write(&at(name), "new").unwrap_err().to_string();
            assert!(error.contains(&format!("/.{name}.goldtof-partial: a ")), "{error}");
            assert!(error.contains("remove it"), "{error}");
        }
        assert_eq!(names(folder.path()), before);
        assert_eq!(fs::read_to_string(at("victim")).unwrap(), "precious");
    }

    #[test]
    fn a_given_link_to_nothing_makes_what_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let (link, target) = (folder.path().join("link"), folder.path().join("target"));
        symlink("between", &link).unwrap();
        symlink("target", folder.path().join("between")).unwrap();
        check_target(&link).unwrap();
        assert!(!target.exists());
        write(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
        symlink("round", folder.path().join("round")).unwrap();
        assert!(write(&folder.path().join("round"), "new").is_err());
    }

    #[test]
    fn a_pipe_that_nobody_reads_is_told_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        check_target(&pipe).unwrap();
        let error = write(&pipe, "new").unwrap_err().to_string();
        assert!(error.contains("nobody reads this pipe"), "{error}");
        let text = "more than a pipe holds".repeat(10_000);
        std::thread::scope(|scope| {
            let reader = scope.spawn(|| fs::read_to_string(&pipe).unwrap());
            while write(&pipe, &text).is_err() {
                std::thread::yield_now();
            }
            assert_eq!(reader.join().unwrap(), text);
        });
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

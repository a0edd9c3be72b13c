//! A folder that one run at a time writes into.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::FileError;
use super::durable::{make_folders, sync_folder};
use super::guarded::kind_of;
use super::read::read_bytes;
use super::staged::{Staged, stage_as, sync_all};
use super::target::NameOrigin;

/// A folder for a command's files, locked against other runs of goldtof until
/// it is dropped. Files of others in it are left alone.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    _locked: File,
}

impl OutputFolder {
    /// Opens the folder, which is made when missing. `on_wait` is told when
    /// another run holds it, before this one waits for that run's end.
    ///
    /// # Errors
    /// When it cannot be made or opened.
    pub fn open(path: &Path, on_wait: impl FnOnce(&Path)) -> Result<OutputFolder, FileError> {
        make_folders(path).map_err(FileError::new(path, "cannot make the folder"))?;
        let folder = File::open(path).map_err(FileError::new(path, "cannot open the folder"))?;
        let locked = match folder.try_lock() {
            Err(TryLockError::WouldBlock) => {
                on_wait(path);
                folder.lock()
            }
            Err(TryLockError::Error(error)) => Err(error),
            Ok(()) => Ok(()),
        };
        match locked {
            // Some network file systems have no locks; then there is none.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => {
                Err(FileError::new(path, "cannot lock the folder")(error))
            }
            _ => Ok(OutputFolder { path: path.to_owned(), _locked: folder }),
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a file in it.
    pub fn join(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Opens the folder `name` in it, as [`OutputFolder::open`] does. A link of that
    /// name is not followed: nobody asked for files elsewhere.
    ///
    /// # Errors
    /// When it cannot be made or opened.
    pub fn subfolder(
        &self,
        name: &str,
        on_wait: impl FnOnce(&Path),
    ) -> Result<OutputFolder, FileError> {
        let path = self.join(name);
        match fs::symlink_metadata(&path) {
            Ok(found) if !found.is_dir() => {
                let reason = format!("{} is there; remove it", kind_of(&found));
                Err(FileError::new(&path, "cannot make the folder")(io::Error::new(
                    io::ErrorKind::NotADirectory,
                    reason,
                )))
            }
            _ => OutputFolder::open(&path, on_wait),
        }
    }

    /// Writes one of its files under a hidden name. What has its name already is
    /// replaced, but not followed if it is a link.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn stage(
        &self,
        name: &str,
        fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> Result<Staged, FileError> {
        stage_as(NameOrigin::Ours, &self.join(name), fill)
    }

    /// [`OutputFolder::stage`] of a text, but for a file that holds it already: that one stays, with
    /// the time of its last change, from which `make` and the like know what to do anew.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn stage_changed(&self, name: &str, text: &str) -> Result<Option<Staged>, FileError> {
        match holds(&self.join(name), text.as_bytes()) {
            true => Ok(None),
            false => self.stage(name, |out| out.write_all(text.as_bytes())).map(Some),
        }
    }

    /// Writes one of its files, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, name: &str, text: &str) -> Result<(), FileError> {
        self.stage(name, |out| out.write_all(text.as_bytes()))?.publish()
    }

    /// Writes several of its files, all or none; gives their names.
    ///
    /// # Errors
    /// When one cannot be written.
    pub fn write_all<const N: usize>(
        &self,
        files: [(&'static str, impl AsRef<[u8]>); N],
    ) -> Result<Vec<&'static str>, FileError> {
        let names = files.iter().map(|(name, _)| *name).collect();
        let stage = |(name, content): &(&str, _)| {
            let content = AsRef::<[u8]>::as_ref(content);
            self.stage(name, |out| out.write_all(content))
        };
        self.publish(files.iter().map(stage).collect::<Result<_, _>>()?)?;
        Ok(names)
    }

    /// Gives files that were staged here their names, and waits until all are on the
    /// disk: for the contents of each before the first has its name, for the
    /// names once.
    ///
    /// # Errors
    /// When one cannot be synced or renamed.
    pub fn publish(&self, staged: Vec<Staged>) -> Result<(), FileError> {
        sync_all(&staged)?;
        self.name(staged)
    }

    /// The same of files whose contents are on the disk.
    ///
    /// # Errors
    /// When one cannot be renamed, or the names cannot be written.
    pub fn name(&self, staged: Vec<Staged>) -> Result<(), FileError> {
        for file in staged {
            file.rename()?;
        }
        self.sync()
    }

    /// Waits until its list of names is on the disk, and so what was removed is
    /// gone for good.
    ///
    /// # Errors
    /// When it cannot be written there.
    pub fn sync(&self) -> Result<(), FileError> {
        sync_folder(&self.path).map_err(FileError::new(&self.path, "cannot sync the folder"))
    }

    /// Removes the folder itself, if it is empty; else it stays.
    pub fn discard(self) {
        let _ = fs::remove_dir(&self.path);
    }

    /// Removes a file of an earlier run, if it is there.
    ///
    /// # Errors
    /// When it is there and cannot be removed.
    pub fn remove(&self, name: &str) -> Result<(), FileError> {
        let path = self.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(FileError::new(&path, "cannot remove the earlier run's file")(error))
            }
            _ => Ok(()),
        }
    }
}

/// Whether a file, and not a link to one, holds just these bytes.
fn holds(path: &Path, bytes: &[u8]) -> bool {
    let length = bytes.len() as u64;
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file() && found.len() == length)
        && read_bytes(path, length).is_ok_and(|held| held == bytes)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn the_second_run_waits_and_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        let first = OutputFolder::open(&path, |_| panic!("nobody else is there")).unwrap();
        let (waits, hears) = mpsc::channel();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let second = OutputFolder::open(&path, |_| waits.send(()).unwrap()).unwrap();
                second.write("a", "second").unwrap();
            });
            hears.recv().unwrap();
            first.write("a", "first").unwrap();
            drop(first);
        });
        assert_eq!(fs::read_to_string(path.join("a")).unwrap(), "second");
    }
}

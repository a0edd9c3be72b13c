//! What has been written and renamed survives a power cut.
//!
//! A file's contents are on the disk before it gets its name, and the folder's
//! list of names after: in that order a power cut leaves the old file or the new
//! one, whole. See `fsync(2)`.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Waits until a file's contents are on the disk.
///
/// # Errors
/// When they cannot be written there.
pub(super) fn sync_file(file: &File) -> io::Result<()> {
    where_there_is_a_disk(file.sync_all())
}

/// Waits until the names in a folder are on the disk.
///
/// # Errors
/// When they cannot be written there.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    let named = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    where_there_is_a_disk(File::open(named)?.sync_all())
}

/// Some network file systems have nothing to wait for.
fn where_there_is_a_disk(synced: io::Result<()>) -> io::Result<()> {
    match synced {
        Err(error)
            if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) =>
        {
            Ok(())
        }
        synced => synced,
    }
}

/// Makes a folder and those that it stands in, where they are missing, so that
/// they are still there after a power cut.
///
/// # Errors
/// When one cannot be made.
pub(super) fn make_folders(path: &Path) -> io::Result<()> {
    let missing = path.ancestors().take_while(|folder| {
        !folder.as_os_str().is_empty() && matches!(folder.try_exists(), Ok(false))
    });
    let missing: Vec<&Path> = missing.collect();
    fs::create_dir_all(path)?;
    for made in missing.iter().rev() {
        sync_folder(made.parent().unwrap_or(Path::new("")))?;
    }
    Ok(())
}

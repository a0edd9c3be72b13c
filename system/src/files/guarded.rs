//! Files under names of our own, which somebody else may have taken first.
//!
//! A hidden file or a lock has a name that anyone can foresee. What stands there
//! may be a link to a file elsewhere, a second name of it, or a pipe that nobody
//! fills: none of them is written to, shortened or waited for.

use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;

use rustix::fs::OFlags;
use rustix::process::geteuid;

/// `flags` as the standard library takes them.
pub(super) fn flags(flags: OFlags) -> i32 {
    flags.bits().cast_signed()
}

/// Opens our file at `path` for reading and writing, and makes it when it is missing, with
/// `mode` less the umask. It keeps what it holds.
///
/// # Errors
/// When something else stands there, or it is another user's; with what it is.
pub fn open_ours(path: &Path, mode: u32) -> io::Result<File> {
    let file = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .mode(mode)
        .custom_flags(flags(OFlags::NOFOLLOW | OFlags::NONBLOCK))
        .open(path)
        .map_err(|error| named(path, error))?;
    check_ours(&file.metadata()?)?;
    Ok(file)
}

/// What stands in the way where opening failed because of it.
fn named(path: &Path, error: io::Error) -> io::Error {
    match std::fs::symlink_metadata(path) {
        Ok(found) if !found.is_file() => in_the_way(&found),
        _ => error,
    }
}

fn check_ours(found: &Metadata) -> io::Result<()> {
    if !found.is_file() || found.nlink() > 1 {
        return Err(in_the_way(found));
    }
    check_owner(found)
}

fn in_the_way(found: &Metadata) -> io::Error {
    let kind = kind_of(found);
    io::Error::other(format!(
        "{kind} has the name that goldtof needs for a file of its own; remove it"
    ))
}

/// Whether it is the user's own who runs this.
///
/// # Errors
/// When it is not; with whose it is.
pub(super) fn check_owner(found: &Metadata) -> io::Result<()> {
    let ours = geteuid().as_raw();
    if found.uid() == ours {
        return Ok(());
    }
    Err(io::Error::new(
        io::ErrorKind::PermissionDenied,
        format!("it belongs to user {}, not to you ({ours})", found.uid()),
    ))
}

/// What it is, in a sentence.
pub(super) fn kind_of(found: &Metadata) -> &'static str {
    let kind = found.file_type();
    match () {
        () if kind.is_symlink() => "a symbolic link",
        () if kind.is_dir() => "a folder",
        () if kind.is_fifo() => "a pipe",
        () if kind.is_socket() => "a socket",
        () if kind.is_file() && found.nlink() > 1 => "a file with a second name (a hard link)",
        () if kind.is_file() => "a file",
        () => "a device",
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::{chown, symlink};

    use super::*;

    #[test]
    fn a_file_of_ours_is_made_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        open_ours(&path, 0o600).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        fs::write(&path, "kept").unwrap();
        open_ours(&path, 0o600).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "kept");
    }

    #[test]
    fn what_is_not_ours_is_named_and_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("victim"), "precious").unwrap();
        symlink("victim", at("link")).unwrap();
        symlink("nowhere", at("dangling")).unwrap();
        fs::hard_link(at("victim"), at("second")).unwrap();
        fs::create_dir(at("folder")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(at("pipe")).status();
        assert!(made.unwrap().success());
        for (name, kind) in [
            ("link", "symbolic link"),
            ("dangling", "symbolic link"),
            ("second", "second name"),
            ("folder", "a folder"),
            ("pipe", "a pipe"),
        ] {
            let error = open_ours(&at(name), 0o600).unwrap_err().to_string();
            assert!(error.contains(kind), "{name}: {error}");
        }
        assert_eq!(fs::read_to_string(at("victim")).unwrap(), "precious");
        assert!(!at("nowhere").exists());
    }

    #[test]
    fn another_users_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "theirs").unwrap();
        // Only root can give a file away.
        if chown(&path, Some(12_345), None).is_err() {
            return;
        }
        let error = open_ours(&path, 0o600).unwrap_err().to_string();
        assert!(error.contains("belongs to user 12345"), "{error}");
    }
}

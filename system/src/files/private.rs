//! A folder that nobody else can put anything into.

use std::fs::{self, DirBuilder, Metadata};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Component, Path, PathBuf};

use rustix::process::geteuid;

use super::guarded::{check_owner, kind_of};
use crate::printable::printable_path;

/// Writable by the group or by others.
const WRITABLE: u32 = 0o022;
/// In such a folder only its owner may rename or remove an entry.
const STICKY: u32 = 0o1000;
/// As the kernel's own limit.
const MOST_LINKS: u32 = 40;

/// The real path of the folder `path`, which is made when missing, with rights
/// for nobody else.
///
/// # Errors
/// When it is not a folder that only this user, and root, can change: each
/// folder and link on the way has to belong to one of them, and no one else may
/// write there, unless the folder is sticky as `/tmp` is. The folder itself has
/// to be this user's.
pub fn private_folder(path: &Path) -> io::Result<PathBuf> {
    let (mut real, mut links) = (PathBuf::from("/"), 0);
    let mut rest = components(&std::path::absolute(path)?);
    while let Some(name) = rest.pop() {
        if name == Path::new("..") {
            real.pop();
            continue;
        }
        let next = real.join(name);
        let found = found_or_made(&next)?;
        if found.is_symlink() {
            links += 1;
            if links > MOST_LINKS {
                return Err(told(&next, "too many symbolic links"));
            }
            check_owner_or_root(&next, &found)?;
            let target = fs::read_link(&next)?;
            if target.is_absolute() {
                real = PathBuf::from("/");
            }
            rest.extend(components(&target));
        } else if found.is_dir() {
            check_on_the_way(&next, &found)?;
            real = next;
        } else {
            let reason = format!("not a directory, but {}", kind_of(&found));
            return Err(io::Error::new(io::ErrorKind::NotADirectory, reason));
        }
    }
    let found = fs::symlink_metadata(&real)?;
    check_private(&found).map_err(|error| told(&real, &error.to_string()))?;
    Ok(real)
}

/// Whether a file or folder is this user's and nobody else can write to it.
///
/// # Errors
/// When not; with the reason and what would mend it.
pub fn check_private(found: &Metadata) -> io::Result<()> {
    check_owner(found)?;
    match found.mode() & WRITABLE {
        0 => Ok(()),
        _ => Err(writable_by_others()),
    }
}

fn writable_by_others() -> io::Error {
    io::Error::new(
        io::ErrorKind::PermissionDenied,
        "others can write there; take that right away with chmod go-w",
    )
}

/// The names of a path, the last first.
fn components(path: &Path) -> Vec<PathBuf> {
    let names = path.components().filter_map(|component| match component {
        Component::Normal(_) | Component::ParentDir => Some(PathBuf::from(component.as_os_str())),
        _ => None,
    });
    let mut names: Vec<PathBuf> = names.collect();
    names.reverse();
    names
}

fn found_or_made(path: &Path) -> io::Result<Metadata> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            match DirBuilder::new().mode(0o700).create(path) {
                // Another run has just made it, or somebody something else.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                made => made?,
            }
            fs::symlink_metadata(path)
        }
        found => found,
    }
}

fn check_on_the_way(path: &Path, found: &Metadata) -> io::Result<()> {
    check_owner_or_root(path, found)?;
    if found.mode() & WRITABLE != 0 && found.mode() & STICKY == 0 {
        return Err(told(path, &writable_by_others().to_string()));
    }
    Ok(())
}

fn check_owner_or_root(path: &Path, found: &Metadata) -> io::Result<()> {
    if found.uid() == 0 || found.uid() == geteuid().as_raw() {
        return Ok(());
    }
    check_owner(found).map_err(|error| told(path, &error.to_string()))
}

fn told(path: &Path, reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::PermissionDenied, format!("{}: {reason}", printable_path(path)))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt as _, chown, symlink};

    use super::*;

    fn set_mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn it_is_made_with_rights_for_nobody_else_and_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b");
        let real = private_folder(&path).unwrap();
        assert_eq!(real, fs::canonicalize(&path).unwrap());
        for made in [&path, &folder.path().join("a")] {
            assert_eq!(fs::metadata(made).unwrap().mode() & 0o777, 0o700);
        }
        assert_eq!(private_folder(&path.join("../b")).unwrap(), real);
    }

    #[test]
    fn a_folder_that_others_can_write_to_is_refused_wherever_it_is_on_the_way() {
        let folder = tempfile::tempdir().unwrap();
        let (outer, inner) = (folder.path().join("a"), folder.path().join("a/b"));
        private_folder(&inner).unwrap();
        for (changed, mode, holds) in [
            (&inner, 0o770, false),
            (&inner, 0o702, false),
            (&inner, 0o1777, false),
            (&inner, 0o755, true),
            (&outer, 0o777, false),
            (&outer, 0o720, false),
            (&outer, 0o1777, true),
            (&outer, 0o755, true),
        ] {
            set_mode(changed, mode);
            let given = private_folder(&inner);
            assert_eq!(given.is_ok(), holds, "{mode:o}: {given:?}");
            set_mode(changed, 0o700);
        }
    }

    #[test]
    fn links_of_this_user_are_followed_and_files_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        fs::create_dir(folder.path().join("real")).unwrap();
        symlink("real", &link).unwrap();
        let real = private_folder(&link.join("cache")).unwrap();
        assert_eq!(real, fs::canonicalize(folder.path()).unwrap().join("real/cache"));
        symlink("round", folder.path().join("round")).unwrap();
        assert!(private_folder(&folder.path().join("round")).is_err());
        fs::write(folder.path().join("file"), "").unwrap();
        let error = private_folder(&folder.path().join("file/cache")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotADirectory);
    }

    #[test]
    fn what_another_user_owns_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("theirs/ours")).unwrap();
        fs::create_dir_all(at("ours")).unwrap();
        symlink("ours", at("link")).unwrap();
        // Only root can give a file away.
        if chown(at("theirs"), Some(12_345), None).is_err() {
            return;
        }
        std::os::unix::fs::lchown(at("link"), Some(12_345), None).unwrap();
        for name in ["theirs", "theirs/ours", "link", "link/cache"] {
            let error = private_folder(&at(name)).unwrap_err().to_string();
            assert!(error.contains("belongs to user 12345"), "{name}: {error}");
        }
        private_folder(&at("ours")).unwrap();
    }
}

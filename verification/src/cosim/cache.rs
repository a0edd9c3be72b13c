//! What has been built, and is kept: one folder per identity.
//!
//! A folder is made under another name beside its final place and renamed when
//! it is done, so a build that was cut off is never taken for a finished one; a
//! lock per identity keeps two runs from doing it twice.
//!
//! What is found here is loaded and run, so nobody else may have put it there:
//! the cache, each folder on the way to it and each entry have to be this user's,
//! and nobody else's to write. What a build made is not synced: what a power cut
//! spoils does not have its digest and is built again.

use std::fs::{self, OpenOptions};
use std::io::{self, Read as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use rustix::fs::OFlags;
use rustix::process::geteuid;

use super::error::CosimError;
use crate::digest::{sha256, sha256_of_all};
use crate::files::{check_private, open_ours, private_folder};
use crate::interrupt::Unfinished;

/// Holds the digest of the file that counts.
const DIGEST: &str = "sensor.sha256";

/// Where this program was told to keep builds.
static CHOSEN: OnceLock<PathBuf> = OnceLock::new();

/// Says where builds are kept from now on. The first to say so is right.
pub fn set_cache_dir(path: PathBuf) {
    let _ = CHOSEN.set(path);
}

/// Where builds are kept: where [`set_cache_dir`] says, or `$GOLDTOF_CACHE_DIR`, or `goldtof` in
/// the user's folder for caches (`$XDG_CACHE_HOME`, else `.cache` in the user's home).
///
/// # Errors
/// When the user has no home.
pub fn cache_dir() -> Result<PathBuf, CosimError> {
    let told = || std::env::var_os("GOLDTOF_CACHE_DIR").filter(|told| !told.is_empty());
    let chosen = CHOSEN.get().cloned().or_else(|| told().map(PathBuf::from));
    let folder =
        chosen.or_else(|| Some(user_cache_dir()?.join("goldtof"))).ok_or(CosimError::NoCache)?;
    // The compiler runs in folders of its own.
    std::path::absolute(&folder).map_err(CosimError::cache(&folder))
}

/// The user's folder for caches, as the XDG Base Directory Specification has it: paths that
/// are not absolute do not count.
fn user_cache_dir() -> Option<PathBuf> {
    let told = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
    let of_home = || Some(std::env::home_dir()?.join(".cache"));
    told.filter(|path| path.is_absolute()).or_else(|| of_home().filter(|path| path.is_absolute()))
}

/// Finds the file `product` in the folder `name` of the cache, or makes the
/// folder with `fill`; gives the bytes of that file, whose digest has been checked.
///
/// # Errors
/// When the cache cannot be had, or is not this user's alone.
pub fn once(
    cache: &Path,
    name: &str,
    product: &str,
    fill: impl FnOnce(&Path) -> Result<(), CosimError>,
) -> Result<Vec<u8>, CosimError> {
    let cache = &private_folder(cache).map_err(CosimError::cache(cache))?;
    let folder = cache.join(name);
    let whole = || whole(&folder, product).map_err(CosimError::cache(&folder));
    if let Some(bytes) = whole()? {
        return Ok(bytes);
    }
    let lock_path = cache.join(format!("{name}.lock"));
    let lock = open_ours(&lock_path, 0o600).map_err(CosimError::cache(&lock_path))?;
    lock.lock().map_err(CosimError::cache(&lock_path))?;
    // Another run may have built it while this one waited.
    if let Some(bytes) = whole()? {
        return Ok(bytes);
    }
    remove_broken(cache, name).map_err(CosimError::cache(&folder))?;
    let building = tempfile::Builder::new()
        .prefix(&building_prefix(name))
        .tempdir_in(cache)
        .map_err(CosimError::cache(cache))?;
    let building = Unfinished::new(&building.keep());
    fill(building.path())?;
    let built = building.path().join(product);
    let bytes = fs::read(&built).map_err(CosimError::cache(&built))?;
    let digest_path = building.path().join(DIGEST);
    write(&digest_path, &sha256(&bytes))?;
    for path in [&built, &digest_path] {
        // Whatever the umask is.
        let ours = fs::Permissions::from_mode(0o600);
        fs::set_permissions(path, ours).map_err(CosimError::cache(path))?;
    }
    building.rename(&folder).map_err(CosimError::cache(&folder))?;
    Ok(bytes)
}

/// Start of the names of the folders in which `name` is built.
fn building_prefix(name: &str) -> String {
    format!("{name}.building-")
}

/// Removes what the cache has under `name` and what killed runs left of it. For
/// the holder of its lock, which knows that nobody is building it.
fn remove_broken(cache: &Path, name: &str) -> std::io::Result<()> {
    let prefix = building_prefix(name);
    for entry in fs::read_dir(cache)? {
        let entry = entry?;
        let found = entry.file_name();
        let is_leftover = found.to_str().is_some_and(|found| found.starts_with(&prefix));
        if !is_leftover && found != name {
            continue;
        }
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// The bytes of the product in `folder`, if both are there, nobody else could
/// have changed them, and they have their digest.
///
/// # Errors
/// When something of it belongs to another user.
fn whole(folder: &Path, product: &str) -> io::Result<Option<Vec<u8>>> {
    let Some(()) = ours(fs::symlink_metadata(folder))? else {
        return Ok(None);
    };
    let read = |name: &str| -> io::Result<Option<Vec<u8>>> {
        let opened = OpenOptions::new()
            .read(true)
            .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed())
            .open(folder.join(name));
        let Ok(mut file) = opened else {
            return Ok(None);
        };
        let found = file.metadata()?;
        if !found.is_file() || ours(Ok(found))?.is_none() {
            return Ok(None);
        }
        let mut bytes = Vec::new();
        Ok(file.read_to_end(&mut bytes).ok().map(|_| bytes))
    };
    let (Some(expected), Some(bytes)) = (read(DIGEST)?, read(product)?) else {
        return Ok(None);
    };
    Ok((sha256(&bytes).as_bytes() == expected).then_some(bytes))
}

/// Nothing where nothing is, or what others can write to, which is built again.
///
/// # Errors
/// When it belongs to another user: others' files are not replaced.
fn ours(found: io::Result<fs::Metadata>) -> io::Result<Option<()>> {
    let Ok(found) = found else {
        return Ok(None);
    };
    match check_private(&found) {
        Ok(()) => Ok(Some(())),
        Err(_) if found.is_symlink() => Ok(None),
        Err(_) if found.uid() == geteuid().as_raw() => Ok(None),
        Err(error) => Err(error),
    }
}

/// Writes a file of a folder that is being made.
pub fn write(path: &Path, text: &str) -> Result<(), CosimError> {
    fs::write(path, text).map_err(CosimError::cache(path))
}

/// What changes with a file: its size and its times.
///
/// # Errors
/// When there is no such file.
pub fn file_identity(path: &Path) -> io::Result<String> {
    let found = fs::metadata(path)?;
    let modified = (found.mtime(), found.mtime_nsec());
    Ok(format!("{} {modified:?} {:?}", found.size(), (found.ctime(), found.ctime_nsec())))
}

/// Hash of several texts, such that no two lists of texts run together.
pub fn hash(parts: &[&str]) -> String {
    sha256_of_all(parts)[..32].to_owned()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// Asks for the entry `name`, whose product holds "whole".
    fn ask(cache: &Path, fills: &Cell<u32>) -> PathBuf {
        let fill = |folder: &Path| {
            fills.set(fills.get() + 1);
            write(&folder.join("product"), "whole")
        };
        let bytes = once(cache, "name", "product", fill).unwrap();
        assert_eq!(bytes, b"whole");
        cache.join("name")
    }

    fn set_mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    /// A product with its right digest, as somebody else would plant it.
    fn plant(folder: &Path) {
        fs::create_dir(folder).unwrap();
        fs::write(folder.join("product"), "planted").unwrap();
        fs::write(folder.join(DIGEST), sha256(b"planted")).unwrap();
    }

    #[test]
    fn what_others_could_have_changed_is_built_again() {
        let cache = tempfile::tempdir().unwrap();
        let folder = cache.path().join("name");
        let product = folder.join("product");
        let opened: [&dyn Fn(); 4] = [
            &|| set_mode(&folder, 0o770),
            &|| set_mode(&product, 0o666),
            &|| set_mode(&folder.join(DIGEST), 0o622),
            &|| {
                fs::rename(&product, cache.path().join("moved")).unwrap();
                std::os::unix::fs::symlink("../moved", &product).unwrap();
            },
        ];
        for open_it in opened {
            plant(&folder);
            set_mode(&folder, 0o700);
            for file in [&product, &folder.join(DIGEST)] {
                set_mode(file, 0o600);
            }
            open_it();
            let fills = Cell::new(0);
            ask(cache.path(), &fills);
            assert_eq!(fills.get(), 1);
            fs::remove_dir_all(&folder).unwrap();
        }
    }

    #[test]
    fn what_another_user_owns_is_refused_and_stays() {
        use std::os::unix::fs::chown;
        let cache = tempfile::tempdir().unwrap();
        let folder = cache.path().join("name");
        plant(&folder);
        let of_other = |path: &Path| chown(path, Some(12_345), None).is_ok();
        for path in [folder.join("product"), folder.join(DIGEST), folder.clone()] {
            set_mode(&folder, 0o700);
            // Only root can give a file away.
            if !of_other(&path) {
                return;
            }
            let asked = once(cache.path(), "name", "product", |_| panic!("not built"));
            let told = asked.unwrap_err().to_string();
            assert!(told.contains("belongs to user 12345"), "{told}");
            chown(&path, Some(0), None).unwrap();
        }
        assert_eq!(fs::read(folder.join("product")).unwrap(), b"planted");
    }

    #[test]
    fn a_lock_that_is_a_link_is_not_followed() {
        let cache = tempfile::tempdir().unwrap();
        let victim = cache.path().join("victim");
        fs::write(&victim, "precious").unwrap();
        let lock = cache.path().join("name.lock");
        std::os::unix::fs::symlink("victim", &lock).unwrap();
        let asked = once(cache.path(), "name", "product", |_| panic!("not built"));
        let told = asked.unwrap_err().to_string();
        assert!(told.contains("name.lock") && told.contains("symbolic link"), "{told}");
        assert_eq!(fs::read_to_string(&victim).unwrap(), "precious");
    }

    #[test]
    fn an_entry_is_made_once_and_again_when_it_is_broken_in_any_way() {
        let cache = tempfile::tempdir().unwrap();
        let fills = Cell::new(0);
        let folder = ask(cache.path(), &fills);
        ask(cache.path(), &fills);
        assert_eq!(fills.get(), 1);
        let remove_all = |path: &Path| fs::remove_dir_all(path).unwrap();
        let breaks: [&dyn Fn(); 7] = [
            &|| fs::write(folder.join("product"), "who").unwrap(),
            &|| fs::write(folder.join("product"), "wholes").unwrap(),
            &|| fs::write(folder.join(DIGEST), "0123").unwrap(),
            &|| fs::remove_file(folder.join(DIGEST)).unwrap(),
            &|| fs::remove_file(folder.join("product")).unwrap(),
            &|| remove_all(&folder),
            &|| {
                remove_all(&folder);
                fs::write(&folder, "a file").unwrap();
            },
        ];
        for (i, break_it) in breaks.iter().enumerate() {
            break_it();
            ask(cache.path(), &fills);
            assert_eq!(fills.get(), 2 + i as u32);
            assert_eq!(fs::read(folder.join("product")).unwrap(), b"whole");
        }
    }

    #[test]
    fn what_killed_builds_left_goes_with_the_next_and_other_entries_stay() {
        let cache = tempfile::tempdir().unwrap();
        for name in ["name.building-1", "name.building-2", "name2.building-1", "name2"] {
            fs::create_dir(cache.path().join(name)).unwrap();
        }
        ask(cache.path(), &Cell::new(0));
        let mut left: Vec<_> = fs::read_dir(cache.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left, ["name", "name.lock", "name2", "name2.building-1"]);
    }

    #[test]
    fn a_build_that_fails_leaves_nothing_under_its_name() {
        let cache = tempfile::tempdir().unwrap();
        let failed = once(cache.path(), "name", "product", |folder| {
            write(&folder.join("product"), "half")?;
            Err(CosimError::NoVerilog(folder.to_owned()))
        });
        assert!(failed.is_err());
        let left: Vec<_> =
            fs::read_dir(cache.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["name.lock"]);
    }
}

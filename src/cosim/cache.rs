//! What has been built, and is kept: one folder per identity.
//!
//! A folder is made under another name beside its final place and renamed when
//! it is done, so a build that was cut off is never taken for a finished one; a
//! lock per identity keeps two runs from doing it twice.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::error::CosimError;
use crate::interrupt::Unfinished;

/// Holds the digest of the file that counts.
const DIGEST: &str = "sensor.so.sha256";

/// Where builds are kept: `$GOLDTOF_CACHE_DIR`, or `goldtof` in the user's cache
/// folder, or in the temporary folder where there is none.
pub fn cache_dir() -> PathBuf {
    let from = |name: &str| {
        std::env::var_os(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    from("GOLDTOF_CACHE_DIR")
        .or_else(|| Some(from("XDG_CACHE_HOME")?.join("goldtof")))
        .or_else(|| Some(from("HOME")?.join(".cache").join("goldtof")))
        .unwrap_or_else(|| std::env::temp_dir().join("goldtof"))
}

/// Finds the folder `name` of the cache, or makes it with `fill`. `product` is
/// the file in it that counts; a digest beside it tells whether it is whole.
pub fn once(
    cache: &Path,
    name: &str,
    product: &str,
    fill: impl FnOnce(&Path) -> Result<(), CosimError>,
) -> Result<PathBuf, CosimError> {
    let folder = cache.join(name);
    if is_whole(&folder, product) {
        return Ok(folder);
    }
    if cache.exists() && !cache.is_dir() {
        let reason = std::io::ErrorKind::NotADirectory.into();
        return Err(CosimError::cache(cache)(reason));
    }
    fs::create_dir_all(cache).map_err(CosimError::cache(cache))?;
    let lock_path = cache.join(format!("{name}.lock"));
    let lock = File::create(&lock_path).map_err(CosimError::cache(&lock_path))?;
    lock.lock().map_err(CosimError::cache(&lock_path))?;
    // Another run may have built it while this one waited.
    if is_whole(&folder, product) {
        return Ok(folder);
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
    write(&building.path().join(DIGEST), &digest(&bytes))?;
    building
        .rename(&folder)
        .map_err(CosimError::cache(&folder))?;
    Ok(folder)
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
        let is_leftover = found
            .to_str()
            .is_some_and(|found| found.starts_with(&prefix));
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

fn is_whole(folder: &Path, product: &str) -> bool {
    let expected = fs::read_to_string(folder.join(DIGEST));
    let bytes = fs::read(folder.join(product));
    matches!((expected, bytes), (Ok(expected), Ok(bytes)) if digest(&bytes) == expected)
}

/// Writes a file of a folder that is being made.
pub fn write(path: &Path, text: &str) -> Result<(), CosimError> {
    fs::write(path, text).map_err(CosimError::cache(path))
}

/// Hash of several texts, such that no two lists of texts run together.
pub fn hash(parts: &[&str]) -> String {
    let mut hasher = Sha256::new();
    for part in parts {
        hasher.update((part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hex(&hasher.finalize())[..32].to_owned()
}

fn digest(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
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
        once(cache, "name", "product", fill).unwrap()
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
        for name in [
            "name.building-1",
            "name.building-2",
            "name2.building-1",
            "name2",
        ] {
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
        let left: Vec<_> = fs::read_dir(cache.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        assert_eq!(left, ["name.lock"]);
    }
}

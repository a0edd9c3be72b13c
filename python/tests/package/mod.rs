//! The package as a wheel would have it, with the library that cargo has just built.

use std::fs;
use std::path::{Path, PathBuf};

/// Puts it together in a folder, and gives that.
pub fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-package");
    let package = folder.join("goldtof");
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("goldtof"), &package);
    let test = std::env::current_exe().unwrap();
    let library = test.parent().unwrap().join("lib_goldtof.so");
    let loaded = package.join("_goldtof.abi3.so");
    // A new file, in case that somebody has the old one loaded.
    let _ = fs::remove_file(&loaded);
    fs::copy(library, loaded).unwrap();
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let to = to.join(path.file_name().unwrap());
        match path.is_dir() {
            true => copy(&path, &to),
            false => {
                fs::copy(&path, &to).unwrap();
            }
        }
    }
}

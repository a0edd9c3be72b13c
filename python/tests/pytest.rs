//! Runs the package's own tests, which are Python's, with the library that cargo has just
//! built: the package as a wheel would have it, in a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The package with this build's library.
fn package() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-package");
    let package = folder.join("goldtof");
    fs::create_dir_all(&package).unwrap();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("goldtof");
    for entry in fs::read_dir(sources).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, package.join(path.file_name().unwrap())).unwrap();
        }
    }
    let test = std::env::current_exe().unwrap();
    let library = test.parent().unwrap().join("lib_goldtof.so");
    let loaded = package.join("_goldtof.abi3.so");
    // A new file, in case that somebody has the old one loaded.
    let _ = fs::remove_file(&loaded);
    fs::copy(library, loaded).unwrap();
    folder
}

#[test]
fn the_python_package_keeps_its_tests() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let status = Command::new(target.join("python/bin/python"))
        // Without the folder itself on the path, where the package has no library.
        .args(["-P", "-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .current_dir(folder)
        .env("PYTHONPATH", package())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("GOLDTOF", target.join("debug/goldtof"))
        .status()
        .unwrap_or_else(|error| panic!("scripts/test installs Python's tools: {error}"));
    assert!(status.success(), "{status}");
}

//! Runs the package's own tests, which are Python's.

mod package;

use std::path::Path;
use std::process::Command;

#[test]
fn the_python_package_keeps_its_tests() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    // As many as Rust's tests at once.
    let processes = std::env::var("RUST_TEST_THREADS").unwrap_or("auto".to_owned());
    let status = Command::new(target.join("python/bin/python"))
        // Without the folder itself on the path, where the package has no library.
        .args(["-P", "-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .args(["--numprocesses", &processes, "--dist", "worksteal"])
        .current_dir(folder)
        .env("PYTHONPATH", package::folder())
        // Compiled once for all processes, and not beside the sources.
        .env("PYTHONPYCACHEPREFIX", target.join("python/compiled"))
        .env("GOLDTOF", target.join("debug/goldtof"))
        .status()
        .unwrap_or_else(|error| panic!("scripts/test installs Python's tools: {error}"));
    assert!(status.success(), "{status}");
}

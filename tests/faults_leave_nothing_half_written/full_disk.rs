//! No space, by a limit on the size of files and by the device that is always
//! full.

use std::fs;
use std::os::unix::fs::FileTypeExt as _;
use std::process::Command;

use super::support::*;

/// goldtof under a limit on the size of every file that it or its tools write.
fn limited(kibibytes: u32, arguments: &[&str]) -> Command {
    let mut command = Command::new("bash");
    let line = format!("ulimit -f {kibibytes}; exec \"$0\" \"$@\"");
    command.args(["-c", &line, env!("CARGO_BIN_EXE_goldtof")]);
    command.args(arguments);
    command
}

#[test]
fn a_design_that_does_not_fit_leaves_the_older_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = text(folder.path());
    ends_with(0, &mut goldtof(&["emit", QUICK, "--out", out]));
    let older = files_below(folder.path());
    let told = ends_with(2, &mut limited(2, &["emit", "scenes/dual-view.toml", "--out", out]));
    assert!(told.contains("cannot write the file: File too large"), "{told}");
    assert_eq!(files_below(folder.path()), older);
    ends_with(0, &mut goldtof(&["emit", "scenes/dual-view.toml", "--out", out]));
    assert_eq!(files_below(folder.path()), emitted("scenes/dual-view.toml"));
}

#[test]
fn a_figure_that_does_not_fit_leaves_the_older_one() {
    let folder = tempfile::tempdir().unwrap();
    let figure = folder.path().join("circular.svg");
    fs::write(&figure, "older").unwrap();
    let arguments = ["reproduce", "--figure", "circular", "--out", text(folder.path())];
    let told = ends_with(2, &mut limited(2, &arguments));
    assert!(told.contains("circular.svg: cannot write the file: File too large"), "{told}");
    assert_eq!(files_below(folder.path()).len(), 1);
    assert_eq!(fs::read_to_string(&figure).unwrap(), "older");
}

#[test]
fn a_model_that_does_not_fit_into_the_cache_is_not_there() {
    let cache = cache_without_models();
    let mut command = limited(64, &["cosim", QUICK]);
    let told = ends_with(2, command.env("GOLDTOF_CACHE_DIR", cache.path()));
    assert!(told.contains("cannot keep built models here: File too large"), "{told}");
    assert!(entries(cache.path(), "model-").is_empty());
}

#[test]
fn a_full_device_is_named() {
    let told =
        ends_with(2, &mut goldtof(&["cosim", QUICK, "--cycles", "1000", "--vcd", "/dev/full"]));
    assert!(told.contains("/dev/full: cannot write the file: No space left"), "{told}");
    let device = fs::metadata("/dev/full").unwrap();
    assert!(device.file_type().is_char_device());
    for arguments in [&["codes", "--degree", "5"][..], &["plan", QUICK, "--json"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let told =
            ends_with(2, goldtof(arguments).stdout(full).stderr(std::process::Stdio::piped()));
        assert!(told.contains("cannot write to stdout: No space left"), "{told}");
    }
}

//! Output folders that cannot be had, and those that are somebody else's too.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use super::support::*;

#[test]
fn a_folder_that_cannot_be_made_is_named_before_the_work_begins() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let below_a_file = file.join("out");
    // In /proc nobody makes folders, not even root.
    for out in [text(&below_a_file), "/proc/goldtof/out"] {
        let endless = endless_scene(folder.path());
        for command in ["emit", "run"] {
            let told = ends_with(2, &mut goldtof(&[command, text(&endless), "--out", out]));
            assert!(told.starts_with(&format!("error: {out}: cannot make the folder: ")), "{told}");
        }
        let told = ends_with(2, &mut goldtof(&["reproduce", "--repeat", "1000000", "--out", out]));
        assert!(told.starts_with(&format!("error: {out}: cannot make the folder: ")), "{told}");
    }
    assert_eq!(fs::read(&file).unwrap(), b"");
}

#[test]
fn waveforms_without_a_folder_are_refused_before_the_work_begins() {
    let told = ends_with(
        2,
        &mut goldtof(&["cosim", QUICK, "--cycles", "1000000000000", "--vcd", "/nonexistent/a.vcd"]),
    );
    assert_eq!(
        told,
        "error: /nonexistent/a.vcd: cannot write the file: its folder does not exist\n"
    );
}

#[test]
fn a_read_only_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let set = |mode| fs::set_permissions(folder.path(), fs::Permissions::from_mode(mode)).unwrap();
    set(0o555);
    let is_bound = fs::write(folder.path().join("probe"), "").is_err();
    // Permissions do not bind root; for root /proc is what cannot be written.
    let out = if is_bound { text(folder.path()) } else { "/proc/sys" };
    let told = ends_with(2, &mut goldtof(&["emit", QUICK, "--out", out]));
    set(0o755);
    assert!(told.contains("cannot write the file: "), "{told}");
    assert!(told.contains(out), "{told}");
}

#[test]
fn files_of_others_in_the_folder_stay() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["notes.txt", "my.v", "README"] {
        fs::write(folder.path().join(name), name).unwrap();
    }
    let out = text(folder.path());
    ends_with(0, &mut goldtof(&["run", QUICK, "--out", out]));
    ends_with(0, &mut goldtof(&["emit", QUICK, "--out", out]));
    ends_with(0, &mut goldtof(&["emit", "scenes/paper-square.toml", "--out", out]));
    for name in ["notes.txt", "my.v", "README"] {
        assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), name);
    }
    assert!(!folder.path().join("gold_generator.v").exists(), "of the older design");
}

#[test]
fn a_folder_in_the_place_of_a_file_and_a_file_in_the_place_of_a_folder_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a");
    fs::create_dir_all(out.join("report.html")).unwrap();
    let told = ends_with(2, &mut goldtof(&["run", QUICK, "--out", text(&out)]));
    assert!(told.contains("a/report.html: cannot remove"), "{told}");
    let out = folder.path().join("b");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("rtl"), "mine").unwrap();
    let told = ends_with(2, &mut goldtof(&["run", QUICK, "--out", text(&out)]));
    assert!(told.contains("b/rtl: cannot make the folder"), "{told}");
    assert_eq!(fs::read_to_string(out.join("rtl")).unwrap(), "mine");
    let out = folder.path().join("c");
    fs::create_dir_all(out.join("sensor_top.v")).unwrap();
    let told = ends_with(2, &mut goldtof(&["emit", QUICK, "--out", text(&out)]));
    assert!(told.contains("c/sensor_top.v: cannot write the file: is a directory"), "{told}");
    assert!(files_below(&out).is_empty());
}

//! Verilator and the compiler: missing, too old, failing.

use std::path::Path;
use std::process::Command;

use super::support::*;

fn cosim(cache: &Path) -> Command {
    let mut command = goldtof(&["cosim", QUICK, "--cycles", "1000"]);
    command.env("GOLDTOF_CACHE_DIR", cache);
    command
}

#[test]
fn tools_that_the_path_does_not_have_are_named_with_how_to_get_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = cosim(folder.path());
    let told = ends_with(
        3,
        command.env("PATH", folder.path()).env_remove("VERILATOR"),
    );
    assert!(
        told.starts_with("error: Verilator is missing (verilator: No such file")
            && told.ends_with("install it with: apt-get install verilator\n"),
        "{told}"
    );
    let mut command = cosim(folder.path());
    let told = ends_with(3, command.env("CXX", folder.path().join("absent-g++")));
    assert!(
        told.starts_with("error: a C++ compiler is missing (")
            && told.ends_with("install it with: apt-get install g++\n"),
        "{told}"
    );
    assert!(files_below(folder.path()).is_empty());
}

#[test]
fn a_file_that_is_no_program_is_a_missing_tool() {
    let folder = tempfile::tempdir().unwrap();
    let not_a_program = folder.path().join("verilator");
    std::fs::write(&not_a_program, "text").unwrap();
    let told = ends_with(3, cosim(folder.path()).env("VERILATOR", &not_a_program));
    assert!(told.contains("Permission denied"), "{told}");
}

#[test]
fn an_old_verilator_is_refused_with_what_it_says_of_itself() {
    let folder = tempfile::tempdir().unwrap();
    let old = folder.path().join("verilator");
    for version in [
        "Verilator 4.038 2020-07-11 rev v4.036",
        "something else",
        "",
    ] {
        script(&old, &format!("echo '{version}'"));
        let told = ends_with(3, cosim(folder.path()).env("VERILATOR", &old));
        let expected = format!(
            "error: {} says that it is \"{version}\", but goldtof needs Verilator 5.000 or newer; \
             install it with: apt-get install verilator\n",
            old.display()
        );
        assert_eq!(told, expected);
    }
}

#[test]
fn failing_tools_are_quoted_and_the_next_run_works() {
    let folder = tempfile::tempdir().unwrap();
    let cache = cache_without_models();
    let (tool, wrong) = (folder.path().join("tool"), "out of coffee");
    let cases = [
        // Verilator that fails at once, at its work, and by a signal.
        (
            "VERILATOR",
            format!("echo {wrong} >&2; exit 1"),
            "Verilator failed",
            "exit status: 1",
        ),
        (
            "VERILATOR",
            format!(
                "case $1 in --version|--getenv) exec verilator \"$@\";; esac; echo {wrong}; exit 7"
            ),
            "Verilator failed",
            "exit status: 7",
        ),
        (
            "VERILATOR",
            format!(
                "case $1 in --version|--getenv) exec verilator \"$@\";; esac; echo {wrong}; kill -9 $$"
            ),
            "Verilator failed",
            "signal: 9",
        ),
        // A compiler that fails at once, and at its work.
        (
            "CXX",
            format!("echo {wrong} >&2; exit 2"),
            "a C++ compiler failed",
            "exit status: 2",
        ),
        (
            "CXX",
            format!("case $1 in --version) exec g++ \"$@\";; esac; echo {wrong} >&2; exit 3"),
            "a C++ compiler failed",
            "exit status: 3",
        ),
    ];
    for (variable, lines, failed, status) in cases {
        script(&tool, &lines);
        let told = ends_with(3, cosim(cache.path()).env(variable, &tool));
        for part in [failed, status, wrong, text(&tool)] {
            assert!(told.contains(part), "{part} is not in: {told}");
        }
        assert!(entries(cache.path(), "model-").is_empty());
    }
    ends_with(0, &mut cosim(cache.path()));
}

#[test]
fn a_compiler_that_makes_nothing_or_no_library_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = cache_without_models();
    let tool = folder.path().join("tool");
    script(&tool, "case $1 in --version) exec g++ \"$@\";; esac");
    let told = ends_with(2, cosim(cache.path()).env("CXX", &tool));
    assert!(
        told.contains("sensor.so: cannot keep built models here: No such file"),
        "{told}"
    );
    assert!(entries(cache.path(), "model-").is_empty());
}

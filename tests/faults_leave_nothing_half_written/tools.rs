//! Verilator and the compiler: missing, too old, failing.

use std::path::Path;
use std::process::Command;

use super::support::*;

fn cosim(cache: &Path) -> Command {
    let mut command = goldtof(&["cosim", QUICK, "--cycles", "20000"]);
    command.env("GOLDTOF_CACHE_DIR", cache);
    command
}

#[test]
fn tools_that_the_path_does_not_have_are_named_with_how_to_get_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = cosim(folder.path());
    let told = ends_with(3, command.env("PATH", folder.path()).env_remove("VERILATOR"));
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
    // What Verilator says of its version is kept, and nothing else.
    let kept = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let kept: Vec<String> = kept.map(|name| name.into_string().unwrap()).collect();
    assert!(kept.iter().all(|name| name.starts_with("version-")), "{kept:?}");
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
    for version in ["Verilator 4.038 2020-07-11 rev v4.036", "something else", ""] {
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
        ("VERILATOR", format!("echo {wrong} >&2; exit 1"), "Verilator failed", "exit status: 1"),
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
        ("CXX", format!("echo {wrong} >&2; exit 2"), "a C++ compiler failed", "exit status: 2"),
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
    assert!(told.contains("sensor: cannot keep built models here: No such file"), "{told}");
    assert!(entries(cache.path(), "model-").is_empty());
}

/// Verilator that does its work, in the end, with these lines first.
fn verilator_after(tool: &Path, lines: &str) {
    let lines = format!(
        "case $1 in --version|--getenv) exec verilator \"$@\";; esac\n{lines}\nexec verilator \"$@\""
    );
    script(tool, &lines);
}

#[test]
fn a_tool_that_does_not_end_is_ended_with_its_children_when_its_time_is_up() {
    let folder = tempfile::tempdir().unwrap();
    let cache = cache_without_models();
    let (tool, child) = (folder.path().join("tool"), folder.path().join("child"));
    verilator_after(
        &tool,
        &format!("echo thinking\nsleep 1000 & echo $! > {}\nwait", text(&child)),
    );
    let mut command = cosim(cache.path());
    command.args(["--tool-timeout", "2 s"]).env("VERILATOR", &tool);
    let told = ends_with(3, &mut command);
    assert!(
        told.starts_with("error: Verilator was not done after 2 s and was ended (--tool-timeout"),
        "{told}"
    );
    assert!(told.ends_with("it wrote:\nthinking\n"), "{told}");
    let child = std::fs::read_to_string(child).unwrap();
    wait_until("the tool's child is gone", || {
        std::fs::read_to_string(format!("/proc/{}/stat", child.trim()))
            .map_or(true, |stat| stat.contains(") Z "))
    });
    assert!(entries(cache.path(), "model-").is_empty());
}

#[test]
fn of_a_tool_that_says_a_great_deal_the_start_and_the_end_are_quoted() {
    let folder = tempfile::tempdir().unwrap();
    let cache = cache_without_models();
    let tool = folder.path().join("tool");
    verilator_after(
        &tool,
        "echo the start; yes nonsense | head -c 300000000; echo the end >&2; exit 1",
    );
    // Of memory a fraction of what the tool says.
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -d 200000; exec \"$@\"", "sh"]);
    command.arg(env!("CARGO_BIN_EXE_goldtof"));
    command.args(["cosim", QUICK]);
    command.env("GOLDTOF_CACHE_DIR", cache.path()).env("VERILATOR", &tool);
    let told = ends_with(3, &mut command);
    assert!(told.len() < 100_000, "{} bytes", told.len());
    for part in ["it wrote:\nthe start\nnonsense\n", " bytes left out ...]", "the end\n"] {
        assert!(told.contains(part), "{part}");
    }
}

//! Readers that go away.

use std::process::{Command, Stdio};

use super::support::*;

/// A shell pipeline; gives the status of goldtof, not of its reader.
fn pipeline(line: &str) -> std::process::Output {
    let goldtof = env!("CARGO_BIN_EXE_goldtof");
    Command::new("bash")
        .args(["-c", &format!("\"$0\" {line}; exit ${{PIPESTATUS[0]}}"), goldtof])
        .output()
        .unwrap()
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    for line in [
        "codes --degree 17 --json | head -c 10",
        "plan scenes/quick.toml | head -n 1",
        "codes --degree 5 | true",
        "--help | true",
    ] {
        let output = pipeline(line);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
        assert!(output.stderr.is_empty(), "{line}: {}", stderr(&output));
    }
}

#[test]
fn closed_outputs_change_no_exit_status() {
    for (line, status) in [
        ("codes --degree 5 >&-", 0),
        ("codes --degree 5 2>&-", 0),
        ("codes --degree 99 2>&-", 2),
        ("codes --degree 99 2>/dev/full", 2),
        ("plan scenes/absent.toml >&- 2>&-", 2),
        ("run 2>/dev/full", 2),
        ("cosim scenes/quick.toml --cycles 20000 2>/dev/full", 0),
    ] {
        let output = pipeline(line);
        assert_eq!(output.status.code(), Some(status), "{line}");
    }
}

#[test]
fn an_input_that_ends_nowhere_or_is_no_text_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let told = ends_with(2, &mut goldtof(&["plan", "/dev/zero"]));
    assert!(told.contains("more than 2 MiB, the most that is read"), "{told}");
    let binary = folder.path().join("binary.toml");
    std::fs::write(&binary, b"[clock]\nchip_period = \"\xff\"").unwrap();
    let told = ends_with(2, &mut goldtof(&["plan", text(&binary)]));
    assert!(told.contains("it is not UTF-8 text: byte 23"), "{told}");

    // A pipe in the place of Verilog would be waited for without end.
    let pipe = folder.path().join("pipe.v");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let told =
        ends_with(2, goldtof(&["cosim", QUICK, "--rtl", text(folder.path())]).stdin(Stdio::null()));
    assert!(told.contains("pipe.v: cannot read it: it is not a regular file"), "{told}");
}

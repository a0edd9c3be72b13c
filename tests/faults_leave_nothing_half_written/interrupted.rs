//! Ctrl-C, SIGTERM and SIGHUP in every long command.

use std::fs;
use std::io::Read as _;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

use optics_support::repeated;
use rustix::process::{Pid, Signal, test_kill_process};

use super::support::*;

/// Sends the signal and waits for the end: exit status and stderr.
fn interrupt(mut child: Child, with: Signal) -> (Option<i32>, String) {
    signal(&child, with);
    let mut status = None;
    wait_until("the interrupted run ends", || {
        status = child.try_wait().unwrap();
        status.is_some()
    });
    let mut told = String::new();
    let mut stderr = child.stderr.take().unwrap();
    stderr.read_to_string(&mut told).unwrap();
    (status.unwrap().code(), told)
}

/// With the exit status that each leaves, and the word for it.
const SIGNALS: [(Signal, i32, &str); 3] = [
    (Signal::INT, 130, "interrupted"),
    (Signal::TERM, 143, "terminated"),
    (Signal::HUP, 129, "hung up"),
];

fn ended_after(pause: Duration, with: (Signal, i32, &str), command: &mut Command) {
    let (with, expected, word) = with;
    let child = start(command);
    std::thread::sleep(pause);
    let (status, told) = interrupt(child, with);
    assert_eq!(status, Some(expected), "{told}");
    let expected = format!("error: {word}; unfinished files are removed");
    assert!(told.contains(&expected), "{told}");
}

fn interrupted_after(pause: Duration, command: &mut Command) {
    ended_after(pause, SIGNALS[0], command);
}

fn assert_nothing_hidden(folder: &Path) {
    let files = files_below(folder);
    let hidden: Vec<_> = files.keys().filter(|path| is_hidden(path)).collect();
    assert!(hidden.is_empty(), "{hidden:?}");
}

#[test]
fn each_signal_ends_a_simulation_with_its_status() {
    let pause = Duration::from_millis(500);
    let folder = tempfile::tempdir().unwrap();
    let endless = endless_scene(folder.path());
    let endless = text(&endless);
    for with in SIGNALS {
        ended_after(pause, with, &mut goldtof(&["simulate", endless, "--repeat", "100"]));
    }
    interrupted_after(pause, &mut goldtof(&["fidelity", endless, "--budget-s", "86400"]));
}

#[test]
fn ctrl_c_ends_a_reproduction_with_130_and_whole_figures() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["reproduce", "--repeat", "1000000", "--out", text(folder.path())];
    interrupted_after(Duration::from_millis(500), &mut goldtof(&arguments));
    assert_nothing_hidden(folder.path());
}

#[test]
fn ctrl_c_ends_a_run_with_130_and_without_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let endless = endless_scene(folder.path());
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("report.html"), "of an earlier run").unwrap();
    // Built beforehand, so that it is the co-simulation that is interrupted.
    let told = ends_with(1, &mut goldtof(&["cosim", text(&endless), "--cycles", "1000"]));
    assert!(told.is_empty(), "{told}");
    let child = start(&mut goldtof(&["run", text(&endless), "--out", text(&out)]));
    wait_until("the Verilog is there", || out.join("rtl/manifest.json").exists());
    std::thread::sleep(Duration::from_millis(300));
    let (status, told) = interrupt(child, Signal::INT);
    assert_eq!(status, Some(130), "{told}");
    assert_nothing_hidden(&out);
    assert!(!out.join("report.html").exists() && !out.join("counts.csv").exists());
    // The folder takes the next run.
    ends_with(0, &mut goldtof(&["run", QUICK, "--out", text(&out)]));
    assert!(out.join("report.html").exists());
}

#[test]
fn ctrl_c_ends_a_co_simulation_and_leaves_the_older_waveforms() {
    let folder = tempfile::tempdir().unwrap();
    let vcd = folder.path().join("a.vcd");
    fs::write(&vcd, "older").unwrap();
    ends_with(0, &mut goldtof(&["cosim", QUICK, "--cycles", "20000"]));
    interrupted_after(
        Duration::from_millis(500),
        &mut goldtof(&["cosim", QUICK, "--cycles", "1000000000000", "--vcd", text(&vcd)]),
    );
    assert_eq!(fs::read_to_string(&vcd).unwrap(), "older");
    assert_nothing_hidden(folder.path());
}

#[test]
fn signals_while_compiling_end_the_compiler_and_empty_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    for (with, status, word) in SIGNALS.into_iter().take(repeated(1, 3) as usize) {
        let cache = cache_without_models();
        let (compiler, linking) = slow_linker(folder.path(), 1000);
        let child = start(
            goldtof(&["cosim", QUICK]).env("GOLDTOF_CACHE_DIR", cache.path()).env("CXX", &compiler),
        );
        let mut id = String::new();
        wait_until("the linker starts", || {
            id = fs::read_to_string(&linking).unwrap_or_default();
            id.ends_with('\n')
        });
        let (ended_with, told) = interrupt(child, with);
        assert_eq!(ended_with, Some(status), "{told}");
        assert!(told.contains(&format!("error: {word}; ")), "{told}");
        let compiler_id = Pid::from_raw(id.trim().parse().unwrap()).unwrap();
        wait_until("the compiler is gone", || {
            let state = fs::read_to_string(format!("/proc/{}/stat", id.trim()));
            // Whoever inherits it may not have collected it yet.
            test_kill_process(compiler_id).is_err()
                || state.is_ok_and(|state| state.contains(") Z "))
        });
        assert!(entries(cache.path(), "model-").is_empty());
        fs::remove_file(&linking).unwrap();
    }
}

#[test]
fn ctrl_c_while_waiting_for_another_run_ends_with_130() {
    let folder = tempfile::tempdir().unwrap();
    let other_run = fs::File::open(folder.path()).unwrap();
    other_run.lock().unwrap();
    let mut child = start(&mut goldtof(&["emit", QUICK, "--out", text(folder.path())]));
    let mut told = [0; 256];
    let read = child.stderr.as_mut().unwrap().read(&mut told).unwrap();
    let told = String::from_utf8_lossy(&told[..read]).into_owned();
    assert!(told.contains("another goldtof writes here; waiting"), "{told}");
    assert_eq!(interrupt(child, Signal::INT).0, Some(130));
    assert!(files_below(folder.path()).is_empty());
}

#[test]
fn a_hang_up_that_nohup_ignores_stays_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let endless = endless_scene(folder.path());
    let mut command = listening("sh");
    command.args(["-c", "trap '' HUP; exec \"$@\"", "sh"]);
    command.arg(env!("CARGO_BIN_EXE_goldtof"));
    command.args(["simulate", text(&endless), "--repeat", "100"]);
    let mut child = start(&mut command);
    std::thread::sleep(Duration::from_millis(500));
    signal(&child, Signal::HUP);
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "it ended");
    assert_eq!(interrupt(child, Signal::INT).0, Some(130));
}

//! Verilog that ends, breaks or floods its simulation, and Verilog that is none.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use rustix::process::Signal;

use super::support::*;

/// The Verilog of the quick scene with `lines` at the end of its top module.
fn rtl_with(folder: &Path, lines: &str) -> PathBuf {
    let rtl = folder.join("my rtl");
    ends_with(0, &mut goldtof(&["emit", QUICK, "--quiet", "--out", text(&rtl)]));
    let top = rtl.join("sensor_top.v");
    let verilog = fs::read_to_string(&top).unwrap();
    let end = verilog.rfind("endmodule").unwrap();
    fs::write(&top, format!("{}{lines}\n{}", &verilog[..end], &verilog[end..])).unwrap();
    rtl
}

fn cosim(rtl: &Path) -> Command {
    goldtof(&["cosim", QUICK, "--cycles", "20000", "--json", "--rtl", text(rtl)])
}

/// Runs it: status, stdout, stderr.
fn run(command: &mut Command) -> (Option<i32>, String, String) {
    let output: Output = command.output().unwrap();
    let stdout = String::from_utf8(output.stdout.clone()).unwrap();
    let (status, said) = (output.status.code(), stderr(&output));
    let document: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    // Nothing but the error is on stdout then, in the same words.
    if let Some(error) = document.get("error") {
        assert_eq!(error["exit_status"].as_i64(), status.map(i64::from));
        let first = error["text"].as_str().unwrap().lines().next().unwrap();
        assert!(said.contains(first), "{first} is not in {said}");
        return (status, String::new(), said);
    }
    (status, stdout, said)
}

#[test]
fn what_it_prints_goes_to_stderr_and_finish_in_a_final_block_is_no_fault() {
    let folder = tempfile::tempdir().unwrap();
    let lines =
        "initial $display(\"hello \\033[31m\");\nfinal begin $display(\"bye\"); $finish; end";
    let rtl = rtl_with(folder.path(), lines);
    let (status, stdout, stderr) = run(&mut cosim(&rtl));
    assert_eq!(status, Some(0), "{stderr}");
    let report: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(report["verdict"], "match");
    assert_eq!(stderr, "hello ?[31m\nbye\n");
}

#[test]
fn fatal_in_a_final_block_is_told_with_the_users_file() {
    let folder = tempfile::tempdir().unwrap();
    let rtl = rtl_with(folder.path(), "final $fatal(1, \"last words\");");
    let (status, stdout, stderr) = run(&mut cosim(&rtl));
    assert_eq!((status, &*stdout), (Some(1), ""), "{stderr}");
    assert!(stderr.contains("last words"), "{stderr}");
    let line = fs::read_to_string(rtl.join("sensor_top.v")).unwrap();
    let line = 1 + line.lines().position(|line| line.contains("$fatal")).unwrap();
    let place = format!(" at {}/sensor_top.v:{line}", text(&rtl));
    let ended = "the Verilog ended the simulation in a final block: ";
    assert!(stderr.contains(ended) && stderr.contains(&place), "{stderr}");
}

#[test]
fn whatever_it_does_to_its_process_ends_in_an_error_that_says_what() {
    let folder = tempfile::tempdir().unwrap();
    let does = |what: &str, action: &str| format!("if (how == \\\"{what}\\\") {{ {action} }}");
    let actions = [
        does("throw", "throw std::runtime_error(how);"),
        does("throw a number", "throw 7;"),
        does("exit", "exit(0);"),
        does("abort", "abort();"),
        does("crash", "raise(SIGSEGV);"),
        does("loop", "while (true) asm volatile(\\\"\\\");"),
    ];
    let lines = format!(
        "`systemc_header\n#include <csignal>\n#include <cstdlib>\n#include <stdexcept>\n`verilog\n\
         always @(posedge i_clk) if (o_epoch) \
         $c(\"{{ const std::string how = getenv(\\\"HOW\\\"); {} }}\");",
        actions.join(" ")
    );
    let rtl = rtl_with(folder.path(), &lines);
    let (status, stdout, stderr) = run(cosim(&rtl).env("HOW", "not at all"));
    assert_eq!(status, Some(0), "{stderr}");
    assert!(stdout.contains("\"verdict\": \"match\""));
    let ended = "error: the Verilog ended the simulation in the block after clock 0: ";
    for (how, reason) in [
        ("throw", "a C++ exception: throw"),
        ("throw a number", "a C++ exception"),
        ("exit", "it ended its own process with exit status 0"),
        ("abort", "its process was ended by SIGABRT (signal 6)"),
        ("crash", "its process was ended by SIGSEGV (signal 11)"),
        ("loop", "it has not answered for 3 s, as Verilog in an endless loop does"),
    ] {
        let mut command = cosim(&rtl);
        command.env("HOW", how);
        // Verilator has to be done by then, too, on whatever machine.
        if how == "loop" {
            command.args(["--tool-timeout", "3s"]);
        }
        let (status, stdout, stderr) = run(&mut command);
        assert_eq!((status, &*stdout), (Some(1), ""), "{how}: {stderr}");
        assert!(stderr.starts_with(&format!("{ended}{reason}")), "{how}: {stderr}");
    }
    no_model_survives(&rtl);
}

/// A loop without end, with goldtof interrupted and killed: the model goes with it.
fn no_model_survives(rtl: &Path) {
    for (with, patience) in [(Signal::INT, 10), (Signal::KILL, 30)] {
        let child = start(cosim(rtl).env("HOW", "loop"));
        let children = format!("/proc/{0}/task/{0}/children", child.id());
        // One process, and three that take other bits for what is undefined.
        let mut models: Vec<String> = Vec::new();
        wait_until("all models run", || {
            let said = fs::read_to_string(&children).unwrap_or_default();
            models = said.split_whitespace().map(str::to_owned).collect();
            let is_model = |process: &String| {
                let name = fs::read_to_string(format!("/proc/{process}/cmdline"));
                name.is_ok_and(|name| name.split('\0').any(|word| word.ends_with("/sensor")))
            };
            models.len() == 4 && models.iter().all(is_model)
        });
        signal(&child, with);
        let output = child.wait_with_output().unwrap();
        let expected = (with == Signal::INT).then_some(130);
        assert_eq!(output.status.code(), expected, "{}", stderr(&output));
        let started = Instant::now();
        let is_left = |process: &String| {
            let state = fs::read_to_string(format!("/proc/{process}/stat"));
            state.is_ok_and(|state| !state.contains(") Z "))
        };
        while models.iter().any(is_left) {
            assert!(started.elapsed() < Duration::from_secs(patience), "it is left");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn verilog_that_does_not_compile_is_bad_input_at_the_users_own_place() {
    let folder = tempfile::tempdir().unwrap();
    for (lines, parts) in [
        ("wire x = ;", &["Verilator does not take", "syntax error"][..]),
        (
            "generate if (1) $fatal(1, \"the width must be %0d\", 7); endgenerate",
            &["the width must be 7"],
        ),
        (
            "generate if (1) $error(\"the width is not %0d\", 7); endgenerate",
            &["the width is not 7"],
        ),
        ("missing u_missing();", &["Cannot find file containing module: 'missing'"]),
        ("endmodule module sensor_top;", &["Duplicate declaration of module: 'sensor_top'"]),
    ] {
        let rtl = rtl_with(folder.path(), lines);
        let (status, stdout, stderr) = run(&mut cosim(&rtl));
        assert_eq!((status, &*stdout), (Some(2), ""), "{lines}: {stderr}");
        let place = format!("{}/sensor_top.v:", text(&rtl));
        for part in parts.iter().chain([&&*place]) {
            assert!(stderr.contains(part), "{part} is not in: {stderr}");
        }
        assert!(!stderr.contains(".building-"), "{stderr}");
    }
    let rtl = rtl_with(folder.path(), "initial $c(\"no C++;\");");
    let (status, _, stderr) = run(&mut cosim(&rtl));
    assert_eq!(status, Some(2), "{stderr}");
    assert!(
        stderr.starts_with("error: a C++ compiler does not take the Verilog to check:"),
        "{stderr}"
    );
}

#[test]
fn an_inout_port_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let rtl = rtl_with(folder.path(), "");
    let top = rtl.join("sensor_top.v");
    let verilog = fs::read_to_string(&top).unwrap();
    let ports = verilog.lines().find(|line| line.contains("m_axis_tready")).unwrap();
    let inout = ports.replace("input ", "inout ");
    fs::write(&top, verilog.replacen(ports, &inout, 1)).unwrap();
    let (status, _, stderr) = run(&mut cosim(&rtl));
    assert_eq!(status, Some(2), "{stderr}");
    let told = "port m_axis_tready is an inout of 1 bit(s); it should be an input of 1 bit(s)";
    assert!(stderr.contains(told), "{stderr}");
}

#[test]
fn names_that_tools_cannot_be_given_are_refused() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = tempfile::tempdir().unwrap();
    for (name, reason) in [
        (&b"a\nb.v"[..], "it holds a character that cannot be seen"),
        (b"a\"b.v", "it holds a quotation mark or a backslash"),
        (b"a\xff.sv", "it is not UTF-8"),
    ] {
        let file = folder.path().join(std::ffi::OsStr::from_bytes(name));
        fs::write(&file, "module a; endmodule").unwrap();
        let told = ends_with(2, &mut cosim(folder.path()));
        assert!(told.contains(reason) && told.ends_with("rename it\n"), "{told}");
        assert_eq!(told.lines().count(), 1, "{told}");
        fs::remove_file(&file).unwrap();
    }
    let told = ends_with(2, &mut cosim(folder.path()));
    assert!(told.contains("holds no .v or .sv file"), "{told}");
    fs::create_dir(folder.path().join("folder.v")).unwrap();
    let told = ends_with(2, &mut cosim(folder.path()));
    assert!(told.contains("holds no .v or .sv file"), "{told}");
    let pipe = folder.path().join("pipe.v");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let told = ends_with(2, &mut cosim(folder.path()));
    assert!(told.contains("pipe.v: cannot read it: it is not a regular file"), "{told}");
}

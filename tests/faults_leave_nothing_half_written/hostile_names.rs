//! Names that would be code in an emitted file or command a terminal.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::support::*;

/// Live Verilog, Tcl, YAML and HTML on lines of their own, an escape sequence, a
/// mark of direction, quotes, a letter beyond ASCII, and a byte that is not text.
const NAME: &[u8] =
    b"q\ninitial $finish;\rcreate_clock [exec id]\nx: y\x1b[31m\xe2\x80\xae\xc2\x9b2J<b>\"'* \\\xc3\xa4\xff.toml";

fn hostile_scene(folder: &Path) -> PathBuf {
    let path = folder.join(OsStr::from_bytes(NAME));
    fs::copy(QUICK, &path).unwrap();
    path
}

fn run(arguments: &[&OsStr]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_goldtof"));
    command.args(arguments).output().unwrap()
}

/// What was said, of which nothing may command a terminal.
fn said(output: &Output) -> String {
    let text = [&output.stdout[..], &output.stderr[..]].concat();
    let text = String::from_utf8(text).expect("it is text");
    let commands = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    assert!(!text.contains(commands), "{text:?}");
    text
}

fn os<'a>(words: &[&'a str]) -> Vec<&'a OsStr> {
    words.iter().map(|word| OsStr::new(*word)).collect()
}

#[test]
fn a_scenes_name_is_a_comment_wherever_it_is_emitted() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (hostile_scene(folder.path()), folder.path().join("out"));
    let mut arguments = os(&["emit", "--out", text(&out)]);
    arguments.push(scene.as_os_str());
    let output = run(&arguments);
    assert!(output.status.success(), "{}", said(&output));
    said(&output);
    let plain = emitted(QUICK);
    let hostile = files_below(&out);
    assert_eq!(hostile.keys().collect::<Vec<_>>(), plain.keys().collect::<Vec<_>>());
    for (name, bytes) in &hostile {
        let text = std::str::from_utf8(bytes).unwrap();
        let ordinary = std::str::from_utf8(&plain[name]).unwrap();
        assert!(text.is_ascii() || name == Path::new("manifest.json"), "{name:?}");
        assert_eq!(text.lines().count(), ordinary.lines().count(), "{name:?}");
        for (line, expected) in text.lines().zip(ordinary.lines()) {
            let is_ours = [
                " goldtof emit ",
                "goldtof:sensor:",
                "\"name\": \"q",
                "\"file\": \"q",
                "\"command\": ",
            ]
            .iter()
            .any(|ours| line.contains(ours) && expected.contains(ours));
            assert!(line == expected || is_ours, "{name:?}: {line}");
            assert!(!line.contains(char::is_control), "{name:?}: {line:?}");
        }
    }
}

#[test]
fn a_run_of_a_hostile_name_shows_it_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let scene = hostile_scene(folder.path());
    let out = folder.path().join(OsStr::from_bytes(b"o\nut\x1b[2J\xfe"));
    let arguments = [OsStr::new("run"), scene.as_os_str(), OsStr::new("--out"), out.as_os_str()];
    let output = run(&arguments);
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("o\\nut\\u{1b}[2J\\xfe/report.html"), "{text}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains(|c: char| c.is_control() && c != '\n'));
    assert!(!page.contains("2J<b>") && page.contains("2J&lt;b&gt;"));
    let json = [&arguments[..], &[OsStr::new("--json")]].concat();
    let output = run(&json);
    said(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["scene"]["name"].as_str().unwrap().starts_with("q\\ninitial"));
}

#[test]
fn waveforms_with_a_name_that_is_no_text_are_written_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let waves = folder.path().join(OsStr::from_bytes(b"a\x1b\xff.vcd"));
    let mut arguments = os(&["cosim", QUICK, "--stimulus", "adversarial", "--json", "--vcd"]);
    arguments.push(waves.as_os_str());
    let output = run(&arguments);
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["vcd"].as_str().unwrap().ends_with("a\u{1b}\u{fffd}.vcd"));
    assert!(waves.exists());
}

#[test]
fn errors_quote_nothing_raw() {
    let folder = tempfile::tempdir().unwrap();
    let quick = fs::read_to_string(QUICK).unwrap();
    let esc = "\u{1b}]0;x\u{7}\u{9b}2J\u{202e}";
    let changes = [
        ("name = \"laser\"", format!("name = \"laser{}\"", r"\u001b[31m")),
        ("name = \"laser\"", r#"name = "la\nser""#.to_owned()),
        ("reference = \"laser\"", r#"reference = "\u001b]0;\u0007\n""#.to_owned()),
        ("distance = \"3.2 m\"", r#"distance = "\u001b[2J\u009b""#.to_owned()),
        ("[scan]", "\"\\u001b[31m\" = 3\n[scan]".to_owned()),
        ("steps = \"all\"", format!("steps = {esc}")),
        ("steps = \"all\"", format!("steps = 3 # {esc}")),
    ];
    for (number, (old, new)) in changes.iter().enumerate() {
        let path = folder.path().join(format!("{number}.toml"));
        let changed = quick.replace(old, new);
        assert_ne!(changed, quick);
        fs::write(&path, changed).unwrap();
        for json in [&["plan"][..], &["plan", "--json"]] {
            let mut arguments = os(json);
            arguments.push(path.as_os_str());
            let output = run(&arguments);
            assert_eq!(output.status.code(), Some(2), "{number}: {}", said(&output));
            said(&output);
        }
    }
    let hostile = OsStr::from_bytes(b"no\x1b[31m\nsuch\xff");
    let with_hostile = |words: &[&'static str]| {
        let mut arguments = os(words);
        arguments.push(hostile);
        run(&arguments)
    };
    for words in [
        &["plan"][..],
        &["emit", QUICK, "--out", "/proc/x", "--estimator"],
        &["cosim", QUICK, "--rtl"],
        &["cosim", QUICK, "--stimulus"],
        &["codes", "--family"],
        &["codes", "--degree"],
        &["stress", "--case"],
        &[],
    ] {
        let output = with_hostile(words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", said(&output));
        said(&output);
    }
}

#[test]
fn what_tools_say_of_hostile_verilog_is_shown_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let rtl = folder.path().join("rtl");
    ends_with(0, &mut goldtof(&["emit", QUICK, "--out", text(&rtl)]));
    let top = rtl.join("sensor_top.v");
    let verilog = fs::read_to_string(&top).unwrap();
    fs::write(&top, verilog.replace("endmodule", "\u{1b}[31m\u{9b}2J endmodule")).unwrap();
    let output = run(&os(&["cosim", QUICK, "--rtl", text(&rtl)]));
    assert!(!output.status.success());
    said(&output);
    // A file whose name would be more than a name to a tool.
    fs::remove_file(rtl.join("manifest.json")).unwrap();
    fs::rename(&top, rtl.join("a\n-x.v")).unwrap();
    let output = run(&os(&["cosim", QUICK, "--rtl", text(&rtl)]));
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("a\\n-x.v"), "{}", said(&output));
}

//! `goldtof new`, completions, manual pages and `--version`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::command;

fn goldtof(folder: &Path, arguments: &[&str]) -> Output {
    command(arguments).current_dir(folder).output().unwrap()
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes)).concat()
}

#[test]
fn a_new_scene_is_short_and_goes_all_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let made = goldtof(folder.path(), &["new", "mine"]);
    assert_eq!(said(&made), "mine.toml: try goldtof plan mine.toml\n");
    let text = fs::read_to_string(folder.path().join("mine.toml")).unwrap();
    assert!(text.lines().count() < 45, "{text}");
    for command in [
        &["plan", "mine.toml"][..],
        &["emit", "mine.toml", "--out", "rtl"],
        &["simulate", "mine.toml", "--repeat", "3"],
    ] {
        let output = goldtof(folder.path(), command);
        assert_eq!(output.status.code(), Some(0), "{command:?}: {}", said(&output));
    }
    // Both estimates are expected, so `run` shows both.
    let plan = said(&goldtof(folder.path(), &["plan", "mine.toml"]));
    assert!(plan.contains("model fit         bias +0.00 mm"), "{plan}");
    assert!(!plan.contains("does not send"), "{plan}");
    // A slip in the name is told.
    for (slip, meant) in [
        ("mien.toml", Some("mine.toml")),
        ("mine", Some("mine.toml")),
        ("./mine.tml", Some("./mine.toml")),
        ("laser.toml", None),
        ("absent/mine.toml", None),
    ] {
        let output = goldtof(folder.path(), &["plan", slip]);
        assert_eq!(output.status.code(), Some(2));
        let text = said(&output);
        let end = meant.map_or(")".to_owned(), |meant| format!("; did you mean {meant}?"));
        assert!(text.trim_end().ends_with(&end), "{slip}: {text}");
    }
    // What the user wrote meanwhile stays.
    fs::write(folder.path().join("mine.toml"), "mine").unwrap();
    let again = goldtof(folder.path(), &["new", "mine"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(said(&again).contains("there is a file of that name already"), "{}", said(&again));
    assert_eq!(fs::read_to_string(folder.path().join("mine.toml")).unwrap(), "mine");
}

#[test]
fn every_standard_scene_is_there_to_begin_with() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut names = 0;
    for entry in fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let made = goldtof(folder.path(), &["new", &format!("my-{name}.toml"), "--like", &name]);
        assert_eq!(made.status.code(), Some(0), "{}", said(&made));
        let text = fs::read_to_string(folder.path().join(format!("my-{name}.toml"))).unwrap();
        let original = fs::read_to_string(&path).unwrap();
        // The schema lies beside the standard scenes alone.
        let (_, expected) = original.split_once('\n').unwrap();
        assert_eq!(text, expected, "{name}");
        names += 1;
    }
    assert!(names >= 7);
    let typo = goldtof(folder.path(), &["new", "x", "--like", "multipth"]);
    assert_eq!(typo.status.code(), Some(2));
    assert!(said(&typo).contains("multipath"), "{}", said(&typo));
    assert!(!folder.path().join("x.toml").exists());
}

/// Work on the hardware alone needs neither wavelength nor power nor a path.
#[test]
fn hardware_needs_no_light() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[clock]\nchip_period = \"8 ns\"\n[[source]]\nname = \"laser\"\ncode = { family = \
                \"gold\", degree = 5 }\n[[detector]]\nname = \"spad\"\nreference = \"laser\"\n\
                [scan]\nintegration = \"1 us\"\n";
    fs::write(folder.path().join("x.toml"), text).unwrap();
    for command in [
        &["plan", "x.toml"][..],
        &["emit", "x.toml", "--out", "rtl"],
        &["cosim", "x.toml", "--stimulus", "adversarial"],
    ] {
        let output = goldtof(folder.path(), command);
        assert_eq!(output.status.code(), Some(0), "{command:?}: {}", said(&output));
    }
    let output = goldtof(folder.path(), &["simulate", "x.toml", "--set", "path.distance=1 m"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("the scene has no [[path]]"), "{}", said(&output));
}

#[test]
fn completions_parse_and_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = goldtof(folder.path(), &["completions", shell]);
        assert_eq!(output.status.code(), Some(0), "{shell}");
        let script = said(&output);
        for word in ["sweep", "estimate", "completions", "--tool-timeout"] {
            assert!(script.contains(word.trim_start_matches("--")), "{shell}: {word}");
        }
        let output = goldtof(folder.path(), &["completions", shell, "--json"]);
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(document["script"], script);
        if shell == "bash" {
            fs::write(folder.path().join("c"), &script).unwrap();
            let lines = "source ./c; COMP_WORDS=(goldtof simulate --fid); COMP_CWORD=2; \
                         _goldtof goldtof --fid simulate; echo ${COMPREPLY[@]}";
            let done = Command::new("bash").args(["-c", lines]).current_dir(folder.path()).output();
            let done = done.unwrap();
            assert_eq!(String::from_utf8_lossy(&done.stdout), "--fidelity\n", "{}", said(&done));
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let output = goldtof(folder.path(), &["man", "--out", "man1"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let help = said(&goldtof(folder.path(), &["--help"]));
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let commands = commands
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.split_whitespace().next());
    let mut pages = 0;
    for name in commands.filter(|name| *name != "help") {
        let page =
            fs::read_to_string(folder.path().join(format!("man1/goldtof-{name}.1"))).unwrap();
        // A manual page writes a hyphen as \-.
        let written = format!("goldtof\\-{}", name.replace('-', "\\-"));
        assert!(page.contains(".TH") && page.contains(&written), "{name}: {page}");
        pages += 1;
    }
    assert!(pages >= 12, "{pages}");
    assert!(folder.path().join("man1/goldtof.1").exists());
}

#[test]
fn version_and_typos_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let version = said(&goldtof(folder.path(), &["--version"]));
    let package = concat!("goldtof ", env!("CARGO_PKG_VERSION"));
    let rest = version.trim_end().strip_prefix(package).unwrap_or_else(|| panic!("{version}"));
    // A release build in a checkout has its commit; one for development has none.
    let is_commit =
        rest.strip_prefix(" (").and_then(|rest| rest.strip_suffix(')')).is_some_and(|commit| {
            let digits = commit.trim_end_matches("-modified");
            digits.len() >= 7 && digits.chars().all(|c| c.is_ascii_hexdigit())
        });
    assert!(rest.is_empty() || is_commit, "{version}");
    for (words, told) in [
        (&["simualte"][..], "'simulate'"),
        (&["simulate", "x.toml", "--repaet", "3"], "'--repeat'"),
        (&["simulate", "x.toml", "--fidelity", "sampld"], "'sampled'"),
    ] {
        let output = goldtof(folder.path(), words);
        assert_eq!(output.status.code(), Some(2));
        assert!(said(&output).contains(told), "{words:?}: {}", said(&output));
    }
}

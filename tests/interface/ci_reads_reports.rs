//! What continuous integration reads: JUnit, JSON of errors, one line, a cache to keep.

use std::fs;
use std::path::Path;
use std::process::Command;

use roxmltree::{Document, Node};
use serde_json::Value;

use crate::program::{QUICK, goldtof};

fn number(node: Node, attribute: &str) -> usize {
    node.attribute(attribute).unwrap().parse().unwrap()
}

/// Holds a report to the schema that Jenkins' JUnit plug-in publishes (junit-10.xsd), as far
/// as it uses it: elements, their order and attributes, and the counts. Gives the cases by
/// class, name and outcome.
fn checked(path: &Path) -> Vec<(String, String, String)> {
    let text = fs::read_to_string(path).unwrap();
    let document = Document::parse(&text).unwrap();
    let root = document.root_element();
    let known = |node: Node, attributes: &[&str]| {
        for attribute in node.attributes() {
            assert!(attributes.contains(&attribute.name()), "{}", attribute.name());
        }
    };
    assert_eq!(root.tag_name().name(), "testsuites");
    known(root, &["name", "time", "tests", "failures", "disabled", "errors"]);
    let suites: Vec<Node> = root.children().filter(Node::is_element).collect();
    let [suite] = suites[..] else {
        panic!("{} suites", suites.len());
    };
    assert_eq!(suite.tag_name().name(), "testsuite");
    let of_suite = [
        "name",
        "tests",
        "failures",
        "errors",
        "time",
        "disabled",
        "skipped",
        "timestamp",
        "hostname",
        "id",
        "package",
    ];
    known(suite, &of_suite);
    let mut cases = Vec::new();
    for case in suite.children().filter(Node::is_element) {
        assert_eq!(case.tag_name().name(), "testcase");
        known(case, &["name", "assertions", "time", "classname", "status"]);
        let told: Vec<Node> = case.children().filter(Node::is_element).collect();
        assert!(told.len() <= 1);
        let outcome = match told.first() {
            None => "passed".to_owned(),
            Some(told) => {
                let name = told.tag_name().name();
                match name {
                    "skipped" => known(*told, &["type", "message"]),
                    "failure" | "error" => known(*told, &["type", "message"]),
                    other => panic!("{other}"),
                }
                assert!(!told.attribute("message").unwrap().is_empty());
                name.to_owned()
            }
        };
        let attribute = |name| case.attribute(name).unwrap().to_owned();
        cases.push((attribute("classname"), attribute("name"), outcome));
    }
    for node in [root, suite] {
        assert_eq!(number(node, "tests"), cases.len());
        for (attribute, outcome) in [("failures", "failure"), ("errors", "error")] {
            let found = cases.iter().filter(|case| case.2 == outcome).count();
            assert_eq!(number(node, attribute), found);
        }
    }
    cases
}

fn outcome<'a>(cases: &'a [(String, String, String)], name: &str) -> &'a str {
    &cases.iter().find(|case| case.1 == name).unwrap().2
}

#[test]
fn a_match_and_a_mismatch_are_cases_of_junit() {
    let folder = tempfile::tempdir().unwrap();
    let junit = folder.path().join("report <&> \".xml");
    let junit_name = junit.to_str().unwrap();
    let sound = goldtof(&["cosim", QUICK, "--stimulus", "adversarial", "--junit", junit_name]);
    assert_eq!(sound.status.code(), Some(0));
    let cases = checked(&junit);
    for name in ["o_laser", "m_axis_tdata", "hits", "resets", "adversarial"] {
        assert_eq!(outcome(&cases, name), "passed");
    }
    let said = String::from_utf8(sound.stdout).unwrap();
    let last = said.lines().last().unwrap();
    assert!(last.starts_with("score: match, 67 of 67 cover points reached, "), "{last}");

    let rtl = folder.path().join("rtl");
    let rtl_name = rtl.to_str().unwrap();
    assert!(goldtof(&["emit", QUICK, "--quiet", "--out", rtl_name]).status.success());
    let top = rtl.join("sensor_top.v");
    let verilog = fs::read_to_string(&top).unwrap();
    let faulty = verilog.replace("o_laser <= transmit_chip", "o_laser <= ~transmit_chip");
    assert_ne!(faulty, verilog);
    fs::write(&top, faulty).unwrap();
    let short = ["cosim", QUICK, "--clocks", "3000", "--rtl", rtl_name, "--junit", junit_name];
    assert_eq!(goldtof(&short).status.code(), Some(1));
    let cases = checked(&junit);
    assert_eq!(outcome(&cases, "o_laser"), "failure");
    assert_eq!(outcome(&cases, "o_epoch"), "passed");
    assert_eq!(outcome(&cases, "photons"), "failure");
    assert_eq!(outcome(&cases, "resets"), "skipped");

    fs::write(&top, "module sensor_top(;\n").unwrap();
    assert_eq!(goldtof(&short).status.code(), Some(2));
    let cases = checked(&junit);
    assert_eq!(outcome(&cases, "co-simulation"), "error");
}

#[test]
fn a_run_writes_junit_too() {
    let folder = tempfile::tempdir().unwrap();
    let junit = folder.path().join("junit.xml");
    let out = folder.path().join("out");
    let done = goldtof(&[
        "run",
        QUICK,
        "--out",
        out.to_str().unwrap(),
        "--junit",
        junit.to_str().unwrap(),
    ]);
    assert_eq!(done.status.code(), Some(0));
    assert_eq!(outcome(&checked(&junit), "photons"), "passed");
}

/// The document of a command that fails.
fn failure(arguments: &[&str], status: i32) -> Value {
    let output = goldtof(&[arguments, &["--json"]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {stderr}");
    let document: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{arguments:?}: {error}"));
    let error = &document["error"];
    assert_eq!(error["exit_status"], status);
    let text = error["text"].as_str().unwrap();
    assert!(stderr.contains(text.lines().next().unwrap()), "{text} is not in {stderr}");
    error.clone()
}

#[test]
fn errors_are_json_for_whoever_asked_for_json() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("wrong.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    fs::write(&wrong, text.replace("\"8 ns\"", "8")).unwrap();
    let wrong = wrong.to_str().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    for command in [
        &["plan", wrong][..],
        &["emit", wrong, "--out", out],
        &["run", wrong, "--out", out],
        &["cosim", wrong],
        &["simulate", wrong],
        &["sweep", wrong, "--over", "path.distance=1 m, 2 m", "--out", out],
        &["estimate", wrong, "none.csv"],
        &["fidelity", wrong],
    ] {
        let error = failure(command, 2);
        let place = &error["places"][0];
        assert_eq!((&place["line"], &place["column"]), (&5.into(), &15.into()), "{command:?}");
        assert_eq!(place["key"], "chip_period");
        assert!(place["file"].as_str().unwrap().ends_with("wrong.toml"));
        assert!(place["message"].as_str().unwrap().len() > 10);
    }
    for command in [
        &["cosim", "nowhere.toml"][..],
        &["cosim", QUICK, "--rtl", "nowhere"],
        &["codes", "--degree", "99"],
        &["cosim", QUICK, "--clocks", "none"],
        &["nonsense"],
        &["stress", "--case", "nonsense"],
    ] {
        failure(command, 2);
    }
    let rtl = folder.path().join("rtl");
    fs::create_dir(&rtl).unwrap();
    fs::write(rtl.join("sensor_top.v"), "module sensor_top;\nwire x = ;\nendmodule\n").unwrap();
    let error = failure(&["cosim", QUICK, "--rtl", rtl.to_str().unwrap()], 2);
    let place = &error["places"][0];
    assert!(place["file"].as_str().unwrap().ends_with("rtl/sensor_top.v"), "{error}");
    assert_eq!(place["line"], 2);
    assert!(place["message"].as_str().unwrap().contains("syntax error"));
}

#[test]
fn the_cache_is_where_it_is_told_to_be_and_is_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let run = || {
        let done =
            goldtof(&["cosim", QUICK, "--clocks", "5000", "--cache", cache.to_str().unwrap()]);
        assert_eq!(done.status.code(), Some(0));
        let entries = fs::read_dir(&cache).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let first = run();
    assert!(first.iter().any(|name| name.to_string_lossy().starts_with("model-")));
    assert_eq!(run(), first);
}

/// Named from where one stands it holds as many models as any other: the second one is compiled with what is kept of the
/// first.
#[test]
fn a_cache_may_be_named_from_where_one_stands() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quick.toml");
    for samples in ["clock.samples_per_chip=4", "clock.samples_per_chip=2"] {
        let words = ["cosim", scene, "--set", samples, "--clocks", "5000", "--cache", "kept"];
        let done = Command::new(env!("CARGO_BIN_EXE_goldtof"))
            .args(words)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(done.status.code(), Some(0), "{done:?}");
    }
}

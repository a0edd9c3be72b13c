//! `goldtof grade`: a stimulus that leaves an input alone scores less, and says so.

use std::fs;

use serde_json::Value;

use crate::hdl_support::{goldtof, goldtof_json};

/// Grades a stimulus of the quick scene: exit status and JSON.
fn grade(arguments: &[&str]) -> (Option<i32>, Value) {
    let all = ["grade", "scenes/quick.toml", "--json", "--quiet"];
    goldtof_json(&[&all[..], &["--mutants", "0", "--at-least", "99%"], arguments].concat())
}

fn number(faults: &Value, name: &str) -> u64 {
    faults[name].as_u64().unwrap_or_else(|| panic!("{name}: {faults}"))
}

/// Whether a net stuck at a value is among the survivors, with this verdict.
fn survives(faults: &Value, net: &str, change: &str, verdict: &str) -> bool {
    let survivors = faults["survivors"].as_array().unwrap();
    survivors.iter().any(|found| {
        found["net"] == net && found["change"] == change && found["verdict"] == verdict
    })
}

#[test]
fn photons_never_stall_and_so_stay_below_a_threshold_that_hostile_inputs_reach() {
    let (status, hostile) = grade(&["--stimulus", "hostile"]);
    assert_eq!(status, Some(0), "{hostile}");
    let (status, photons) = grade(&["--stimulus", "photons", "--clocks", "40000"]);
    assert_eq!(status, Some(4), "{photons}");
    for found in [&hostile, &photons] {
        let faults = &found["faults"];
        let parts = ["caught", "not_caught", "undecided", "proven_equivalent"];
        let sum: u64 = parts.map(|part| number(faults, part)).iter().sum();
        assert_eq!(sum, number(faults, "total"), "{faults}");
        // Every fault is in the list, and the score follows from it.
        let list = faults["list"].as_array().expect("a list");
        for part in parts {
            let here = list.iter().filter(|judged| judged["verdict"] == part);
            assert_eq!(here.count() as u64, number(faults, part), "{part}");
        }
        for judged in list {
            let given = ["clock", "proof", "needs"].map(|key| !judged[key].is_null());
            let verdict = judged["verdict"].as_str().expect("a verdict");
            let known = [verdict == "caught", verdict == "proven_equivalent"];
            assert_eq!(given, [known[0], known[1], !known[0] && !known[1]], "{judged}");
        }
        let last = list.iter().filter_map(|judged| judged["clock"].as_u64()).max();
        assert_eq!(last, faults["last_caught_clock"].as_u64());
    }
    // A receiver that is always ready tells nothing of one that is not: its wire may be
    // stuck, and hostile inputs are named that show it.
    let (all, some) = (&hostile["faults"], &photons["faults"]);
    assert!(survives(some, "m_axis_tready[0]", "stuck at 1", "not_caught"));
    assert!(!survives(all, "m_axis_tready[0]", "stuck at 1", "not_caught"));
    assert!(number(all, "caught") > number(some, "caught"));
    assert!(number(all, "caught") * 1000 >= 998 * number(all, "total"), "{all}");
}

/// `run --grade` tells of the Verilog that it has just compared what `grade` tells.
#[test]
fn a_run_with_a_grade_has_it_in_its_document_and_its_report() {
    let (status, alone) = grade(&[]);
    assert_eq!(status, Some(0));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = |scene: &str| {
        let out = folder.path().join(scene);
        let out = out.to_str().expect("a path of text");
        goldtof(&["run", scene, "--grade", "--json", "--quiet", "--out", out])
    };
    let output = run("scenes/quick.toml");
    assert!(output.status.success(), "{output:?}");
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(document["grade"]["faults"], alone["faults"]);
    let report = fs::read_to_string(folder.path().join("scenes/quick.toml/report.html"));
    let report = report.expect("there is a report");
    let section = report.split("How strong the check is").nth(1);
    let section = section.expect("the report has the section");
    for key in ["total", "caught"] {
        let number = alone["faults"][key].as_u64().expect("a number");
        assert!(section.contains(&format!(">{number}</td>")), "{key}");
    }

    // No large histogram is graded, and that is said before anything is done.
    let output = run("scenes/histogram.toml");
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("98256 bits, and at most 2048 are graded"), "{told}");
    assert!(!folder.path().join("scenes/histogram.toml").exists());
}

/// A histogram is graded, but for the bits that its memory holds.
#[test]
fn a_small_histogram_is_graded_with_its_memory() {
    let scene = "tests/scenes/histogram-one-memory.toml";
    let all = ["grade", scene, "--json", "--quiet", "--mutants", "20"];
    let (status, grade) =
        goldtof_json(&[&all[..], &["--proof-time", "1", "--proof-budget", "4"]].concat());
    assert_eq!(status, Some(0), "{grade}");
    let faults = &grade["faults"];
    assert!(number(faults, "caught") * 100 >= 99 * number(faults, "total"), "{}", faults["caught"]);
    let names = faults["list"].as_array().expect("a list");
    assert!(names.iter().all(|found| !found["net"].as_str().unwrap_or("words").contains("words")));
    assert!(number(faults, "total") > 500);
    assert_eq!(number(&grade["mutants"], "total"), 20);
}

/// Shards of a grade, joined, are the grade: each fault and mutant once, in their order.
#[test]
fn shards_of_a_grade_are_joined_to_the_grade_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let goldtof = |arguments: &[&str]| {
        let (status, mut json) = goldtof_json(&[arguments, &["--json", "--quiet"]].concat());
        json.as_object_mut().unwrap().remove("command");
        (status, json)
    };
    // What these clocks leave open is equivalent, which takes a moment, or nothing that
    // is decided in 20 s; `--proof-time` is far from both.
    let arguments = [
        &["grade", "scenes/quick.toml", "--clocks", "88000"][..],
        &["--mutants", "2", "--at-least", "99.99%"],
        &["--proof-time", "3", "--proof-budget", "60"],
    ]
    .concat();
    let whole = goldtof(&arguments);
    assert_eq!(whole.0, Some(4), "{}", whole.1);
    assert_eq!(whole.1["mutants"]["total"], 2);
    assert!(!whole.1["faults"]["survivors"].as_array().unwrap().is_empty());
    // The last has no mutant.
    for shard in ["1/3", "2/3", "3/3"] {
        let part = goldtof(&[&arguments[..], &["--shard", shard, "--out", out]].concat());
        assert_eq!(part.0, Some(0), "{}", part.1);
    }
    assert_eq!(goldtof(&["merge", out]), whole);
}

//! `goldtof stress` as continuous integration runs it.

use std::process::{Command, Output};

use serde_json::Value;

fn stress(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_goldtof")).arg("stress").args(arguments).output().unwrap()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn every_quick_case_holds() {
    let output = stress(&["--quick", "--json"]);
    let report = json(&output);
    let cases = report["cases"].as_array().unwrap();
    let failing: Vec<&Value> = cases.iter().filter(|case| case["holds"] != true).collect();
    assert!(failing.is_empty(), "{failing:#?}");
    assert_eq!(output.status.code(), Some(0));
    assert!(cases.len() >= 50, "{} cases", cases.len());
    for case in cases {
        assert!(case["measured"].is_f64() && case["bound"].is_object(), "{case}");
        assert!(!case["why"].as_str().unwrap().is_empty());
    }
}

#[test]
fn one_case_can_be_chosen_and_a_wrong_name_is_told_the_nearest() {
    let output = stress(&["--case", "no-light-at-all", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let report = json(&output);
    assert_eq!(report["cases"].as_array().unwrap().len(), 1);
    assert_eq!(report["cases"][0]["name"], "no-light-at-all");
    assert_eq!(report["seed"], 1);

    let output = stress(&["--case", "no-light-at-al"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("did you mean \"no-light-at-all\"?"), "{message}");
}

#[test]
fn the_seed_is_the_command_lines() {
    let measured = |seed| {
        json(&stress(&["--case", "detection-probability-1", "--json", "--seed", seed]))["cases"][0]
            ["measured"]
            .clone()
    };
    assert_eq!(measured("5"), measured("5"));
    assert_ne!(measured("5"), measured("6"));
}

#[test]
fn the_list_names_more_cases_than_the_quick_ones() {
    let names = |arguments: &[&str]| json(&stress(arguments))["cases"].as_array().unwrap().len();
    let (all, quick) = (names(&["--list", "--json"]), names(&["--list", "--quick", "--json"]));
    assert!(quick < all, "{quick} of {all}");
}

#[test]
fn a_missing_tool_is_status_3_and_no_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args(["stress", "--case", "counters-at-saturation"])
        .env("PATH", folder.path())
        .env("GOLDTOF_CACHE_DIR", folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("Verilator"), "{message}");
}

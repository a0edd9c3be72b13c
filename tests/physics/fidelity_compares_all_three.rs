//! `goldtof fidelity`: bias, scatter and missed peaks of every tier, and a target error
//! that the budget cannot resolve.

use std::process::{Command, Output};

use serde_json::Value;

/// A short code at so little light that some 10 % of the scans miss the peak.
fn dim(folder: &std::path::Path) -> String {
    let text = std::fs::read_to_string("scenes/quick.toml").unwrap();
    let dim: String = text
        .lines()
        .map(|line| match line.split('=').next().unwrap_or("").trim() {
            "mean_power" => "mean_power = \"0.5 pW\"\n".to_owned(),
            "integration" => "integration = \"26 us\"\n".to_owned(),
            _ => format!("{line}\n"),
        })
        .collect();
    let path = folder.join("dim.toml");
    std::fs::write(&path, dim).unwrap();
    path.to_str().unwrap().to_owned()
}

fn fidelity(scene: &str, more: &[&str]) -> (Output, Value) {
    let output = Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args(["fidelity", scene, "--json"])
        .args(more)
        .output()
        .unwrap();
    let report = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    (output, report)
}

#[test]
fn a_target_that_the_budget_cannot_resolve_is_refused_with_the_one_that_would() {
    let folder = tempfile::tempdir().unwrap();
    let scene = dim(folder.path());
    let (output, report) = fidelity(&scene, &["--budget-s", "1", "--target-error", "0.1%"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--budget-s"));
    assert!(report["recommended"].is_null());
    let refusal = &report["refusal"];
    assert_eq!(refusal["target_error"], 0.001);
    // The bias alone needs (3 x 1.96 / 0.001)^2 = 34.6 million estimates.
    assert!(refusal["needed_scans"].as_f64().unwrap() > 3.4e7, "{refusal}");
    assert!(refusal["needed_budget_s"].as_f64().unwrap() > 1_000.0, "{refusal}");

    // Where no error is asked for, the least that this budget resolves is, and what 5 % would take is told.
    let (output, own) = fidelity("scenes/quick.toml", &["--budget-s", "1"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(own["refusal"]["target_error"], 0.05);
    let resolved = own["refusal"]["resolved_error"].as_f64().unwrap();
    assert!(
        resolved > 0.05 && own["recommended"]["shown_error"].as_f64().unwrap() <= resolved + 0.01
    );

    // Every tier with its share of missed peaks, and an interval that holds it.
    for tier in report["tiers"].as_array().unwrap() {
        let missed = tier["missed_fraction"].as_f64().unwrap();
        let error = tier["missed_fraction_error"].as_f64().unwrap();
        let [low, high] = [0, 1].map(|i| tier["missed_fraction_error_ci95"][i].as_f64().unwrap());
        assert!((0.0..=1.0).contains(&missed) && low <= error && error <= high, "{tier}");
        // Only the reference holds, by what it is.
        let is_reference = tier["fidelity"] == "sampled";
        assert_eq!(tier["verdict"] == "holds", is_reference, "{tier}");
        // Wide as they are, they should hold the truth: no tier is that wrong.
        assert!(low - 0.15 < 0.0 && high + 0.15 > 0.0, "{tier}");
    }
}

#[test]
fn every_tier_of_a_histogram_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let scene = dim(folder.path());
    let histogram = ["--set", "hardware.architecture=histogram"];
    let (_, report) = fidelity(&scene, &[&histogram[..], &["--budget-s", "1"]].concat());
    let tiers = report["tiers"].as_array().unwrap();
    for name in ["expected", "counts", "events", "sampled", "rtl"] {
        let is_there = tiers.iter().any(|tier| tier["fidelity"] == name);
        assert!(is_there, "{name}: {report:#}");
    }
    let outside: Vec<_> = tiers
        .iter()
        .filter(|tier| {
            let [low, high] = [0, 1].map(|i| tier["std_relative_error_ci95"][i].as_f64().unwrap());
            low - 0.15 >= 0.0 || high + 0.15 <= 0.0
        })
        .collect();
    // Of a dozen intervals of 95 % of few scans, some of the same scans in two tiers, one or another is outside.
    let is_of_few = |tier: &&Value| tier["repetitions"].as_u64().is_some_and(|scans| scans < 100);
    assert!(outside.len() <= 2 && outside.iter().all(is_of_few), "{outside:#?}");
}

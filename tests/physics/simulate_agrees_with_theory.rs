//! `goldtof simulate`: bias and scatter of many scans, tier by tier, against the
//! exact mean response, and the tiers against each other.

use std::process::Command;

use serde_json::Value;

/// The article's sensor, scanned only round the peak.
fn scene(folder: &std::path::Path) -> String {
    let text = std::fs::read_to_string("scenes/paper-single.toml").unwrap();
    let windowed: String = text
        .lines()
        .map(|line| {
            if line.starts_with("steps =") {
                "steps = { around = \"3.5 m\", halfwidth = 16 }\n".to_owned()
            } else {
                format!("{line}\n")
            }
        })
        .collect();
    let path = folder.join("windowed.toml");
    std::fs::write(&path, windowed).unwrap();
    path.to_str().unwrap().to_owned()
}

fn simulate(scene: &str, more: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args(["simulate", scene, "--json"])
        .args(more)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} in {value}"))
}

#[test]
fn bias_and_scatter_of_the_sampled_tier_are_those_of_the_exact_mean_response() {
    let folder = tempfile::tempdir().unwrap();
    let report = simulate(&scene(folder.path()), &["--repeat", "1500", "--fidelity", "sampled"]);
    let estimate = &report["estimates"][0];
    let bias = number(estimate, "bias_m") - number(estimate, "expected_bias_m");
    assert!(bias.abs() < 4.0 * number(estimate, "bias_std_error_m"), "{estimate}");
    let std = number(estimate, "std_m") - number(estimate, "expected_std_m");
    assert!(std.abs() < 4.0 * number(estimate, "std_std_error_m"), "{estimate}");
    assert_eq!(number(estimate, "correct_coarse_fraction"), 1.0);
    assert_eq!(number(estimate, "missed_scans"), 0.0);
    let mean = number(estimate, "mean_distance_m") - number(estimate, "bias_m");
    assert!((mean - 3.2).abs() < 1e-9);
}

#[test]
fn the_verilog_gives_the_very_numbers_of_the_sampled_tier() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let of = |tier| {
        let more = ["--repeat", "12", "--seed", "5", "--fidelity", tier];
        let estimate = simulate(&scene, &more)["estimates"][0].clone();
        (number(&estimate, "bias_m"), number(&estimate, "std_m"))
    };
    assert_eq!(of("rtl"), of("sampled"));
}

#[test]
fn events_and_sampled_tiers_differ_by_no_more_than_chance() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let of = |tier, seed| {
        let more = ["--repeat", "1500", "--seed", seed, "--fidelity", tier];
        let estimate = simulate(&scene, &more)["estimates"][0].clone();
        let value = |key| number(&estimate, key);
        (
            [value("bias_m"), value("std_m")],
            [value("bias_std_error_m"), value("std_std_error_m")],
            value("detected_rate_cps"),
        )
    };
    let (events, events_error, events_rate) = of("events", "11");
    let (sampled, sampled_error, sampled_rate) = of("sampled", "12");
    for i in 0..2 {
        let sigma = events_error[i].hypot(sampled_error[i]);
        assert!((events[i] - sampled[i]).abs() < 4.0 * sigma, "{events:?} {sampled:?}");
    }
    // 27 million detections each: a relative standard error of 2e-4; merged
    // pulses cost the sampled tier some 1e-5.
    assert!((events_rate / sampled_rate - 1.0).abs() < 1.5e-3);
}

#[test]
fn one_scan_has_no_standard_deviation() {
    let folder = tempfile::tempdir().unwrap();
    let report = simulate(&scene(folder.path()), &["--repeat", "1"]);
    assert_eq!(report["estimates"][0]["std_m"], Value::Null);
    assert!(report["estimates"][0]["bias_m"].is_number());
}

//! The main job on the article's own sensor: the whole scan, 214.5 million
//! clocks in lock-step, and a distance that theory expects.

use std::process::Command;

use serde_json::Value;

#[test]
fn the_whole_scan_matches_and_the_estimate_is_as_far_off_as_theory_says() {
    let out = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args([
            "run",
            "scenes/paper-single.toml",
            "--json",
            "--quiet",
            "--out",
        ])
        .arg(out.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["cosim"]["verdict"], "match");
    assert_eq!(report["cosim"]["phase_steps"], 16_376);
    // 16,376 steps of 13,100 chips, and the clocks round them.
    let clocks = report["cosim"]["clocks"].as_u64().unwrap();
    assert!((214_525_600..214_525_700).contains(&clocks), "{clocks}");

    let estimate = &report["estimates"][0];
    let value = |key: &str| estimate[key].as_f64().unwrap();
    // Dead-time walk: light comes early when the dead time hides the rest of a
    // bright chip, so the bias is negative, and of the order of
    // rate x dead time x chip, here some centimetres.
    assert!(
        (-0.05..-0.005).contains(&value("expected_bias_m")),
        "{estimate}"
    );
    let deviation = (value("error_m") - value("expected_bias_m")) / value("expected_std_m");
    assert!(deviation.abs() < 5.0, "{estimate}");
    assert!((value("distance_m") - 3.2 - value("error_m")).abs() < 1e-9);
}

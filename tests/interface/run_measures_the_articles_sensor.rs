//! The main job on the article's own sensor: the whole scan, 214.5 million clocks in
//! lock-step, and a distance that theory expects; all as README prints it.

use std::fs;

use crate::program::command;

/// The output of `scripts/run` in README.
fn printed_in_readme() -> String {
    let readme = fs::read_to_string("README.md").unwrap();
    let (_, behind) = readme.split_once("`scripts/run` ends with").unwrap();
    let (_, block) = behind.split_once("```text\n").unwrap();
    block.split_once("```").unwrap().0.to_owned()
}

#[test]
fn the_whole_scan_matches_and_the_estimates_are_as_far_off_as_theory_says() {
    let folder = tempfile::tempdir().unwrap();
    // As `scripts/run` does it.
    let output = command(&["run"])
        .env_remove("VERILATOR")
        .arg(fs::canonicalize("scenes/paper-single.toml").unwrap())
        .args(["--estimator", "model", "--out", "out/paper-single"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let text = String::from_utf8(output.stdout).unwrap();
    // How much went in lanes depends on the machine and its tools.
    let without_engines = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| !line.starts_with("clocked: "));
        lines.map(str::to_owned).collect()
    };
    assert_eq!(without_engines(&text), without_engines(&printed_in_readme()));
    assert!(text.contains("\nclocked: 214525612 clocks of photons"), "{text}");
    assert!(folder.path().join("out/paper-single/report.html").is_file());

    // 16,376 steps of 13,100 chips, and the clocks round them.
    let first = text.lines().next().unwrap();
    let numbers = first.split(|c: char| !c.is_ascii_digit());
    let numbers: Vec<u64> = numbers.filter_map(|n| n.parse().ok()).collect();
    let [clocks, 16_376, 13_100] = numbers[..] else {
        panic!("{first}");
    };
    assert!((214_525_600..214_525_700).contains(&clocks), "{clocks}");
    let row = |name: &str| -> Vec<f64> {
        let row = text.lines().find_map(|line| line.trim().strip_prefix(name));
        let words = row.unwrap().split_whitespace();
        words.filter_map(|word| word.parse().ok()).collect()
    };
    for (name, least_bias, most_bias) in [
        // Range walk: light comes early when the dead time hides the rest of a bright
        // chip, so the bias is negative, and of the order of rate x dead time x chip,
        // here some centimetres.
        ("phase (article)", -50.0, -5.0),
        // The fit knows the dead time.
        ("model fit", -0.01, 0.01),
    ] {
        let [distance_m, error_mm, bias_mm, std_mm, in_std] = row(name)[..] else {
            panic!("{text}");
        };
        assert!((least_bias..=most_bias).contains(&bias_mm), "{name}");
        assert!(((distance_m - 3.2) * 1e3 - error_mm).abs() < 0.1, "{name}");
        assert!((error_mm - bias_mm).abs() < 5.0 * std_mm, "{name}");
        assert!(((error_mm - bias_mm) / std_mm - in_std).abs() < 0.01, "{name}");
    }
}

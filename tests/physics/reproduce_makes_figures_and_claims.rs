//! `goldtof reproduce` as a script sees it, one quick figure at a time.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn reproduce(figure: &str, out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args(["reproduce", "--json", "--quiet", "--figure", figure, "--out"])
        .arg(out)
        .args(more)
        .output()
        .unwrap()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Checks that the JSON names the figure's files, and that they are there.
fn assert_files(report: &Value, out: &Path, number: &Value) {
    let figure = &report["figures"][0];
    assert_eq!(&figure["number"], number);
    let files = figure["files"].as_array().unwrap();
    assert_eq!(files.len(), 2);
    for (file, start) in files.iter().zip(["<svg", "series,"]) {
        let text = fs::read_to_string(out.join(file.as_str().unwrap())).unwrap();
        assert!(text.starts_with(start), "{file}");
    }
}

fn csv(report: &Value, out: &Path) -> String {
    let file = report["figures"][0]["files"][1].as_str().unwrap();
    fs::read_to_string(out.join(file)).unwrap()
}

#[test]
fn a_figure_comes_with_its_data_and_the_claim_that_it_decides() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/figures");
    let output = reproduce("5", &out, &["--repeat", "10"]);
    let report = json(&output);
    assert_files(&report, &out, &5.into());

    let claims = report["claims"].as_array().unwrap();
    assert_eq!(claims.len(), 1);
    let claim = &claims[0];
    assert_eq!(claim["id"], "C1");
    for key in ["article", "criterion", "unit", "remark"] {
        assert!(!claim[key].as_str().unwrap().is_empty(), "{key}");
    }
    // The triangle of the square wave is twice as high: 3.01 dB for the same
    // noise. 100 scans for each of some 10 powers leave an error of 0.15 dB, and the
    // noise differs by up to a decibel at high light.
    let measured = claim["measured"].as_f64().unwrap();
    assert!((2.0..4.0).contains(&measured), "{measured}");
    let [low, high] = [0, 1].map(|end| claim["measured_ci95"][end].as_f64().unwrap());
    assert!(low < measured && measured < high);
    // The verdict is that of the whole interval, and nothing but "holds" is success.
    let inside = |db: f64| (2.94..=3.54).contains(&db);
    let verdict = match (inside(low), inside(high)) {
        (true, true) => "holds",
        (false, false) if high < 2.94 || low > 3.54 => "does_not_hold",
        _ => "undecided",
    };
    assert_eq!(claim["verdict"], verdict);
    assert_eq!(claim["holds"], verdict == "holds");
    assert_eq!(output.status.code(), Some(i32::from(verdict != "holds")));

    // Targets all over a phase step, up to where the detector has little left to give.
    let data = csv(&report, &out);
    let rows: Vec<Vec<&str>> = data.lines().skip(1).map(|l| l.split(',').collect()).collect();
    for position in ["0", "0.25", "0.5", "0.75"] {
        let powers = rows.iter().filter(|row| row[0] == "Gold code" && row[2] == position);
        assert!(powers.count() >= 8, "{position}");
    }
    assert!(rows.iter().any(|row| row[1].parse::<f64>().unwrap() > 205.0));
}

#[test]
fn the_seed_decides_the_data_and_nothing_else_does() {
    let folder = tempfile::tempdir().unwrap();
    let data = |seed: &str, name: &str| {
        let out = folder.path().join(name);
        let output = reproduce("7", &out, &["--repeat", "3", "--seed", seed]);
        assert_eq!(output.status.code(), Some(0));
        csv(&json(&output), &out)
    };
    assert_eq!(data("1", "a"), data("1", "b"));
    assert_ne!(data("1", "c"), data("2", "d"));
}

#[test]
fn errors_that_the_article_leaves_out_are_figures_without_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let output = reproduce("circular", folder.path(), &[]);
    assert_eq!(output.status.code(), Some(0));
    let report = json(&output);
    assert_files(&report, folder.path(), &Value::Null);
    assert_eq!(report["claims"], serde_json::json!([]));

    // One sample per chip: at a third of a chip the nearest sample is a third of
    // 8 ns, or 0.3997 m, early.
    let text = csv(&report, folder.path());
    let third = text
        .lines()
        .filter(|line| line.starts_with("phase ζ = 0,"))
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>())
        .find(|row| (row[1].parse::<f64>().unwrap() - 1.0 / 3.0).abs() < 1e-9)
        .unwrap();
    let error_m: f64 = third[2].parse().unwrap();
    let expected_m = -8e-9 / 3.0 * 299_792_458.0 / 2.0;
    assert!((error_m - expected_m).abs() < 1e-6, "{error_m}");
}

#[test]
fn figures_that_the_article_does_not_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for figure in ["4", "12", "none"] {
        let output = reproduce(figure, folder.path(), &[]);
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(message.contains("possible values: 3, 5, 6"), "{message}");
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let output = reproduce("circular", &file.join("figures"), &[]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("file/figures: cannot make the folder"), "{message}");
}

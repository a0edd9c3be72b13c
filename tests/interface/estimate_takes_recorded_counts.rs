//! `goldtof estimate` and `simulate --expected` as a user has them.

use goldtof::scene::DetectorIndex;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;

use crate::program::{QUICK, command, goldtof, json, said};

fn run(folder: &Path, more: &[&str]) -> (String, Value) {
    let out = folder.to_str().unwrap();
    let report = json(&[&["run", QUICK, "--json", "--out", out], more].concat());
    let counts = folder.join("counts.csv").to_str().unwrap().to_owned();
    (counts, report)
}

#[test]
fn the_counts_of_a_run_give_the_distance_that_the_run_gave() {
    let folder = tempfile::tempdir().unwrap();
    let (counts, report) = run(folder.path(), &["--estimator", "model"]);
    let out = folder.path().join("residuals");
    let found = json(&[
        "estimate",
        QUICK,
        &counts,
        "--estimator",
        "model",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ]);
    let found = &found["assessments"][0];
    assert_eq!(found["estimate"]["distance_m"], report["estimates"][0]["distance_m"]);
    // Right counts of a right scene.
    let p = found["p_value"].as_f64().unwrap();
    assert!(p > 1e-4 && p < 1.0 - 1e-4, "{p}");
    assert_eq!(found["degrees_of_freedom"], 2 * 248 - 1);
    assert_eq!(found["diagnosis"]["causes"], Value::Array(Vec::new()));
    let csv = fs::read_to_string(out.join("residuals-0.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 248);
    let plot = fs::read_to_string(out.join("residuals-0.svg")).unwrap();
    assert!(plot.contains("</svg>") && plot.contains("standard deviations"));
    // In words, and with another distance in the scene.
    let output = goldtof(&["estimate", QUICK, &counts, "--set", "path.distance=3.9 m"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("earlier than the scene's"), "{text}");
}

#[test]
fn wrong_files_are_refused_with_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let (counts, _) = run(folder.path(), &[]);
    let right = fs::read_to_string(&counts).unwrap();
    let shuffled = folder.path().join("x.csv");
    let of = |text: &str, scene: &str| {
        fs::write(&shuffled, text).unwrap();
        let output = goldtof(&["estimate", scene, shuffled.to_str().unwrap()]);
        (output.status.code(), said(&output))
    };
    let windows = right.replace('\n', "\r\n");
    assert_eq!(of(&format!("\u{feff}{windows}"), QUICK).0, Some(0));
    let cut: String = right.lines().take(100).map(|line| format!("{line}\n")).collect();
    let (status, told) = of(&cut, QUICK);
    assert_eq!(status, Some(2));
    assert!(told.contains("x.csv:100: ") && told.contains("149 of the scan's 248"), "{told}");
    let (status, told) = of(&right, "scenes/paper-single.toml");
    assert_eq!(status, Some(2));
    assert!(told.contains("the scene that the counts are of"), "{told}");
    let (status, told) = of(&right.replace(",count,", ",counts,"), QUICK);
    assert_eq!(status, Some(2));
    assert!(told.contains("x.csv:1: no column is called \"counts\""), "{told}");
    // What a spreadsheet of a country with decimal commas makes of it, and how it was understood.
    let semicolons = right.replace(',', ";").replace('.', ",").replace('\n', "\r\n");
    fs::write(&shuffled, format!("sep=;\r\n{semicolons}")).unwrap();
    let output = goldtof(&["estimate", QUICK, shuffled.to_str().unwrap(), "--explain"]);
    let told = said(&output);
    assert_eq!(output.status.code(), Some(0), "{told}");
    for line in ["delimiter     semicolon, named on line 1", "248, phase steps 0 to 247"] {
        assert!(told.contains(line), "{told}");
    }
    let found = json(&["estimate", QUICK, shuffled.to_str().unwrap(), "--json"]);
    assert_eq!(found["file"]["dialect"]["decimal_sign"], ",");
    assert_eq!(found["file"]["heading_line"], 2);
    // A cause that cannot be tested is named once, however often it was tried: causes of too few hits, the
    // recharge beside afterpulses where another cause is found.
    let settings = [("detector.dead_time=30 ns", 1), ("detector.background_rate=3 Mcps", 1)];
    for (setting, number) in settings {
        let found = json(&["estimate", QUICK, &counts, "--set", setting, "--json"]);
        let left_out = &found["assessments"][0]["diagnosis"]["not_tested"];
        assert_eq!(left_out.as_array().map(Vec::len), Some(number), "{setting}: {left_out}");
    }
    let missing = goldtof(&["estimate", QUICK, "no-such.csv"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(said(&missing).contains("no-such.csv: cannot read the counts"));
    fs::write(&shuffled, [0xff, 0xfe, 0, 1]).unwrap();
    let binary = goldtof(&["estimate", QUICK, shuffled.to_str().unwrap()]);
    assert_eq!(binary.status.code(), Some(2), "{}", said(&binary));
}

/// The file's means and deviations are those of a thousand simulated scans.
#[test]
fn expected_counts_are_written_and_counts_scatter_round_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("expected.csv");
    let path = file.to_str().unwrap();
    json(&[
        "simulate",
        QUICK,
        "--json",
        "--repeat",
        "2",
        "--fidelity",
        "sampled",
        "--expected",
        path,
    ]);
    let text = fs::read_to_string(&file).unwrap();
    let mut lines = text.lines();
    let heading: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(heading[4..8], ["count_mean", "count_std", "total_count_mean", "total_count_std"]);
    let expected: Vec<Vec<f64>> = lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            fields[4..8].iter().map(|field| field.parse().unwrap()).collect()
        })
        .collect();
    assert_eq!(expected.len(), 248);
    let scene = goldtof::scene::load(Path::new(QUICK)).unwrap();
    let sensor = goldtof::sensor::Sensor::new(&scene);
    let tier = goldtof::simulate::Tier::Sampled;
    let mut sums = vec![[0.0; 4]; 248];
    let scans = 400;
    goldtof::simulate::scans::scans(&sensor, DetectorIndex(0), tier, 2, scans, |counts| {
        for ((sum, count), expected) in sums.iter_mut().zip(counts).zip(&expected) {
            let signed = (count.signed as f64 - expected[0]) / expected[1];
            let total = (count.total as f64 - expected[2]) / expected[3];
            for (sum, value) in sum.iter_mut().zip([signed, signed * signed, total, total * total])
            {
                *sum += value;
            }
        }
    })
    .unwrap();
    // All steps together: 99,200 numbers of mean 0 and variance 1.
    let n = 248.0 * scans as f64;
    for (column, expected, std) in [(0, 0.0, 1.0), (1, 1.0, 2.0), (2, 0.0, 1.0), (3, 1.0, 2.0)] {
        let mean = sums.iter().map(|sum| sum[column]).sum::<f64>() / n;
        let error = (std / n).sqrt();
        assert!((mean - expected).abs() < 4.5 * error, "{column}: {mean} +- {error}");
    }
}

#[test]
fn a_key_is_set_on_the_command_line_and_named_in_what_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let set = ["--set", "source.code.degree=6", "--set", "scan.integration=1 us"];
    let emission = json(&[&["emit", QUICK, "--json", "--out", out][..], &set].concat());
    let command = emission["command"].as_str().unwrap();
    assert_eq!(
        command,
        "goldtof emit quick.toml --set source.code.degree=6 --set 'scan.integration=1 us'"
    );
    let top = fs::read_to_string(folder.path().join("sensor_top.v")).unwrap();
    assert!(
        top.contains("--set source.code.degree=6 --set 'scan.integration=1 us'"),
        "{}",
        &top[..400]
    );
    // 63 chips, 8 samples each.
    assert_eq!(emission["parameters"]["phase_steps"], 504, "{}", emission["parameters"]);
    for command in ["plan", "simulate", "cosim", "fidelity", "emit", "run"] {
        let mut arguments = vec![command, QUICK, "--set", "path.distance=5"];
        if ["emit", "run"].contains(&command) {
            arguments.extend(["--out", out]);
        }
        let wrong = goldtof(&arguments);
        assert_eq!(wrong.status.code(), Some(2), "{command}");
        let told = "error: --set path.distance=5: path.distance: 5 has no unit";
        assert!(said(&wrong).contains(told), "{command}: {}", said(&wrong));
    }
}

/// The bins that the Verilog sent give what `run` gave, and agree with their scene.
#[test]
fn the_bins_of_a_run_give_the_distance_that_the_run_gave() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let with = |command: &str, more: &[&str]| {
        let all = [command, QUICK];
        let mut all: Vec<String> = all.iter().chain(more).map(|&s| s.to_owned()).collect();
        all.extend(["--set", "hardware.architecture=histogram"].map(str::to_owned));
        all
    };
    let of = |command: &str, more: &[&str]| {
        let all = with(command, more);
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        (goldtof(&all), all.join(" "))
    };
    let document = |command: &str, more: &[&str]| -> Value {
        let (output, all) = of(command, &[more, &["--json", "--estimator", "model"]].concat());
        assert_eq!(output.status.code(), Some(0), "{all}: {}", said(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let report = document("run", &["--out", &file("")]);
    let bins = file("bins.csv");
    let found = document("estimate", &[&bins, "--out", &file("residuals")]);
    let found = &found["assessments"][0];
    assert_eq!(found["estimate"]["distance_m"], report["estimates"][0]["distance_m"]);
    let p = found["p_value"].as_f64().unwrap();
    assert!(p > 1e-4 && p < 1.0 - 1e-4, "{p}");
    assert_eq!(found["diagnosis"]["causes"], Value::Array(Vec::new()));
    assert_eq!(found["phase_steps"], Value::Array(Vec::new()));
    assert_eq!(found["bins"].as_array().unwrap().len(), 248);
    let csv = fs::read_to_string(file("residuals/residuals-0.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 248);
    let plot = fs::read_to_string(file("residuals/residuals-0.svg")).unwrap();
    assert!(plot.contains("recorded bins and residuals"));
    // The counts of its phase steps are all of the same photons.
    let (output, _) = of("estimate", &[&file("counts.csv")]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let why = "no residuals: counts of a histogram's phase steps are of the same photons";
    assert!(text.contains(why), "{text}");
    // Its expectation has a row for each bin, which sum up to what the run counted.
    of("simulate", &["--expected", &file("expected.csv")]);
    let sum = |file: &str| -> f64 {
        let text = fs::read_to_string(file).unwrap();
        let count = |line: &str| line.split(',').nth(1).unwrap().parse::<f64>().unwrap();
        text.lines().skip(1).map(count).sum()
    };
    let (expected, counted) = (sum(&file("expected.csv")), sum(&bins));
    assert!((counted - expected).abs() < 5.0 * expected.sqrt(), "{counted}, {expected}");
    // From a pipe, which can be read but once.
    let all = with("estimate", &["/dev/stdin", "--json", "--estimator", "model"]);
    let mut child =
        command(&[]).args(all).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    pipe.write_all(&fs::read(&bins).unwrap()).unwrap();
    drop(pipe);
    let piped = child.wait_with_output().unwrap();
    let piped: Value = serde_json::from_slice(&piped.stdout).unwrap();
    assert_eq!(piped["assessments"][0]["bins"], found["bins"]);
    // Bins of a scene that keeps none.
    let output = goldtof(&["estimate", QUICK, &bins]);
    assert_eq!(output.status.code(), Some(2));
    let text = said(&output);
    assert!(text.contains("bins.csv:1: bins are of a sensor"), "{text}");
    // A run of a scene that keeps none leaves none of the last one's behind.
    let output = goldtof(&["run", QUICK, "--out", &file("")]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(folder.path().join("counts.csv").exists() && !Path::new(&bins).exists());
}

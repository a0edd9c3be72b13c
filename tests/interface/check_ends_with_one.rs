//! `--check`: exit status 1 where scans contradict what is expected of them, and 0 where they
//! bear it out. Scans that contradict it are those of another scene than they are said to be of.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sha2::Digest as _;

use crate::program::{QUICK, goldtof, json, said};

/// 0.3 m is a quarter of a chip, and ten standard deviations: found, but not where it should be.
const ELSEWHERE: &str = "path.distance=3.5 m";

fn status(arguments: &[&str]) -> (Option<i32>, String) {
    let output = goldtof(arguments);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), text + &said(&output))
}

/// The only shard of a command, and its document.
fn shard(arguments: &[&str], out: &Path) -> (PathBuf, Value) {
    let place = ["--shard", "1/1", "--json", "--out", out.to_str().unwrap()];
    json(&[arguments, &place].concat());
    let mut files = fs::read_dir(out.join("shards")).unwrap();
    let file = files.next().unwrap().unwrap().path();
    let document = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    (file, document)
}

/// Puts errors into the only path of a shard, and seals it anew as docs/clusters.md says.
fn give(file: &Path, errors_m: &[f64]) {
    let written = fs::read_to_string(file).unwrap();
    let old: Value = serde_json::from_str(&written).unwrap();
    let sealed = old["sha256"].to_string();
    let empty = written.trim_end().replacen(&sealed, "\"\"", 1);
    let begin = empty.find("\"errors_m\":[[").unwrap();
    let end = begin + empty[begin..].find("]]").unwrap();
    let given = serde_json::to_string(errors_m).unwrap();
    let other = format!("{}\"errors_m\":[{given}{}", &empty[..begin], &empty[end + 1..]);
    assert_ne!(empty, other);
    let digest: String =
        sha2::Sha256::digest(&other).iter().map(|byte| format!("{byte:02x}")).collect();
    let seal = format!(r#""sha256":"{digest}""#);
    fs::write(file, other.replacen(r#""sha256":"""#, &seal, 1)).unwrap();
}

#[test]
fn recorded_counts_of_another_distance_end_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let (done, told) = status(&["run", QUICK, "--check", "--out", out.to_str().unwrap()]);
    assert_eq!(done, Some(0), "{told}");
    let counts = out.join("counts.csv");
    let right = ["estimate", QUICK, counts.to_str().unwrap()];
    let wrong = [&right[..], &["--set", ELSEWHERE]].concat();
    for (arguments, holds) in [(&right[..], true), (&wrong[..], false)] {
        for estimator in ["fft", "model"] {
            let arguments = [arguments, &["--estimator", estimator]].concat();
            let checked = [&arguments[..], &["--check"]].concat();
            let (ended, told) = status(&checked);
            assert_eq!(ended, Some(if holds { 0 } else { 1 }), "{checked:?}: {told}");
            assert_eq!(told.contains("the expectation does not hold: bias"), !holds, "{told}");
            // Without the option the same is said, and the status stays 0.
            let document = json(&[&arguments[..], &["--json"]].concat());
            let estimate = &document["assessments"][0]["estimate"];
            assert_eq!(estimate["expectation_holds"], holds, "{arguments:?}");
        }
    }
}

/// Counts of the other sign are told as such; counts that scatter
/// more than photons do may be at the right one.
#[test]
fn recorded_counts_of_another_scene_end_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let model = ["--set", "estimate.estimator=model"];
    let made = [&["run", QUICK, "--out", out.to_str().unwrap()], &model[..]].concat();
    assert_eq!(status(&made).0, Some(0));
    let counts = fs::read_to_string(out.join("counts.csv")).unwrap();
    let altered = |change: fn(usize, i64) -> i64| {
        let mut lines = counts.lines();
        let mut text = lines.next().unwrap().to_owned() + "\n";
        for (number, line) in lines.enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            // measurement,phase_step,distance_m,count,detector,total_count
            for cell in [3, 5] {
                let count = cells[cell].parse().unwrap();
                let signed = change(number, count);
                cells[cell] = if cell == 5 { signed.abs() } else { signed }.to_string();
            }
            text += &(cells.join(",") + "\n");
        }
        text
    };
    let file = folder.path().join("altered.csv");
    let checked = ["estimate", QUICK, file.to_str().unwrap(), "--check"];
    for (change, ended, told) in [
        ((|_, count| count) as fn(usize, i64) -> i64, 0, "the counts are as the scene says"),
        (|_, count| -count, 1, "the counts have the opposite sign"),
        (|number, count| if number % 10 == 0 { 2 * count } else { count }, 1, "larger than chance"),
    ] {
        fs::write(&file, altered(change)).unwrap();
        let (found, text) = status(&[&checked[..], &model[..]].concat());
        assert_eq!(found, Some(ended), "{text}");
        assert!(text.contains(told), "{told}: {text}");
    }
}

#[test]
fn scans_of_another_distance_end_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let simulate = ["simulate", QUICK, "--repeat", "20", "--check"];
    let out = |name| folder.path().join(name);
    let (file, _) = shard(&simulate, &out("here"));
    let (_, elsewhere) = shard(&[&simulate[..], &["--set", ELSEWHERE]].concat(), &out("there"));
    let here = out("here");
    let merge = ["merge", here.to_str().unwrap()];
    let (ended, told) = status(&merge);
    assert_eq!((ended, told.contains("contradict")), (Some(0), false), "{told}");
    // Errors are of each scan's own truth: 0.3 m beside the one that is expected.
    let errors = elsewhere["results"]["simulate"]["tallies"][0]["errors_m"][0].as_array().unwrap();
    let errors_m: Vec<f64> = errors.iter().map(|error| error.as_f64().unwrap() + 0.3).collect();
    give(&file, &errors_m);
    let (ended, told) = status(&merge);
    assert_eq!(ended, Some(1), "{told}");
    assert!(told.contains("bias") && told.contains("expected"), "{told}");
    let output = goldtof(&[&merge[..], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["estimates"][0]["expectation_holds"], false);
    let remark = document["estimates"][0]["expectation_remark"].as_str().unwrap();
    assert!(remark.starts_with("bias "), "{remark}");
}

/// A point that was simulated before is read back, with what its scans said.
#[test]
fn a_sweep_with_a_contradicted_point_ends_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let over = ["--over", "path.distance=3.2 m, 3.5 m"];
    let sweep = ["sweep", QUICK, "--repeat", "20", "--check", "--out", out.to_str().unwrap()];
    let sweep = [&sweep[..], &over].concat();
    let (ended, told) = status(&sweep);
    assert_eq!(ended, Some(0), "{told}");
    let points = out.join("points.log");
    let text = fs::read_to_string(&points).unwrap();
    assert_eq!(text.matches(",true,").count(), 2, "{text}");
    let (first, rest) = text.split_once('\n').unwrap();
    let (_, point) = first.split_once(' ').unwrap();
    let point = point.replace(",true,", ",false,");
    let check: String =
        sha2::Sha256::digest(&point).iter().map(|byte| format!("{byte:02x}")).collect();
    fs::write(&points, format!("{} {point}\n{rest}", &check[..16])).unwrap();
    let (ended, told) = status(&sweep);
    assert_eq!(ended, Some(1), "{told}");
    assert!(told.contains("in 1 of 2 rows the scans contradict"), "{told}");
    let unchecked: Vec<&str> = sweep.into_iter().filter(|&word| word != "--check").collect();
    assert_eq!(status(&unchecked).0, Some(0));
}

//! `goldtof sweep`: what it writes, and that nothing but its arguments changes it.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::program::{QUICK, command, goldtof, json, said};

/// A sweep of six points into a folder.
fn sweep<'a>(out: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let fixed = [
        "sweep",
        QUICK,
        "--json",
        "--repeat",
        "20",
        "--set",
        "scan.integration=2 us",
        "--over",
        "source[0].mean_power=5 pW..20 pW x3",
        "--over",
        "path.distance=3 m, 9 m",
        "--out",
        out.to_str().unwrap(),
    ];
    [&fixed[..], more].concat()
}

fn csv(folder: &Path) -> String {
    fs::read_to_string(folder.join("sweep.csv")).unwrap()
}

#[test]
fn every_point_is_what_simulate_gives_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let report = json(&sweep(folder.path(), &[]));
    assert_eq!(
        (report["points"].as_u64(), report["points_done_before"].as_u64()),
        (Some(6), Some(0))
    );
    let text = csv(folder.path());
    let mut lines = text.lines();
    let heading = lines.next().unwrap();
    assert!(
        heading.starts_with("point,source[0].mean_power (pW),path.distance (m),detector,"),
        "{heading}"
    );
    let keys: Vec<String> =
        lines.map(|line| line.split(',').take(3).collect::<Vec<_>>().join(",")).collect();
    assert_eq!(keys, ["0,5,3", "1,5,9", "2,10,3", "3,10,9", "4,20,3", "5,20,9"]);
    let row = &report["rows"][3];
    let alone = json(&[
        "simulate",
        QUICK,
        "--json",
        "--repeat",
        "20",
        "--set",
        "scan.integration=2 us",
        "--set",
        "source.mean_power=10 pW",
        "--set",
        "path.distance=9 m",
    ]);
    for name in ["bias_m", "std_m", "expected_bias_m", "bound_m", "estimates", "detected_rate_cps"]
    {
        assert!(!row[name].is_null(), "{name}");
        assert_eq!(row[name], alone["estimates"][0][name], "{name}");
    }
    let plot = fs::read_to_string(folder.path().join("sweep.svg")).unwrap();
    assert!(plot.contains("standard deviation (mm)") && plot.contains("mean_power (pW)"));
}

#[test]
fn a_sweep_that_was_killed_goes_on_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
    // Long enough to be killed in.
    let arguments = |out| {
        let mut all = sweep(out, &[]);
        let repeat = all.iter().position(|word| *word == "20").unwrap();
        all[repeat] = "1000";
        all
    };
    json(&arguments(&whole));
    let points = |out: &Path| {
        fs::read_to_string(out.join("points.log")).map_or(0, |log| log.matches('\n').count())
    };
    let mut kills = 0;
    let began = Instant::now();
    loop {
        let before = points(&cut);
        let mut child =
            command(&arguments(&cut)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let is_done = loop {
            if points(&cut) > before && points(&cut) < 6 {
                break false;
            }
            if child.try_wait().unwrap().is_some() {
                break true;
            }
            assert!(began.elapsed() < Duration::from_secs(300), "it does not go on");
            std::thread::sleep(Duration::from_millis(1));
        };
        if is_done {
            break;
        }
        // SIGKILL: nothing can be tidied up.
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(points(&cut) > before, "a finished point is lost");
        kills += 1;
    }
    assert!(kills >= 1, "it was never cut off");
    assert_eq!(csv(&whole), csv(&cut));
    let again = json(&arguments(&cut));
    assert_eq!(again["points_done_before"], 6);
    assert_eq!(csv(&whole), csv(&cut));
}

#[test]
fn neither_threads_nor_a_point_made_alone_change_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let (all, one) = (folder.path().join("all"), folder.path().join("one"));
    json(&sweep(&all, &[]));
    let output = command(&sweep(&one, &[])).env("RAYON_NUM_THREADS", "1").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(csv(&all), csv(&one));
    // A point taken away is made again, after all others.
    let log = one.join("points.log");
    let lines = fs::read_to_string(&log).unwrap();
    fs::write(&log, lines.split_once('\n').unwrap().1).unwrap();
    let report = json(&sweep(&one, &[]));
    assert_eq!(report["points_done_before"], 5);
    assert_eq!(csv(&all), csv(&one));
}

/// As a power cut leaves them: a last line that is torn is dropped. One before it that is not
/// what was written is an error, and the tables stay as they are.
#[test]
fn a_torn_last_point_is_made_again_and_a_changed_one_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    json(&sweep(out, &[]));
    let (table, log) = (csv(out), out.join("points.log"));
    let whole = fs::read(&log).unwrap();
    for torn in [whole.len() - 1, whole.len() - 40] {
        fs::write(&log, &whole[..torn]).unwrap();
        assert_eq!(json(&sweep(out, &[]))["points_done_before"], 5);
        assert_eq!(csv(out), table);
    }
    let whole = fs::read_to_string(&log).unwrap();
    fs::write(&log, whole.replacen(",true,", ",false,", 1)).unwrap();
    let output = goldtof(&sweep(out, &[]));
    assert_eq!(output.status.code(), Some(2));
    let told = "points.log: cannot read the file: the line at byte 0 is not what was written";
    assert!(said(&output).contains(told), "{}", said(&output));
    assert_eq!(csv(out), table);
}

#[test]
fn a_folder_of_another_sweep_is_refused_with_what_differs() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("x.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    fs::write(&scene, &text).unwrap();
    let out = folder.path().join("out");
    let arguments = |seed: &'static str| {
        let (scene, out) = (scene.to_str().unwrap(), out.to_str().unwrap());
        let fixed = ["sweep", scene, "--fidelity", "expected", "--over", "path.distance=3 m, 4 m"];
        [&fixed[..], &["--out", out, "--seed", seed]]
            .concat()
            .into_iter()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let run = |seed| {
        let words = arguments(seed);
        goldtof(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    assert_eq!(run("1").status.code(), Some(0));
    let before = csv(&out);
    let other = run("2");
    assert_eq!(other.status.code(), Some(2));
    assert!(said(&other).contains("seed is 2, there 1"), "{}", said(&other));
    fs::write(&scene, text.replace("\"3.2 m\"", "\"3.3 m\"")).unwrap();
    let other = run("1");
    assert_eq!(other.status.code(), Some(2));
    assert!(said(&other).contains("the scene's text is another"), "{}", said(&other));
    assert_eq!(csv(&out), before);
}

#[test]
fn a_point_that_is_no_scene_is_told_before_the_first_is_simulated() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let path = out.to_str().unwrap();
    for (over, told) in [
        (
            "path.distance=1 m, -1 m",
            "--over path.distance=-1 m: path.distance: \"-1 m\" is outside",
        ),
        ("path.distnce=1 m, 2 m", "did you mean `distance`?"),
        ("path.distance=1 m..2 m", "write a list"),
        ("clock.samples_per_chip=1..8 +3", "4.5"),
    ] {
        let output = goldtof(&["sweep", QUICK, "--over", over, "--out", path]);
        assert_eq!(output.status.code(), Some(2), "{over}");
        assert!(said(&output).contains(told), "{over}: {}", said(&output));
    }
    let twice = ["--over", "path.distance=1 m", "--over", "path.distance=2 m"];
    let output = goldtof(&[&["sweep", QUICK, "--out", path][..], &twice].concat());
    assert!(said(&output).contains("the key is swept twice"), "{}", said(&output));
    assert!(!out.exists());
}

/// A tier that cannot do a point says so in its row; the others are there.
#[test]
fn a_point_that_cannot_be_simulated_has_the_reason_in_its_row() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let report = json(&[
        "sweep",
        QUICK,
        "--json",
        "--fidelity",
        "counts",
        "--out",
        out,
        "--over",
        "path.velocity=0 m/s, 100 m/s",
    ]);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    assert!(rows[0]["expected_std_m"].is_number(), "{}", rows[0]);
    let remark = rows[1]["remark"].as_str().unwrap();
    assert!(remark.contains("moves"), "{remark}");
    assert!(rows[1]["bias_m"].is_null());
}

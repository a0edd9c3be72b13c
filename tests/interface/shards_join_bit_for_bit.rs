//! Commands in shards, and `goldtof merge`: the same bytes as of one run, whoever was
//! killed on the way, and nothing of what does not belong together.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use goldtof::OutputFolder;
use goldtof::cosim::engine::Engine;
use goldtof::scene::{self, Setting};
use goldtof::sensor::Sensor;
use goldtof::shard::{self, JobPart, Results};
use goldtof::simulate::Tier;
use goldtof::simulate::repeat::{Simulated, Simulation};
use goldtof::simulate::scans::PreparedTier;
use goldtof::study::reproduce::{FigureId, MadeFigure, ReproduceOptions, Reproduction, reproduce};
use goldtof::study::stress::{self, StressOptions, StressReport};
use serde_json::{Value, json};
use sha2::Digest as _;

use crate::program::{self, QUICK, command, goldtof, said};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn done(arguments: &[&str]) -> Value {
    program::json(&[arguments, &["--json"]].concat())
}

/// What a refused command says.
fn refused(arguments: &[&str]) -> String {
    let output = goldtof(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    said(&output)
}

/// A document without the words that two ways to the same numbers differ in.
fn numbers(mut document: Value) -> Value {
    let fields = document.as_object_mut().unwrap();
    for name in ["command", "run_time_s", "points_done_before"] {
        fields.remove(name);
    }
    document
}

/// All shards of a command, the last first.
fn all_shards(arguments: &[&str], out: &Path, of: u64) {
    for number in (1..=of).rev() {
        let shard = format!("{number}/{of}");
        let report = done(&[arguments, &["--shard", &shard, "--out", text(out)]].concat());
        assert_eq!((&report["shard"], &report["shards"]), (&json!(number), &json!(of)));
        assert_eq!(report["done_before"], false);
    }
}

fn shard_files(out: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(out.join("shards")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

/// The scene with some keys set otherwise.
fn sensor(file: &str, settings: &[&str]) -> Sensor {
    let settings: Vec<Setting> = settings.iter().map(|text| text.parse().unwrap()).collect();
    Sensor::new(&scene::load_with(Path::new(file), &settings).unwrap())
}

/// All numbers of a simulation, as they are written.
fn written(simulation: &Simulation) -> String {
    let mut value = serde_json::to_value(simulation).unwrap();
    value.as_object_mut().unwrap().remove("run_time_s");
    value.to_string()
}

/// Simulates scans in one go, and cut into stretches at `cuts`, and expects the same.
fn assert_cut_anywhere(sensor: &Sensor, tier: Tier, repetitions: u64, cuts: &[u64]) {
    let prepared = PreparedTier::new(sensor, tier, Engine::Auto).unwrap();
    let simulated = Simulated::new(sensor, tier.scans(repetitions).seeded(7)).unwrap();
    let gather = |scans| simulated.gather(&prepared, scans, &mut |_| ()).unwrap();
    let conclude = |gathered| written(&simulated.conclude(gathered).unwrap());
    let whole = conclude(gather(0..repetitions));
    let ends = cuts.iter().copied().chain([repetitions]);
    let starts = [0].into_iter().chain(cuts.iter().copied());
    let mut joined = simulated.nothing();
    for (start, end) in starts.zip(ends) {
        joined.append(gather(start..end));
    }
    assert!(whole.contains("bias_m"), "{whole}");
    assert_eq!(conclude(joined), whole, "{tier}, cut at {cuts:?}");
}

#[test]
fn scans_are_the_same_wherever_they_are_cut() {
    // Windows of a scan, which begins anew each time.
    let window = ["scan.steps={ first = 0, count = 60 }", "scan.integration=1 us"];
    let full = ["scan.integration=1 us"];
    let model = ["estimate.estimator=model", "scan.integration=2 us"];
    for tier in [Tier::Counts, Tier::Events, Tier::Sampled] {
        for settings in [&window[..], &full, &model] {
            let sensor = sensor(QUICK, settings);
            assert_cut_anywhere(&sensor, tier, 9, &[1, 2, 2, 8]);
        }
    }
    let several = sensor(
        "scenes/dual-view.toml",
        &["scan.integration=10 us", "scan.steps={ around = \"3.2 m\", halfwidth = 30 }"],
    );
    assert_cut_anywhere(&several, Tier::Events, 5, &[3]);
}

/// Of a scan over the whole period the last pulses reach into the next scan.
#[test]
fn pulses_that_reach_into_the_next_scan_are_there_in_every_shard() {
    for width in ["90 ns", "3 us"] {
        let width = format!("detector.pulse_width={width}");
        let bright = ["scan.integration=248 ns", "source[0].mean_power=60 pW", width.as_str()];
        assert_cut_anywhere(&sensor(QUICK, &bright), Tier::Sampled, 12, &[1, 2, 5, 9, 10]);
    }
}

#[test]
fn histograms_are_the_same_wherever_they_are_cut() {
    let of_scene = |more| {
        let code = "source.code={ family = \"gold\", degree = 5 }";
        let settings = [code, "scan.integration=3 us", more];
        sensor("scenes/histogram.toml", &settings)
    };
    assert_cut_anywhere(&of_scene("path.distance=3 m"), Tier::Counts, 70, &[1, 2, 40]);
    let long_pulses = of_scene("detector.pulse_width=90 ns");
    for tier in [Tier::Events, Tier::Sampled] {
        assert_cut_anywhere(&long_pulses, tier, 70, &[1, 2, 40]);
    }
    // Read out of the Verilog, whose frames follow one another without a gap.
    let one_memory = of_scene("hardware.buffers=1");
    assert_cut_anywhere(&one_memory, Tier::Rtl, 5, &[1, 3, 3]);
}

#[test]
fn scans_through_the_verilog_are_the_same_wherever_they_are_cut() {
    let sensor = sensor(QUICK, &["scan.integration=2 us"]);
    assert_cut_anywhere(&sensor, Tier::Rtl, 4, &[1, 3]);
}

/// In light so dim that a scan has a hit or none, what the Verilog was not made to show is
/// said of all scans, and not of those of a shard.
#[test]
fn what_the_verilog_was_not_made_to_show_is_that_of_all_shards() {
    let dim = [
        "scan.steps={ first = 0, count = 2 }",
        "scan.integration=248 ns",
        "source[0].mean_power=2 pW",
    ];
    let sensor = sensor(QUICK, &dim);
    let prepared = PreparedTier::new(&sensor, Tier::Rtl, Engine::Auto).unwrap();
    let mut said = [0; 3];
    for seed in 0..24 {
        let simulated = Simulated::new(&sensor, Tier::Rtl.scans(2).seeded(seed)).unwrap();
        let gather = |scans| simulated.gather(&prepared, scans, &mut |_| ()).unwrap();
        let conclude = |gathered| simulated.conclude(gathered).unwrap();
        let [mut joined, second] = [gather(0..1), gather(1..2)];
        let alone = [&joined, &second].map(|one| conclude(one.clone()).warnings.len());
        joined.append(second);
        let [joined, whole] = [joined, gather(0..2)].map(conclude);
        assert_eq!(written(&joined), written(&whole), "seed {seed}");
        // Neither shard shows all, one of them, or both.
        let all_shown = alone.map(|warnings| warnings == 0);
        said[all_shown.iter().filter(|&&shown| shown).count()] += 1;
    }
    assert!(said.iter().all(|&seeds| seeds > 0), "{said:?}");
}

const SIMULATE: [&str; 8] = [
    "simulate",
    QUICK,
    "--repeat",
    "10",
    "--set",
    "scan.integration=2 us",
    "--seed",
    "18446744073709551615",
];

#[test]
fn shards_of_simulate_say_what_one_run_says() {
    let folder = tempfile::tempdir().unwrap();
    let whole = numbers(done(&SIMULATE));
    // One of them has all scans, and some none.
    for of in [1, 3, 13] {
        let out = folder.path().join(of.to_string());
        all_shards(&SIMULATE, &out, of);
        assert_eq!(shard_files(&out).len() as u64, of, "nothing else is left there");
        assert_eq!(numbers(done(&["merge", text(&out)])), whole, "{of} shards");
    }
    let words = |arguments: &[&str]| {
        let text = String::from_utf8(goldtof(arguments).stdout).unwrap();
        // The last line has the run time.
        text.lines().filter(|line| !line.contains(" s")).map(str::to_owned).collect::<Vec<_>>()
    };
    let out = folder.path().join("3");
    assert_eq!(words(&["merge", text(&out)]), words(&SIMULATE));
}

const SWEEP: [&str; 12] = [
    "sweep",
    QUICK,
    "--repeat",
    "20",
    "--set",
    "scan.integration=2 us",
    "--over",
    "source[0].mean_power=5 pW..20 pW x3",
    "--over",
    "path.distance=3 m, 9 m",
    "--fidelity",
    "events",
];

fn sweep_files(folder: &Path) -> [String; 2] {
    ["sweep.csv", "sweep.svg"].map(|name| fs::read_to_string(folder.join(name)).unwrap())
}

#[test]
fn shards_of_a_sweep_end_with_the_bytes_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, cut] = ["whole", "cut"].map(|name| folder.path().join(name));
    let report = numbers(done(&[&SWEEP[..], &["--out", text(&whole)]].concat()));
    all_shards(&SWEEP, &cut, 4);
    assert_eq!(shard_files(&cut).len(), 4, "nothing else is left there");
    assert_eq!(numbers(done(&["merge", text(&cut)])), report);
    assert_eq!(sweep_files(&cut), sweep_files(&whole));
}

#[test]
fn shards_that_are_missing_are_named_and_done_ones_not_done_again() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/out");
    let told = refused(&["merge", text(&out)]);
    assert!(told.contains("shards has no shards"), "{told}");
    let shard = |part| [&SIMULATE[..], &["--out", text(&out), "--shard", part]].concat();
    for part in ["2/12", "12/12", "10/12"] {
        done(&shard(part));
    }
    let told = refused(&["merge", text(&out)]);
    assert!(told.contains("has 3 of 12 shards; 1,3-9,11 missing"), "{told}");
    assert!(told.contains("--shard 1/12"), "{told}");
    let missing = goldtof(&["merge", "--missing", text(&out)]);
    assert_eq!(String::from_utf8(missing.stdout).unwrap(), "1,3-9,11\n");
    let missing = done(&["merge", "--missing", text(&out)]);
    assert_eq!(missing["shards"], 12);
    assert_eq!(missing["missing"], json!([1, 3, 4, 5, 6, 7, 8, 9, 11]));
    let file = out.join("shards/02-of-12.json");
    let before = (fs::read(&file).unwrap(), fs::metadata(&file).unwrap().modified().unwrap());
    assert_eq!(done(&shard("2/12"))["done_before"], true);
    let after = (fs::read(&file).unwrap(), fs::metadata(&file).unwrap().modified().unwrap());
    assert!(before == after);
    // Of another job it is not touched.
    let other = [&shard("2/12")[..], &["--set", "path.distance=4 m"]].concat();
    let told = refused(&other);
    assert!(told.contains("02-of-12.json is of another job: settings is "), "{told}");
    assert!(before.0 == fs::read(&file).unwrap());
    for part in ["1/12", "3/12", "4/12", "5/12", "6/12", "7/12", "8/12", "9/12", "11/12"] {
        done(&shard(part));
    }
    assert_eq!(goldtof(&["merge", "--missing", text(&out)]).stdout, b"");
    assert_eq!(numbers(done(&["merge", text(&out)])), numbers(done(&SIMULATE)));
}

/// Changes a key of a shard's file, and gives back what it was.
fn changed(file: &Path, pointer: &str, value: Value) -> String {
    let before = fs::read_to_string(file).unwrap();
    let mut shard: Value = serde_json::from_str(&before).unwrap();
    *shard.pointer_mut(pointer).expect(pointer) = value;
    fs::write(file, shard.to_string()).unwrap();
    before
}

#[test]
fn files_that_are_not_what_was_written_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_path_buf();
    all_shards(&SIMULATE, &out, 2);
    let merged = numbers(done(&["merge", text(&out)]));
    let file = out.join("shards/2-of-2.json");
    let written = fs::read_to_string(&file).unwrap();
    // As a disk leaves it that was full or lost power.
    for length in [0, 1, written.len() / 2, written.len() - 3] {
        fs::write(&file, &written[..length]).unwrap();
        let told = refused(&["merge", text(&out)]);
        assert!(told.contains("2-of-2.json: cannot be read as a shard"), "{told}");
        assert!(told.contains("do that shard again"), "{told}");
    }
    fs::write(&file, &written).unwrap();
    let errors = "/results/simulate/tallies/0";
    for (pointer, value) in [
        (format!("{errors}/errors_m/0/0"), json!(0.125)),
        (format!("{errors}/detections"), json!(3)),
        ("/job/simulate/seed".to_owned(), json!(3)),
        ("/goldtof".to_owned(), json!("0.0.1")),
        ("/command".to_owned(), json!("goldtof simulate")),
        ("/scene/name".to_owned(), json!("slow")),
        ("/shards".to_owned(), json!(3)),
    ] {
        changed(&file, &pointer, value);
        let told = refused(&["merge", text(&out)]);
        assert!(told.contains("its SHA-256 is another"), "{pointer}: {told}");
        fs::write(&file, &written).unwrap();
    }
    // One shard under the name of another.
    fs::copy(out.join("shards/1-of-2.json"), &file).unwrap();
    let told = refused(&["merge", text(&out)]);
    assert!(told.contains("it holds shard 1/2, and not the one of its name"), "{told}");
    fs::write(&file, "{}").unwrap();
    assert!(refused(&["merge", text(&out)]).contains("2-of-2.json: cannot be read"));
    fs::remove_file(&file).unwrap();
    fs::create_dir(&file).unwrap();
    assert!(refused(&["merge", text(&out)]).contains("it is not a regular file"));
    fs::remove_dir(&file).unwrap();
    fs::write(&file, &written).unwrap();
    // What is not a shard's name is nobody's business.
    fs::write(out.join("shards/notes.txt"), "mine").unwrap();
    assert_eq!(numbers(done(&["merge", text(&out)])), merged);
}

#[test]
fn shards_of_different_jobs_are_refused_with_what_differs() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("x.toml");
    let quick = fs::read_to_string(QUICK).unwrap();
    fs::write(&scene, &quick).unwrap();
    let fixed = ["simulate", text(&scene), "--repeat", "4", "--set", "scan.integration=2 us"];
    let first = folder.path().join("first");
    done(&[&fixed[..], &["--shard", "1/2", "--out", text(&first)]].concat());
    let with = |more: &[&str], told: &str| {
        let other = tempfile::tempdir().unwrap();
        fs::create_dir(other.path().join("shards")).unwrap();
        done(&[&fixed[..], &["--out", text(other.path())], more].concat());
        for from in shard_files(&first) {
            fs::copy(&from, other.path().join("shards").join(from.file_name().unwrap())).unwrap();
        }
        let said = refused(&["merge", text(other.path())]);
        assert!(said.contains("is not of the same job as"), "{said}");
        assert!(said.contains(told), "{told}: {said}");
    };
    with(&["--shard", "2/2", "--seed", "2"], "seed is 2, there 1");
    with(&["--shard", "2/3"], "the job is cut into 3 shards, there into 2");
    with(&["--shard", "2/2", "--fidelity", "counts"], "fidelity is \"counts\", there \"events\"");
    with(&["--shard", "2/2", "--estimator", "model"], "estimator is \"model\", there null");
    with(&["--shard", "2/2", "--set", "path.distance=4 m"], "path.distance=4 m");
    fs::write(&scene, quick.replace("\"3.2 m\"", "\"3.3 m\"")).unwrap();
    with(&["--shard", "2/2"], "the scene's text is another");
    let sweep = tempfile::tempdir().unwrap();
    done(&[&SWEEP[..], &["--shard", "2/2", "--out", text(sweep.path())]].concat());
    fs::copy(first.join("shards/1-of-2.json"), sweep.path().join("shards/1-of-2.json")).unwrap();
    let told = refused(&["merge", text(sweep.path())]);
    assert!(told.contains("the command is sweep, there simulate"), "{told}");
    // Another version's own shard.
    let again = folder.path().join("again");
    all_shards(&fixed, &again, 2);
    let file = again.join("shards/2-of-2.json");
    let written = fs::read_to_string(&file).unwrap();
    let shard: Value = serde_json::from_str(&written).unwrap();
    let [here, sealed] = ["goldtof", "sha256"].map(|key| shard[key].as_str().unwrap());
    let empty = written.trim_end().replacen(sealed, "", 1);
    let digest = |text: &str| -> String {
        sha2::Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!(digest(&empty), sealed);
    let other = empty.replacen(here, "0.0.1", 1);
    let seal = format!(r#""sha256":"{}""#, digest(&other));
    fs::write(&file, other.replacen(r#""sha256":"""#, &seal, 1)).unwrap();
    let told = refused(&["merge", text(&again)]);
    assert!(told.contains("the version is 0.0.1, there "), "{told}");
}

#[test]
fn shards_that_there_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let with =
        |shard: &str| refused(&[&SIMULATE[..], &["--shard", shard, "--out", text(&out)]].concat());
    for (shard, told) in [
        ("0/4", "there is no shard 0 of 4"),
        ("5/4", "there is no shard 5 of 4: they are numbered from 1 to 4"),
        ("1/0", "0 shards cannot be made"),
        ("x", "write I/N"),
        ("task/4", "this is not a task of an array"),
    ] {
        assert!(with(shard).contains(told), "{shard}");
    }
    let without = refused(&[&SIMULATE[..], &["--shard", "1/2"]].concat());
    assert!(without.contains("--out"), "{without}");
    let nothing = ["--shard", "1/2", "--fidelity", "expected", "--out", text(&out)];
    let told = refused(&[&SIMULATE[..], &nothing].concat());
    assert!(told.contains("the tier expected has no scans"), "{told}");
    assert!(!out.exists());
}

#[test]
fn tasks_of_an_array_are_shards() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let run = |shard: &str, variables: &[(&str, &str)]| {
        let arguments = [&SIMULATE[..], &["--shard", shard, "--out", text(out)]].concat();
        let output = command(&arguments).envs(variables.iter().copied()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    };
    let slurm = [
        ("SLURM_ARRAY_TASK_ID", "1"),
        ("SLURM_ARRAY_TASK_MIN", "1"),
        ("SLURM_ARRAY_TASK_MAX", "3"),
        ("SLURM_ARRAY_TASK_COUNT", "3"),
    ];
    run("task", &slurm);
    run("task/3", &[("SLURM_ARRAY_TASK_ID", "3")]);
    run("task/3", &[("HQ_TASK_ID", "2"), ("SLURM_ARRAY_TASK_ID", "9")]);
    assert_eq!(numbers(done(&["merge", text(out)])), numbers(done(&SIMULATE)));
}

/// Kills a command when `is_under_way` says so, again and again until it comes to its end
/// before that; how often it was killed.
fn killed_until_done(arguments: &[&str], mut is_under_way: impl FnMut() -> bool) -> u32 {
    let began = Instant::now();
    let mut kills = 0;
    loop {
        let mut child =
            command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                assert!(status.success());
                return kills;
            }
            if is_under_way() {
                break;
            }
            assert!(began.elapsed() < Duration::from_secs(300), "it does not go on");
            std::thread::sleep(Duration::from_millis(1));
        }
        // SIGKILL: nothing can be tidied up.
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
    }
}

#[test]
fn a_killed_worker_loses_no_point_and_none_is_there_twice() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, cut] = ["whole", "cut"].map(|name| folder.path().join(name));
    let mut arguments = SWEEP.to_vec();
    arguments[3] = "700";
    done(&[&arguments[..], &["--out", text(&whole)]].concat());
    for number in ["1", "2"] {
        let shard = format!("{number}/2");
        let points = cut.join("shards").join(format!("{number}-of-2")).join("points.log");
        let finished = || fs::read_to_string(&points).map_or(0, |log| log.matches('\n').count());
        let mut before = 0;
        let under_way = || {
            let now = finished();
            let is_more = now > before && now < 3;
            if is_more {
                before = now;
            }
            is_more
        };
        let arguments = [&arguments[..], &["--shard", &shard, "--out", text(&cut)]].concat();
        let kills = killed_until_done(&arguments, under_way);
        assert!((1..=2).contains(&kills), "{kills}");
    }
    assert_eq!(shard_files(&cut).len(), 2, "nothing else is left there");
    // As a kill leaves it between the shard's file and the end.
    let left = cut.join("shards/2-of-2");
    fs::create_dir_all(&left).unwrap();
    for file in ["sweep.json", "points.log"] {
        fs::copy(whole.join(file), left.join(file)).unwrap();
    }
    let again = done(&[&arguments[..], &["--shard", "2/2", "--out", text(&cut)]].concat());
    assert_eq!(again["done_before"], true);
    assert!(!left.exists());
    done(&["merge", text(&cut)]);
    assert_eq!(sweep_files(&cut), sweep_files(&whole));
}

#[test]
fn a_worker_that_is_killed_leaves_its_shard_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let mut arguments = SIMULATE.to_vec();
    arguments[3] = "3000";
    let whole = numbers(done(&arguments));
    let mut kills = 0;
    for number in 1..=3 {
        let shard = format!("{number}/3");
        let arguments = [&arguments[..], &["--shard", &shard, "--out", text(out)]].concat();
        // Ever later, until it comes to its end.
        let mut wait = Duration::from_millis(5);
        let mut started = Instant::now();
        kills += killed_until_done(&arguments, || {
            let is_time = started.elapsed() > wait;
            if is_time {
                wait += wait / 2;
                started = Instant::now();
                let file = out.join(format!("shards/{number}-of-3.json"));
                let is_whole = |text: String| serde_json::from_str::<Value>(&text).is_ok();
                assert!(fs::read_to_string(file).map_or(true, is_whole));
            }
            is_time
        });
    }
    assert!(kills >= 3, "{kills}");
    assert_eq!(numbers(done(&["merge", text(out)])), whole);
}

#[test]
fn stress_cases_come_back_from_shards_in_their_order() {
    let names = [
        "triangles-on-the-grid",
        "folding-is-said",
        "degree-3-in-simulation",
        "detection-probability-0",
        "interleaving-0-to-8",
    ];
    let cases = names.map(str::to_owned).into();
    let job = StressOptions { cases, seed: 3, ..Default::default() };
    let cases = job.chosen().unwrap();
    let verdicts = |mut report: StressReport| {
        for case in &mut report.cases {
            case.run_time_s = 0.0;
        }
        serde_json::to_value(report).unwrap()
    };
    let whole = verdicts(stress::run(&cases, job.seed, |_| ()).unwrap());
    let shard = |number| {
        let part = JobPart::new(number, 3).unwrap();
        let some: Vec<_> = part.every(5).map(|place| cases[place as usize]).collect();
        let report = stress::run(&some, job.seed, |_| ()).unwrap();
        (part, through_json(&Results::Stress(report.cases)))
    };
    let shards = vec![shard(1), shard(2), shard(3)];
    let joined = verdicts(shard::stress_report(&job, shards).unwrap());
    assert_eq!(joined, whole);
    let swapped = vec![(shard(1).0, shard(2).1)];
    let told = shard::stress_report(&job, swapped).unwrap_err().to_string();
    assert!(told.contains("shard 1/3 does not hold its part"), "{told}");
}

#[test]
fn figures_come_back_from_shards_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let open = |name: &str| OutputFolder::open(&folder.path().join(name), |_| ()).unwrap();
    let options =
        ReproduceOptions { seed: 5, repetitions: 2, figures: vec![FigureId::Fig7, FigureId::Fig3] };
    let [whole, joined] = ["whole", "joined"].map(open);
    let of_one_run = reproduce(&options, &whole, |_| ()).unwrap();
    let shard = |number| {
        let part = JobPart::new(number, 2).unwrap();
        let figures = part.every(2).map(|place| options.figures[place as usize]);
        let made = figures.map(|id| MadeFigure::new(id, &options).unwrap());
        (part, through_json(&Results::Reproduce(made.collect())))
    };
    let figures = shard::figures(&options, vec![shard(2), shard(1)]).unwrap();
    for figure in &figures {
        figure.write(&joined).unwrap();
    }
    let said = |mut made: Reproduction| {
        made.run_time_s = 0.0;
        for figure in &mut made.figures {
            figure.run_time_s = 0.0;
        }
        serde_json::to_value(made).unwrap()
    };
    assert_eq!(of_one_run.claims.len(), 2);
    assert_eq!(said(Reproduction::of(&options, figures)), said(of_one_run));
    for name in ["fig03-code-correlation", "fig07-correlation-interleaving"] {
        for kind in ["csv", "svg"] {
            let file = format!("{name}.{kind}");
            let read = |folder: &OutputFolder| fs::read(folder.join(&file)).unwrap();
            assert!(read(&whole) == read(&joined), "{file}");
        }
    }
}

/// As another run reads them.
fn through_json(results: &Results) -> Results {
    serde_json::from_str(&serde_json::to_string(results).unwrap()).unwrap()
}

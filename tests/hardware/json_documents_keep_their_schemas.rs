//! Every document that a command prints or writes holds by its schema in docs/json, as a
//! validator says that is not ours, and every schema has such a document.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use optics_support::repeated;
use serde_json::{Value, json};

/// Reads pairs of a schema's name and a document, and prints the errors of each.
const VALIDATE: &str = "
import json, os, sys
from jsonschema import Draft202012Validator
validators = {}
def validator(name):
    if name not in validators:
        schema = json.load(open(os.path.join(sys.argv[1], name + '.schema.json')))
        Draft202012Validator.check_schema(schema)
        validators[name] = Draft202012Validator(schema)
    return validators[name]
pairs = json.load(sys.stdin)
print(json.dumps([[e.json_path + ': ' + e.message[:200] for e in validator(n).iter_errors(d)] for n, d in pairs]))
";

/// Property names that are numbers without a unit: ratios, statistics, counts that were
/// drawn or expected, and numbers whose unit stands beside them.
const WITHOUT_UNIT: [&str; 23] = [
    "at_least",
    "at_most",
    "chi_square",
    "cross_validation_relative_error",
    "expected_count",
    "expected_count_std",
    "fitted_value",
    "fitted_value_std",
    "high",
    "largest_relative_error",
    "low",
    "measured",
    "median",
    "p_value",
    "relative_power",
    "resolved_error",
    "scene_value",
    "shown_error",
    "signal_to_background",
    "statistic",
    "std_over_bound",
    "std_relative_error",
    "target_error",
];
/// How names of numbers end.
const UNITS: [&str; 9] =
    ["_m", "_s", "_ps", "_hz", "_cps", "_in_std", "_fraction", "_fraction_error", "clocks_per_s"];

/// Words that the glossary has others for.
const BANNED: [&str; 8] = ["cycle", "cycles", "bench", "dwell", "clamp", "ambient", "ci", "sigmas"];

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/json")
}

fn errors(documents: &[(String, Value)]) -> Vec<Vec<String>> {
    let work = tempfile::tempdir().expect("a temporary folder");
    let file = work.path().join("documents.json");
    fs::write(&file, json!(documents).to_string()).expect("it can be written");
    let python = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/python");
    let output = Command::new(python)
        .args(["-c", VALIDATE])
        .arg(folder())
        .stdin(fs::File::open(&file).expect("it was written"))
        .output()
        .expect("scripts/python-tools jsonschema==4.26.0 installs what this needs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).expect("lists of texts")
}

#[test]
fn schemas_are_those_of_the_types() {
    let update = std::env::var_os("GOLDTOF_UPDATE").is_some();
    let mut names = BTreeSet::new();
    for (name, text) in goldtof::cli::documents::schemas() {
        let path = folder().join(format!("{name}.schema.json"));
        if update {
            fs::create_dir_all(folder()).expect("a folder");
            fs::write(&path, &text).expect("it can be written");
        }
        let found = fs::read_to_string(&path).unwrap_or_default();
        let way = "GOLDTOF_UPDATE=1 cargo test --test hardware json_documents";
        assert!(found == text, "{name} is out of date; make it again: {way}");
        names.insert(format!("{name}.schema.json"));
    }
    let there = fs::read_dir(folder()).expect("docs/json is there");
    let there = there.map(|entry| entry.expect("readable").file_name().into_string());
    let there: Result<BTreeSet<String>, _> = there.collect();
    assert_eq!(there.expect("text"), names, "schemas of no document");
}

/// Calls `see` with each property's name and schema, however deep it lies.
fn properties(schema: &Value, see: &mut impl FnMut(&str, &Value)) {
    for named in ["properties", "$defs"] {
        for (name, schema) in schema[named].as_object().into_iter().flatten() {
            if named == "properties" {
                see(name, schema);
            }
            properties(schema, see);
        }
    }
    for several in ["anyOf", "oneOf", "allOf"] {
        let schemas = schema[several].as_array().into_iter().flatten();
        schemas.for_each(|schema| properties(schema, see));
    }
    if schema["items"].is_object() {
        properties(&schema["items"], see);
    }
}

/// What is wrong with a property's name, if anything.
fn complaint(name: &str, schema: &Value) -> Option<&'static str> {
    let is_snake = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let mut words = name.split('_');
    let is_number = schema["type"].to_string().contains("\"number\"");
    let has_unit = UNITS.iter().any(|unit| name.ends_with(unit));
    if !name.chars().all(is_snake) {
        Some("is not in snake_case")
    } else if words.any(|word| BANNED.contains(&word)) {
        Some("is not the standard term")
    } else if !schema["description"].is_string() && !schema["const"].is_string() {
        Some("is not described")
    } else if is_number && !has_unit && !WITHOUT_UNIT.contains(&name) {
        Some("has no unit")
    } else if schema["maxItems"] == 2 && !name.ends_with("_ci95") {
        Some("is an interval and does not say which")
    } else {
        None
    }
}

#[test]
fn names_follow_the_rule() {
    let (mut seen, mut wrong) = (BTreeSet::new(), Vec::new());
    for (document, text) in goldtof::cli::documents::schemas() {
        let schema: Value = serde_json::from_str(&text).expect("JSON");
        properties(&schema, &mut |name, schema| {
            let complaint = complaint(name, schema);
            wrong.extend(complaint.map(|what| format!("{document}: {name} {what}")));
            seen.insert(name.to_owned());
        });
        for head in ["document", "goldtof", "command", "scene"] {
            assert!(schema["properties"][head].is_object(), "{document}: no {head}");
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
    assert!(seen.len() > 150, "{}", seen.len());
    let unused = WITHOUT_UNIT.iter().find(|name| !seen.contains(**name));
    assert_eq!(unused, None);
    let bad =
        [("true_m_", "number"), ("cycles", "integer"), ("Clocks", "integer"), ("walk", "number")];
    for (name, kind) in bad {
        let schema = json!({ "type": kind, "description": "" });
        assert!(complaint(name, &schema).is_some(), "{name}");
    }
}

/// Runs goldtof in the package's folder; the document, whatever the verdict.
fn document(words: &[&str]) -> Value {
    document_with(&[0, 1], words)
}

/// The document of a run that ends with one of these.
fn document_with(statuses: &[i32], words: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args(words)
        .args(["--json", "--quiet"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("goldtof starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code().is_some_and(|code| statuses.contains(&code)), "{words:?}: {said}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{words:?}: {e}: {said}"))
}

fn read(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("it is there");
    serde_json::from_str(&text).expect("JSON")
}

/// A few clocks more would find every fault; no time is spent on what these leave open.
const GRADE: [&str; 10] = [
    "grade",
    "scenes/quick.toml",
    "--clocks",
    "88000",
    "--mutants",
    "5",
    "--proof-time",
    "1",
    "--proof-budget",
    "1",
];

/// Documents of every command, with scenes that fill as many of their fields as may be.
fn documents(work: &Path) -> Vec<Value> {
    let at = |name: &str| work.join(name).to_str().expect("text").to_owned();
    let quick = "scenes/quick.toml";
    let mut all = vec![
        document(&["codes", "--degree", "5", "--interleave", "1"]),
        document(&["codes", "--family", "square"]),
        document(&["completions", "bash"]),
        document(&["man", "--out", &at("man")]),
        document(&["new", &at("my-sensor")]),
        document(&["stress", "--list"]),
        document_with(&[2], &["plan", "tests/scenes/no-such-scene.toml"]),
        document_with(&[2], &["plan", quick, "--set", "clock.chip_period=8"]),
        document(&["stress", "--case", goldtof::study::stress::cases()[0].name]),
        document(&["reproduce", "--figure", "3", "--repeat", "2", "--out", &at("article")]),
        document(&["compare-architectures", quick]),
        document(&["fidelity", quick, "--budget-s", "1", "--target-error", "5%"]),
        document(&["fidelity", quick, "--budget-s", "1", "--target-error", "0.1%"]),
    ];
    all.push(document(&GRADE));
    let scenes = ["quick", "dual-view", "moving", "multipath"].map(|s| format!("scenes/{s}.toml"));
    all.extend(scenes.iter().map(|scene| document(&["plan", scene])));
    let explained = scenes.iter().take(repeated(1, 4) as usize);
    all.extend(explained.map(|scene| document(&["explain", scene])));
    for scene in ["peak", "totals", "dark", "window"] {
        let scene = format!("tests/scenes/{scene}.toml");
        all.push(document(&["emit", &scene, "--out", &at("rtl")]));
        all.push(read(&work.join("rtl/manifest.json")));
        all.push(document(&["cosim", &scene]));
    }
    for fidelity in ["expected", "counts", "events", "sampled", "rtl"] {
        for estimator in ["fft", "model"] {
            let more = ["--repeat", "3", "--estimator", estimator];
            let words = [&["simulate", quick, "--fidelity", fidelity][..], &more].concat();
            all.push(document(&words));
        }
    }
    let tracking = "tests/scenes/tracking.toml";
    let short = ["--set", "scan.integration=13 us"];
    let words = [&["simulate", tracking, "--track=2", "--repeat", "2"][..], &short].concat();
    all.push(document(&words));
    all.push(document(&["cosim", quick, "--stimulus", "adversarial", "--vcd", &at("w.vcd")]));
    all.push(mismatch(work));
    all.push(document(&["cosim", quick, "--board", "tang-nano-9k"]));
    let sweep = ["--over", "path.distance=1 m, 2 m", "--fidelity", "expected"];
    all.push(document(&[&["sweep", quick, "--out", &at("sweep")][..], &sweep].concat()));
    all.push(read(&work.join("sweep/sweep.json")));
    all.extend(shards(work));
    let model = ["--estimator", "model"];
    all.push(document(&[&["run", quick, "--out", &at("run")][..], &model].concat()));
    let counts = at("run/counts.csv");
    for estimator in ["fft", "model"] {
        all.push(document(&["estimate", quick, &counts, "--estimator", estimator]));
    }
    all.push(document(&["estimate", quick, &counts, "--set", "source.mean_power=1 pW"]));
    for rows in ["0,500\n1,510\n", "0,0,500\n0,1,510\n1,0,480\n1,1,550\n"] {
        let heading = if rows.starts_with("0,0") { "run,sample,count" } else { "sample,count" };
        let dark = at("dark.csv");
        fs::write(&dark, format!("{heading}\n{rows}")).expect("it can be written");
        let two = ["--set", "clock.samples_per_chip=2"];
        all.push(document(&[&["calibrate", quick, &dark][..], &two].concat()));
    }
    // Of so few pixels' field of view the laser's light would be two thousand times as dense.
    let small = [
        "--set",
        "array.rows=4",
        "--set",
        "array.columns=6",
        "--set",
        "source.mean_power=1.5 mW",
        "--pixel",
        "1,2",
    ];
    for scene in ["image", "image-glass"] {
        // Theory knows one path.
        let fidelities = if scene == "image" { repeated(1, 2) } else { 1 };
        let scene = format!("scenes/{scene}.toml");
        for fidelity in &["events", "expected"][..fidelities as usize] {
            let words =
                ["image", &scene, "--out", &at("image"), "--fidelity", fidelity, "--check", "5"];
            all.push(document(&[&words[..], &small].concat()));
        }
    }
    all.push(document(&["pulses", quick, "--out", &at("photons.bin")]));
    all.push(document(&["replay", quick, &recording(work), "--photons", "1", "--epoch", "2"]));
    all
}

/// Time tags in pairs: a photon in each code period, at a place that walks, and its epoch.
fn recording(work: &Path) -> String {
    let pairs = (0..30_000_u64).flat_map(|period| {
        let epoch = 1_000_000 + period * 248_000;
        [[epoch, 2], [epoch + 20_000 + period * 7919 % 200_000, 1]]
    });
    let bytes: Vec<u8> = pairs.flatten().flat_map(u64::to_le_bytes).collect();
    let path = work.join("pairs.bin");
    fs::write(&path, bytes).expect("it can be written");
    path.to_str().expect("text").to_owned()
}

/// Of shards of every command that has them.
fn shards(work: &Path) -> Vec<Value> {
    let quick = "scenes/quick.toml";
    let axis = "path.distance=1 m, 2 m";
    let case = goldtof::study::stress::cases()[0].name;
    let expected = ["--fidelity", "expected"];
    let pixels = ["--set", "array.rows=4", "--set", "array.columns=6"];
    let commands = [
        &["simulate", quick, "--repeat", "3", "--shard", "1/2"][..],
        &[&["sweep", quick, "--over", axis, "--shard", "1/1"][..], &expected].concat(),
        &["reproduce", "--figure", "7", "--repeat", "2", "--shard", "1/1"],
        &["stress", "--case", case, "--shard", "1/1"],
        &[&GRADE[..], &["--shard", "1/7"]].concat(),
        &[&["image", "scenes/image.toml", "--shard", "1/2", "--fidelity", "events"][..], &pixels]
            .concat(),
    ];
    let mut all = Vec::new();
    for command in commands {
        let out = work.join("shards").join(command[0]);
        let path = out.to_str().expect("text");
        all.push(document(&[command, &["--out", path]].concat()));
        all.push(document(&["merge", path, "--missing"]));
        let mut files = fs::read_dir(out.join("shards")).expect("it is there");
        all.push(read(&files.next().expect("a shard").expect("readable").path()));
    }
    all
}

/// Of Verilog whose counts have the wrong sign.
fn mismatch(work: &Path) -> Value {
    let rtl = work.join("wrong");
    let out = rtl.to_str().expect("text");
    document(&["emit", "scenes/quick.toml", "--out", out]);
    let file = rtl.join("updown_correlator.v");
    let text = fs::read_to_string(&file).expect("it is there");
    let wrong = text.replacen("<= i_", "<= ~i_", 1);
    assert_ne!(text, wrong);
    fs::write(&file, wrong).expect("it can be written");
    let found = document(&["cosim", "scenes/quick.toml", "--rtl", out]);
    assert_eq!(found["verdict"], "mismatch");
    assert!(found["first_mismatch"]["numbers"][0]["expected"].is_i64(), "{found}");
    found
}

#[test]
fn every_document_holds_and_every_schema_has_one() {
    let work = tempfile::tempdir().expect("a temporary folder");
    let named = |document: Value| {
        let name = document["document"].as_str().expect("a name").to_owned();
        let command = document["command"].as_str().expect("a command");
        assert!(command.starts_with("goldtof "), "{command}");
        assert_eq!(document["goldtof"], goldtof::version::VERSION);
        (name, document)
    };
    let documents: Vec<(String, Value)> = documents(work.path()).into_iter().map(named).collect();
    for (found, (name, document)) in errors(&documents).iter().zip(&documents) {
        assert!(found.is_empty(), "{name}, {}: {found:#?}", document["command"]);
    }
    let there: BTreeSet<&str> = documents.iter().map(|(name, _)| name.as_str()).collect();
    let schemas = goldtof::cli::documents::schemas();
    let all: BTreeSet<&str> = schemas.iter().map(|(name, _)| *name).collect();
    assert_eq!(there, all);
    // The schemas refuse what is no such document: each field left out, of another type,
    // and one too many. Of a schema's documents that have a field the shortest one says it.
    let mut shortest_first: Vec<&(String, Value)> = documents.iter().collect();
    shortest_first.sort_by_cached_key(|(_, document)| document.to_string().len());
    let (mut wrong, mut seen) = (Vec::new(), BTreeSet::new());
    for (name, document) in shortest_first {
        for field in document.as_object().expect("an object").keys() {
            if !seen.insert((name, field.as_str())) {
                continue;
            }
            let mut without = document.clone();
            without.as_object_mut().expect("an object").remove(field);
            wrong.push((name.clone(), without));
            let mut other = document.clone();
            other[field] = json!({ "another": "type" });
            wrong.push((name.clone(), other));
        }
        if seen.insert((name, "unheard_of")) {
            let mut more = document.clone();
            more["unheard_of"] = json!(1);
            wrong.push((name.clone(), more));
        }
    }
    assert!(wrong.len() > 300, "{}", wrong.len());
    for (found, (name, document)) in errors(&wrong).iter().zip(&wrong) {
        assert!(!found.is_empty(), "{name}: {document}");
    }
}

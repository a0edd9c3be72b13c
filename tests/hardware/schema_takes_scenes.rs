//! docs/scene.schema.json, by a validator that is not ours: the standard scenes hold, and
//! scenes that the reader refuses for their form do not.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Reads a list of scenes as JSON and prints how many errors the schema finds in each.
const VALIDATE: &str = "
import json, sys
from jsonschema import Draft7Validator
schema = json.load(open(sys.argv[1]))
Draft7Validator.check_schema(schema)
validator = Draft7Validator(schema)
print([len(list(validator.iter_errors(scene))) for scene in json.load(sys.stdin)])
";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Number of errors in each scene.
fn errors(scenes: &[String]) -> Vec<u32> {
    let scenes: Vec<serde_json::Value> = scenes
        .iter()
        .map(|text| {
            let table: toml::Table = text.parse().expect("it is TOML");
            serde_json::to_value(table).expect("JSON has its types")
        })
        .collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scenes.json");
    fs::write(&file, serde_json::to_string(&scenes).expect("text")).expect("it can be written");
    let python = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/python");
    let output = Command::new(python)
        .args(["-c", VALIDATE])
        .arg(root().join("docs/scene.schema.json"))
        .stdin(fs::File::open(&file).expect("it was written"))
        .output()
        .expect("scripts/python-tools jsonschema==4.26.0 installs what this needs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).expect("a list of numbers")
}

#[test]
fn standard_scenes_hold_and_name_the_schema() {
    let mut scenes = Vec::new();
    for entry in fs::read_dir(root().join("scenes")).expect("scenes/ is there") {
        let path = entry.expect("readable").path();
        let text = fs::read_to_string(&path).expect("readable");
        let names_it = text.starts_with("#:schema ../docs/scene.schema.json\n");
        assert!(names_it, "{}", path.display());
        scenes.push(text);
    }
    scenes.push(include_str!("../../src/cli/new/short.toml").to_owned());
    assert!(scenes.len() > 7);
    assert_eq!(errors(&scenes), vec![0; scenes.len()]);
}

/// Every change is of a scene that holds, and the reader refuses it too.
#[test]
fn malformed_scenes_do_not_hold() {
    let right = fs::read_to_string(root().join("scenes/moving.toml")).expect("it is there");
    let changes = [
        ("chip_period = \"8 ns\"", ""),
        ("chip_period = \"8 ns\"", "chip_period = 8"),
        ("chip_period = \"8 ns\"", "chip_period = \"8\""),
        ("chip_period = \"8 ns\"", "chip_period = \"8 nm\""),
        ("chip_period = \"8 ns\"", "chip_period = \"eight ns\""),
        ("chip_period", "chip_perod"),
        ("samples_per_chip = 8", "samples_per_chip = 65"),
        ("samples_per_chip = 8", "samples_per_chip = 0"),
        ("samples_per_chip = 8", "samples_per_chip = 8.5"),
        ("[clock]", "[clok]"),
        ("[[source]]", "[source]"),
        ("name = \"laser\"", "name = \"\""),
        ("family = \"gold\"", "family = \"golden\""),
        ("degree = 11", "degree = 21"),
        ("degree = 11", "degree = \"11\""),
        ("index = 0", "index = -3"),
        ("interleave = 0", "interleave = 9"),
        ("interleave = 0", "polynomials = [[11, 2, 21]]"),
        ("interleave = 0", "polynomials = [11, 2, 0]"),
        ("interleave = 0", "seeds = [\"012\"]"),
        ("interleave = 0", "chips = \"0120\""),
        ("extinction_ratio = 10 ", "extinction_ratio = 0.5 "),
        ("extinction_ratio = 10 ", "extinction_ratio = \"infinite\" "),
        ("photon_detection_probability = 0.31", "photon_detection_probability = 1.1"),
        ("\"71 kcps\"", "\"71 kHz\""),
        ("probability = 0.137, ", ""),
        ("jitter = [\"53.5 ps\", \"4 ps\"]", "jitter = \"53.5 ps\""),
        ("jitter = [\"53.5 ps\", \"4 ps\"]", "jitter = [53.5]"),
        ("transition = \"1.5 ps\"", "transitions = \"1.5 ps\""),
        ("distance = \"3.2 m\"   ", "delay = \"21 ns\"\ndistance = \"3.2 m\"   "),
        ("distance = \"3.2 m\"   ", ""),
        ("velocity = \"1.5 m/s\"", "velocity = \"1.5 m\""),
        ("std = \"2 mm\", ", ""),
        ("transmission = 1.0", "transmission = 1.5"),
        ("around = \"3.2 m\", ", ""),
        ("around = \"3.2 m\"", "first = 3"),
        ("steps = { around = \"3.2 m\", halfwidth = 32 }", "steps = \"some\""),
        ("integration = \"104.8 us\"", ""),
        ("estimator = \"fft\"", "estimator = \"ftt\""),
        ("target = \"ecp5-25k-6\"", "target = \"ecp5\""),
        ("parallel = 1 ", "parallel = 65 "),
        ("parallel = 1 ", "peak_detector = \"yes\" "),
    ];
    let scenes: Vec<String> = changes
        .iter()
        .map(|(from, to)| {
            assert!(right.contains(from), "{from}");
            right.replacen(from, to, 1)
        })
        .collect();
    for (scene, (from, to)) in scenes.iter().zip(&changes) {
        assert!(goldtof::scene::parse("x.toml", scene).is_err(), "{from} -> {to}");
    }
    let found = errors(&scenes);
    for (errors, (from, to)) in found.iter().zip(&changes) {
        assert!(*errors > 0, "{from} -> {to}");
    }
}

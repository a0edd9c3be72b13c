//! Hits by sample: `sample_counter` against a count in `counting.v` of the same samples.

use std::fs;
use std::process::Command;

use super::Path;

/// Detectors, samples of a chip, whether a pulse is low, and bits of a place.
type Shape = [u32; 4];
const SHAPES: [Shape; 6] =
    [[1, 8, 0, 3], [1, 8, 1, 3], [2, 8, 0, 4], [3, 4, 0, 4], [1, 2, 0, 1], [2, 4, 1, 3]];

/// What the bench says of a counter with this text.
fn said(text: &str, shape: Shape) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("sample_counter.v"), text).expect("it can be written");
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    let names = ["DETECTORS", "SAMPLES", "INVERT", "PLACE_BITS"];
    let set = names.iter().zip(shape).map(|(name, value)| format!("-Pcounting.{name}={value}"));
    let built = Command::new("iverilog")
        .args(["-Wall", "-Wno-timescale", "-g2005", "-s", "counting", "-o", "bench.vvp"])
        .args(set)
        .arg("sample_counter.v")
        .arg(manifest.join("../hdl/bridge/bridge_sync.v"))
        .arg(manifest.join("tests/bridge/counting.v"))
        .current_dir(folder.path())
        .output()
        .expect("iverilog starts");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let run = Command::new("vvp")
        .args(["-n", "bench.vvp"])
        .current_dir(folder.path())
        .output()
        .expect("vvp starts");
    String::from_utf8_lossy(&run.stdout).trim().to_owned()
}

fn counter() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hdl/bridge/sample_counter.v");
    fs::read_to_string(file).expect("it is there")
}

#[test]
fn hits_by_sample_are_those_that_went_in_and_no_sample_counts_for_longer_than_another() {
    for shape in SHAPES {
        assert_eq!(said(&counter(), shape), "right", "{shape:?}");
    }
}

/// Faults in the counter, each of which the bench finds.
#[test]
fn faults_of_the_counter_are_found() {
    for (from, to) in [
        // A pulse that goes on from the word before, or from another detector's.
        ("SAMPLES-1], before_r[d]}", "SAMPLES-1], 1'b0}"),
        ("level_r[place*SAMPLES + SAMPLES - 1]", "level_r[SAMPLES - 1]"),
        // Counting goes on while a host reads, or what waits is left out.
        ("rising & {PLACES{!hold}}", "rising"),
        ("hold && settle_r[FEW_BITS]", "hold"),
        // A word that a host reads is written back elsewhere.
        ("valid_r <= !held_r;", "valid_r <= 1'b1;"),
        ("write_r <= place_r;", "write_r <= place_r + 1'b1;"),
        // Hits that count twice; the place; the pulse's polarity.
        ("place_r == place[PLACE_BITS-1:0] ?", "1'b0 ?"),
        ("held_r ? i_place : place_r", "place_r"),
        ("INVERT != 0 ? ~i_samples : i_samples", "i_samples"),
    ] {
        let text = counter();
        assert_eq!(text.matches(from).count(), 1, "{from}");
        let said = said(&text.replace(from, to), [2, 4, 1, 3]);
        assert!(said.starts_with("sample "), "{from} -> {to}: {said}");
    }
}

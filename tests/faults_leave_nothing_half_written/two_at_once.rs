//! Two runs on one cache, and on one output folder.

use std::fs;

use super::support::*;

#[test]
fn two_runs_on_one_cache_build_once_and_both_work() {
    let folder = tempfile::tempdir().unwrap();
    let cache = cache_without_models();
    let (compiler, linking) = slow_linker(folder.path(), 1);
    let children: Vec<_> = (0..2)
        .map(|_| {
            start(
                goldtof(&["cosim", QUICK, "--cycles", "20000", "--json"])
                    .env("GOLDTOF_CACHE_DIR", cache.path())
                    .env("CXX", &compiler),
            )
        })
        .collect();
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["verdict"], "match");
    }
    let links = fs::read_to_string(&linking).unwrap();
    assert_eq!(links.lines().count(), 1, "built more than once");
}

#[test]
fn two_emissions_into_one_folder_leave_one_of_them() {
    const SCENES: [&str; 2] = [QUICK, "scenes/paper-square.toml"];
    let whole = SCENES.map(emitted);
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..8 {
        let children = SCENES.map(|scene| {
            start(&mut goldtof(&["emit", scene, "--quiet", "--out", text(folder.path())]))
        });
        for child in children {
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        }
        let left = files_below(folder.path());
        assert!(whole.contains(&left), "{:?}", left.keys());
    }
}

#[test]
fn two_whole_runs_into_one_folder_leave_one_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let seeds = ["1", "2"];
    let counts = seeds.map(|seed| {
        let out = folder.path().join(seed);
        ends_with(0, &mut goldtof(&["run", QUICK, "--seed", seed, "--out", text(&out)]));
        fs::read(out.join("counts.csv")).unwrap()
    });
    let out = folder.path().join("both");
    let children =
        seeds.map(|seed| start(&mut goldtof(&["run", QUICK, "--seed", seed, "--out", text(&out)])));
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    let last = fs::read(out.join("counts.csv")).unwrap();
    let seed = counts.iter().position(|counts| *counts == last).unwrap();
    let report = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        report.contains(&format!("seed</th><td>{}<", seeds[seed])),
        "the page is of the other run"
    );
}

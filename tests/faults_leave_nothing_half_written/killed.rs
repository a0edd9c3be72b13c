//! SIGKILL at any moment.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rustix::process::Signal;

use super::support::*;

/// Every file with a final name is one of a whole emission, and a folder with a
/// manifest has all of them.
fn assert_whole(found: &BTreeMap<PathBuf, Vec<u8>>, whole: &BTreeMap<PathBuf, Vec<u8>>) {
    for (path, contents) in found.iter().filter(|(path, _)| !is_hidden(path)) {
        assert!(whole[path] == *contents, "{} is not whole", path.display());
    }
    if found.contains_key(&PathBuf::from("manifest.json")) {
        let missing: Vec<_> = whole.keys().filter(|path| !found.contains_key(*path)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}

#[test]
fn emit_killed_at_any_moment_leaves_only_whole_files() {
    const MOMENTS: u32 = 25;
    let whole = emitted(QUICK);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let arguments = ["emit", QUICK, "--quiet", "--out", text(&out)];
    let started = Instant::now();
    ends_with(0, &mut goldtof(&arguments));
    let mut usual = started.elapsed();
    let mut killed = 0;
    for moment in 0..MOMENTS {
        // Every second time into a folder that is not there yet.
        if moment % 2 == 0 {
            std::fs::remove_dir_all(&out).unwrap_or_default();
        }
        let mut child = start(&mut goldtof(&arguments));
        std::thread::sleep(usual * moment / MOMENTS);
        let _ = child.kill();
        if child.wait().unwrap().code().is_none() {
            killed += 1;
        } else {
            // It was quicker than the first run was, beside other tests.
            usual = usual * 3 / 4;
        }
        assert_whole(&files_below(&out), &whole);
    }
    assert!(killed > MOMENTS / 4, "only {killed} runs were cut off");
    ends_with(0, &mut goldtof(&arguments));
    assert_eq!(files_below(&out), whole);
}

#[test]
fn run_killed_at_any_moment_leaves_only_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let arguments = ["run", QUICK, "--quiet", "--out", text(&out)];
    ends_with(0, &mut goldtof(&arguments));
    let whole = files_below(&out);
    let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    let started = Instant::now();
    ends_with(0, &mut goldtof(&arguments));
    let usual = started.elapsed();
    for moment in 1..8 {
        let mut child = start(&mut goldtof(&arguments));
        std::thread::sleep(usual * moment / 8);
        let _ = child.kill();
        child.wait().unwrap();
        for (path, contents) in files_below(&out) {
            // The page has speeds in it, so its end has to do.
            let is_whole = if path.ends_with("report.html") {
                contents.ends_with(b"</html>")
            } else {
                is_hidden(&path) || whole[&path] == contents
            };
            assert!(is_whole, "{} is not whole", path.display());
        }
    }
    ends_with(0, &mut goldtof(&arguments));
    assert_eq!(names(&files_below(&out)), names(&whole));
}

#[test]
fn a_build_killed_while_it_compiles_is_done_again_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let cache = cache_without_models();
    let (compiler, linking) = slow_linker(folder.path(), 3);
    let mut child = start(
        goldtof(&["cosim", QUICK]).env("GOLDTOF_CACHE_DIR", cache.path()).env("CXX", &compiler),
    );
    wait_until("the linker starts", || linking.exists());
    signal(&child, Signal::KILL);
    child.wait().unwrap();
    let left = entries(cache.path(), "model-");
    assert!(left.iter().all(|path| text(path).contains(".building-")), "{left:?}");
    assert_eq!(left.len(), 1);

    // What the orphaned compiler still writes must not reach the next build.
    let mut next = goldtof(&["cosim", QUICK, "--cycles", "20000"]);
    ends_with(0, next.env("GOLDTOF_CACHE_DIR", cache.path()));
    std::thread::sleep(Duration::from_secs(4));
    let left = entries(cache.path(), "model-");
    assert_eq!(left.len(), 1, "{left:?}");
    assert!(!text(&left[0]).contains(".building-"));
    let mut again = goldtof(&["cosim", QUICK, "--cycles", "20000"]);
    ends_with(0, again.env("GOLDTOF_CACHE_DIR", cache.path()));
}

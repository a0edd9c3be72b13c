//! SIGKILL at any moment.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rustix::process::Signal;

use super::support::*;

/// Every file with a final name is one of a whole emission, and a folder with a
/// manifest has all of those that go with it.
fn assert_whole(found: &BTreeMap<PathBuf, Vec<u8>>, whole: &[BTreeMap<PathBuf, Vec<u8>>]) {
    for (path, contents) in found.iter().filter(|(path, _)| !is_hidden(path)) {
        let is_whole = whole.iter().any(|whole| whole[path] == *contents);
        assert!(is_whole, "{} is not whole", path.display());
    }
    let manifest = PathBuf::from("manifest.json");
    let of_manifest = |whole: &&BTreeMap<_, _>| found.get(&manifest) == whole.get(&manifest);
    for (path, contents) in whole.iter().find(of_manifest).into_iter().flatten() {
        assert!(found.get(path) == Some(contents), "{} is not the manifest's", path.display());
    }
}

#[test]
fn emit_killed_at_any_moment_leaves_only_whole_files() {
    const MOMENTS: u32 = 25;
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let scene = folder.path().join("scene.toml");
    let emit = |integration| {
        integrating_for(integration, &scene);
        goldtof(&["emit", text(&scene), "--quiet", "--out", text(&out)])
    };
    let [older, newer] = ["80 us", "90 us"];
    let started = Instant::now();
    ends_with(0, &mut emit(newer));
    let mut usual = started.elapsed();
    let whole = [newer, older].map(|setting| {
        ends_with(0, &mut emit(setting));
        files_below(&out)
    });
    let mut killed = 0;
    for moment in 0..MOMENTS {
        // Every second time into a folder that is not there yet, else into that of another design.
        match moment % 2 {
            0 => std::fs::remove_dir_all(&out).unwrap_or_default(),
            _ => drop(ends_with(0, &mut emit(older))),
        }
        let mut child = start(&mut emit(newer));
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
    ends_with(0, &mut emit(newer));
    assert_eq!(files_below(&out), whole[0]);
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

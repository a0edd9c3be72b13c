//! A cache of built models that is broken or not to be had.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::support::*;

fn cosim(cache: &Path) -> Command {
    let mut command = goldtof(&["cosim", QUICK, "--cycles", "20000"]);
    command.env("GOLDTOF_CACHE_DIR", cache);
    command
}

#[test]
fn broken_models_are_built_again() {
    let cache = cache_without_models();
    ends_with(0, &mut cosim(cache.path()));
    let model = entries(cache.path(), "model-").remove(0);
    let whole = fs::read(model.join("sensor")).unwrap();

    fs::write(model.join("sensor"), &whole[..whole.len() / 2]).unwrap();
    ends_with(0, &mut cosim(cache.path()));
    assert_eq!(fs::read(model.join("sensor")).unwrap().len(), whole.len());

    let leftover = cache
        .path()
        .join(format!("{}.building-killed", model.file_name().unwrap().to_str().unwrap()));
    fs::create_dir(&leftover).unwrap();
    fs::remove_dir_all(&model).unwrap();
    fs::write(&model, "a file").unwrap();
    ends_with(0, &mut cosim(cache.path()));
    assert!(model.is_dir() && !leftover.exists());
}

#[test]
fn a_broken_run_time_library_is_built_again() {
    let cache = cache_without_models();
    // One for each version and each set of flags that the tools were ever run with.
    let objects: Vec<_> = entries(cache.path(), "runtime-")
        .into_iter()
        .map(|runtime| runtime.join("runtime.o"))
        .collect();
    for object in &objects {
        fs::write(object, "garbled").unwrap();
    }
    ends_with(0, &mut cosim(cache.path()));
    let whole =
        objects.iter().filter(|object| fs::metadata(object).unwrap().len() > 10_000).count();
    assert_eq!(whole, 1, "of {}", objects.len());
}

#[test]
fn a_cache_that_cannot_be_written_is_named_with_what_to_set() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "mine").unwrap();
    for (cache, reason) in [
        (file.clone(), "not a directory"),
        (file.join("cache"), "not a directory"),
        (Path::new("/proc/goldtof").to_owned(), "No such file"),
    ] {
        let told = ends_with(2, &mut cosim(&cache));
        let expected =
            format!("error: {}: cannot keep built models here: {reason}", cache.display());
        assert!(told.starts_with(&expected), "{told}");
        assert!(
            told.contains(
                "set GOLDTOF_CACHE_DIR to a folder that you, and nobody else, can write to"
            ),
            "{told}"
        );
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

//! What is checked in under generated/ is what `emit` writes for scenes/.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use goldtof::deliver::{emit, write};
use goldtof::sensor::Sensor;

/// Every file of a folder and its folders, by its path in it.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(inner) = folders.pop() {
        for entry in fs::read_dir(&inner).expect("the folder can be read") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("inside").to_owned();
                found.insert(name, fs::read(&path).expect("the file can be read"));
            }
        }
    }
    found
}

#[test]
fn emitting_the_standard_scenes_again_changes_nothing() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fresh = tempfile::tempdir().expect("a temporary folder");
    for entry in fs::read_dir(root.join("scenes")).expect("the scenes can be read") {
        let path = entry.expect("readable").path();
        let name = path.file_name().and_then(|name| name.to_str()).expect("plain");
        let scene = goldtof::scene::load(&path).expect("a standard scene is sound");
        let emission =
            emit(&Sensor::new(&scene), &format!("goldtof emit {name}")).expect("it can be built");
        let folder = fresh.path().join(path.file_stem().expect("named"));
        write(&emission, &folder).expect("the files can be written");
    }
    let (kept, made) = (files(&root.join("generated")), files(fresh.path()));
    assert!(!made.is_empty());
    let stale: Vec<&PathBuf> =
        kept.keys().chain(made.keys()).filter(|name| kept.get(*name) != made.get(*name)).collect();
    assert!(stale.is_empty(), "run scripts/regenerate: {stale:?}");
}

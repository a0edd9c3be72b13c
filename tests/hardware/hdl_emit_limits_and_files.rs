//! What `emit` refuses, and what it leaves on disk.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::{MetadataExt as _, symlink};
use std::sync::Arc;

use crate::hdl_support::{Family, code, scene};
use goldtof::code::Generator;
use goldtof::deliver::{emit, write};
use goldtof::scene::{Scene, SourceIndex};
use goldtof::sensor::Sensor;

fn plain() -> Scene {
    scene(&[code(Family::Gold(5), 0, 3)], 0, 8, 0, None, 40, None)
}

fn refusal(scene: &Scene) -> String {
    emit(&Sensor::new(scene), "goldtof emit test.toml")
        .expect_err("the scene is beyond a limit")
        .to_string()
}

#[test]
fn references_of_different_lengths_are_refused() {
    let codes = [code(Family::Gold(5), 0, 3), code(Family::Gold(6), 0, 3)];
    let mut scene = scene(&codes, 0, 8, 0, None, 40, None);
    scene.detectors.push(scene.detectors[0].clone());
    scene.detectors[1].reference = SourceIndex(1);
    assert_eq!(
        refusal(&scene),
        "the detectors' reference codes have [31, 63] chips per period; one scan walks all of \
         them, so they need one length"
    );
}

#[test]
fn steps_at_once_need_time_for_the_reference_to_go_back() {
    let mut scene = scene(&[code(Family::Gold(5), 0, 3)], 0, 8, 0, None, 2, None);
    scene.hardware.parallel = 16;
    assert!(emit(&Sensor::new(&scene), "goldtof emit test.toml").is_ok());
    scene.hardware.parallel = 17;
    assert_eq!(
        refusal(&scene),
        "the integration time is 2 chips; with parallel = 17 and 8 samples per chip the reference \
         goes back by up to 3 chips after each group, so integrate over at least 3 chips"
    );
}

#[test]
fn limits_are_named_with_the_value_that_breaks_them() {
    let codes = [code(Family::Gold(5), 0, 3)];
    assert_eq!(
        refusal(&scene(&codes, 0, 32, 0, None, 40, None)),
        "samples per chip is 32, but the hardware takes 1, 2, 4, 8 or 16"
    );
    assert_eq!(
        refusal(&scene(&codes, 0, 8, 0, None, 40, Some(1))),
        "counter_width is 1, but the hardware takes 2 to 64 bits"
    );
    assert_eq!(
        refusal(&scene(&codes, 0, 8, 0, None, u64::MAX / 2, None)),
        "the integration time in chips is 9223372036854775807, but the hardware takes at most 2^60"
    );
    assert_eq!(
        refusal(&scene(&[code(Family::Gold(3), 5, 3)], 0, 8, 0, None, 40, None)),
        "the interleaving depth of source `laser-0` is 5, but the hardware takes 0 to 4"
    );
    assert_eq!(
        refusal(&scene(&[code(Family::Chips(4097), 0, 3)], 0, 8, 0, None, 40, None)),
        "the number of chips of source `laser-0` is 4097, but the hardware takes 1 to 4096 given \
         chips"
    );
}

#[test]
fn a_code_that_contradicts_its_generator_is_refused() {
    let mut contradicting = (*code(Family::Gold(5), 0, 3)).clone();
    contradicting.chips.pop();
    let scene_with = |code| scene(&[Arc::new(code)], 0, 8, 0, None, 40, None);
    assert_eq!(
        refusal(&scene_with(contradicting)),
        "source `laser-0`: its table has 30 chips, its generator 31"
    );
    let mut dead = (*code(Family::MSequence(5), 0, 3)).clone();
    if let Generator::MSequence(lfsr) = &mut dead.generator {
        lfsr.seed = vec![0; 5];
    }
    assert_eq!(
        refusal(&scene_with(dead)),
        "source `laser-0`: a seed needs as many chips as the degree, and one that is 1"
    );
}

#[test]
fn a_second_emission_removes_the_files_that_only_the_first_had() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let interleaved = scene(&[code(Family::Gold(5), 1, 3)], 0, 8, 0, None, 40, None);
    let first = emit(&Sensor::new(&interleaved), "first").expect("the scene is fine");
    write(&first, folder.path()).expect("the files can be written");
    fs::write(folder.path().join("mine.v"), "// the user's own\n").expect("written");
    assert!(folder.path().join("interleaver.v").exists());
    let second = emit(&Sensor::new(&plain()), "second").expect("the scene is fine");
    write(&second, folder.path()).expect("the files can be written");

    let mut found: Vec<String> = fs::read_dir(folder.path())
        .expect("the folder is there")
        .map(|entry| entry.expect("readable").file_name().into_string().expect("plain"))
        .collect();
    found.sort();
    let all = second.files.iter().chain(second.flow.files());
    let mut expected: Vec<String> = all.map(|f| f.name.clone()).collect();
    expected.extend(["formal", "manifest.json", "mine.v"].map(str::to_owned));
    expected.sort();
    assert_eq!(found, expected);
}

/// `make` and an FPGA's tools do again what depends on a file that is newer.
#[test]
fn an_emission_leaves_files_that_stand_there_as_they_are_to_be() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    // A file that is written anew is another one.
    let files = || -> BTreeMap<String, (u64, Vec<u8>)> {
        let folders = [folder.path().to_owned(), at("formal")];
        let entries = folders.iter().flat_map(|folder| fs::read_dir(folder).expect("it is there"));
        let paths = entries.map(|entry| entry.expect("readable").path());
        let files = paths.filter(|path| path.is_file()).map(|path| {
            let inode = fs::symlink_metadata(&path).expect("it is there").ino();
            (path.display().to_string(), (inode, fs::read(&path).expect("readable")))
        });
        files.collect()
    };
    let emit_now = |scene: &Scene| {
        let emission = emit(&Sensor::new(scene), "goldtof test").expect("the scene is fine");
        write(&emission, folder.path()).expect("the files can be written");
    };
    emit_now(&plain());
    let first = files();
    emit_now(&plain());
    assert_eq!(files(), first);

    // What another scene has in common.
    let other = scene(&[code(Family::Gold(5), 0, 3)], 0, 8, 0, None, 80, None);
    emit_now(&other);
    let second = files();
    let (same, new): (Vec<_>, Vec<_>) =
        second.iter().partition(|(name, (_, text))| first.get(*name).is_some_and(|f| f.1 == *text));
    assert!(same.len() > 10 && new.len() > 4, "{same:?} {new:?}");
    for (name, (inode, _)) in same {
        assert_eq!(*inode, first[name].0, "{name}");
    }
    assert!(new.iter().any(|(name, _)| name.ends_with("manifest.json")));

    // What somebody has changed since, in its text, in its length, or to a link to a file that holds the same.
    let top = at("sensor_top.v");
    let text = fs::read_to_string(&top).expect("readable");
    fs::write(&top, text.replacen("module", "MODULE", 1)).expect("written");
    fs::write(at("sensor_top.f"), "").expect("written");
    let constraints = at("sensor_top.sdc");
    fs::rename(&constraints, at("elsewhere.sdc")).expect("renamed");
    symlink("elsewhere.sdc", &constraints).expect("linked");
    fs::remove_file(at("formal").join("sensor_top.sby")).expect("removed");
    emit_now(&other);
    fs::remove_file(at("elsewhere.sdc")).expect("removed");
    let third = files();
    let texts = |files: &BTreeMap<String, (u64, Vec<u8>)>| -> Vec<(String, Vec<u8>)> {
        files.iter().map(|(name, (_, text))| (name.clone(), text.clone())).collect()
    };
    assert_eq!(texts(&third), texts(&second));
    let renewed = third.iter().filter(|(name, file)| second[*name].0 != file.0).count();
    assert_eq!(renewed, 5, "four files and the manifest");
}

#[test]
fn a_manifest_that_names_files_elsewhere_removes_nothing_there() {
    let outer = tempfile::tempdir().expect("a temporary folder");
    fs::write(outer.path().join("keep.v"), "").expect("written");
    let folder = outer.path().join("build");
    fs::create_dir(&folder).expect("created");
    let manifest = r#"{"files": ["../keep.v"]}"#;
    fs::write(folder.join("manifest.json"), manifest).expect("written");
    let emission =
        emit(&Sensor::new(&plain()), "goldtof emit test.toml").expect("the scene is fine");
    write(&emission, &folder).expect("the files can be written");
    assert!(outer.path().join("keep.v").exists());
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("written");
    let emission =
        emit(&Sensor::new(&plain()), "goldtof emit test.toml").expect("the scene is fine");
    let error = write(&emission, &file.join("build")).expect_err("a file is not a folder");
    assert!(error.to_string().contains("file/build"), "{error}");
}

/// What a scene at a limit is emitted as, with parallel steps and a peak
/// detector.
fn at_the_limit(scene: &mut Scene, parallel: u32) -> goldtof::deliver::BuildParameters {
    scene.hardware.parallel = parallel;
    scene.hardware.peak_detector = true;
    let emission = emit(&Sensor::new(scene), "goldtof emit test.toml")
        .expect("the scene is within the limits");
    emission.parameters
}

#[test]
fn the_widest_count_is_emitted_and_one_bit_more_is_refused() {
    let codes = [code(Family::Gold(5), 0, 3)];
    // |count| <= 2^60 * 8 needs 64 bits and a sign; a little less needs one fewer.
    let widest = (1 << 60) - 1;
    let mut widest = scene(&codes, 0, 16, 0, None, widest, None);
    assert_eq!(at_the_limit(&mut widest, 1).count_bits, 64);
    let wider = scene(&codes, 0, 16, 0, None, 1 << 60, None);
    assert_eq!(
        refusal(&wider),
        "the width of a count that cannot overflow is 65, but the hardware takes at most 64 bits; \
         integrate over fewer chips"
    );
}

#[test]
fn the_longest_code_is_emitted_with_the_most_steps_at_once() {
    let codes = [code(Family::MSequence(16), 4, 3)];
    let mut longest = scene(&codes, 0, 16, 0, None, 13_100, None);
    let parameters = at_the_limit(&mut longest, 64);
    assert_eq!(parameters.code_period_chips, 65_535 * 16);
    let peak = parameters.peak.expect("it has a peak detector");
    // 16 * 16 * 65,535 phase steps.
    assert_eq!(peak.step_bits, 24);
    longest.hardware.parallel = 65;
    assert_eq!(refusal(&longest), "parallel is 65, but the hardware takes 1 to 64");
}

#[test]
fn a_peak_detector_needs_time_to_compare_the_counts_of_a_group() {
    let codes = [code(Family::Gold(5), 0, 3)];
    let of = |integration| scene(&codes, 0, 8, 0, None, integration, None);
    // Counts of 12 bits are compared in two pieces, which takes four clocks; the
    // banks of four are a clock apart.
    let needed = 64 * 4 + 16;
    assert_eq!(at_the_limit(&mut of(needed), 64).count_bits, 12);
    let mut short = of(needed - 1);
    short.hardware.parallel = 64;
    short.hardware.peak_detector = true;
    assert!(refusal(&short).contains("because the counts of a group are compared"));
}

//! What a reader of the emitted Verilog meets: lines that fit, comments in proportion, and end
//! states of counters that simulation does not take on trust.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::hdl_support::draw::{self, Extent};
use crate::hdl_support::{Family, code, run, scene};
use goldtof::deliver::{Emission, EmittedFile, Prefix, emit, verilog, write};
use goldtof::scene::Scene;
use goldtof::sensor::Sensor;
use optics_support::repeated;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const MOST_COLUMNS: usize = 100;

#[test]
fn no_line_of_a_module_is_longer_than_a_hundred_columns() {
    let lines = (0..100).into_par_iter().map(|scene| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(scene);
        let (_, files) = draw::modules(&mut rng, Extent::WHOLE);
        let (mut commented, mut all) = (0, 0);
        for file in &files {
            for line in file.text.lines().filter(|line| !line.is_empty()) {
                assert!(line.len() <= MOST_COLUMNS, "{}: {line}", file.name);
                assert_eq!(line.trim_end(), line, "{}", file.name);
                all += 1;
                commented += usize::from(line.contains("//"));
            }
        }
        (commented, all)
    });
    let (commented, all) = lines.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let share = commented as f64 / all as f64;
    assert!((0.15..0.38).contains(&share), "{share:.3} of all lines");
}

/// Modules that differ in a width or a count are one, with parameters. A number is left where codes
/// differ, or the pieces of a comparison, which have a register each.
#[test]
fn no_module_is_there_twice_for_a_size() {
    (0..100).into_par_iter().for_each(|scene| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(scene);
        for EmittedFile { name, .. } in &draw::modules(&mut rng, Extent::WHOLE).1 {
            let module = name.trim_end_matches(".v");
            let kind = module.trim_end_matches(|c: char| c.is_ascii_digit());
            let is_numbered = kind.ends_with('_') && kind.len() < module.len();
            let others = ["_generator_", "interleaver_", "detector_channel_", "state_match_"];
            assert!(!is_numbered || others.iter().any(|end| kind.ends_with(end)), "{name}");
        }
    });
}

#[test]
fn a_size_that_a_module_does_not_take_is_refused_by_each_tool() {
    let codes = [code(Family::Gold(5), 0, 2)];
    let mut scene = scene(&codes, 0, 8, 0, None, 300, None);
    scene.hardware.parallel = 6;
    let emission = emit(&Sensor::new(&scene), "goldtof emit test.toml").expect("it is sound");
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_files(&emission.files, folder.path());
    let channel = folder.path().join("detector_channel.v");
    let sound = fs::read_to_string(&channel).expect("the module is there");
    let names: Vec<&str> = emission.files.iter().map(|file| file.name.as_str()).collect();
    let read = format!("read_verilog {}; hierarchy -check -top sensor_top", names.join(" "));
    for (steps, is_taken) in [(1, true), (2, true), (0, false)] {
        fs::write(&channel, sound.replace(".STEPS(2)", &format!(".STEPS({steps})")))
            .expect("it can be written");
        for (tool, arguments) in [
            ("verilator", &["--lint-only", "--top-module", "sensor_top"][..]),
            ("iverilog", &["-g2005", "-s", "sensor_top", "-o", "sensor.vvp"]),
            ("yosys", &["-q", "-p", &read]),
        ] {
            let mut command = std::process::Command::new(tool);
            command.args(arguments).current_dir(folder.path());
            if tool != "yosys" {
                command.args(&names);
            }
            let said = command.output().expect("the tool is there");
            let said = [said.stdout, said.stderr].concat();
            let said = String::from_utf8_lossy(&said);
            let is_refused = said.contains("correlator_bank_takes_STEPS_of_1_or_more");
            assert_eq!(is_refused, !is_taken, "{tool}, {steps} steps: {said}");
        }
    }
}

fn write_files(files: &[EmittedFile], folder: &Path) {
    for file in files {
        fs::write(folder.join(&file.name), &file.text).expect("it can be written");
    }
}

/// What Icarus says of a module, and of what it instantiates, before any clock: the words
/// of its checks.
fn said_by_checks(folder: &Path, module: &str) -> String {
    let file = format!("{module}.v");
    let arguments = ["-g2005", "-s", module, "-y", ".", "-o", "checks.vvp", &file];
    run(folder, "iverilog", &arguments);
    run(folder, "vvp", &["-n", "checks.vvp"])
}

/// Constants of LFSRs in `text`: name, where the digits of their value are, bits, value.
fn states(text: &str) -> Vec<(String, std::ops::Range<usize>, u32, u64)> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("    localparam [") {
        let line = text[at..].lines().next().expect("it begins one");
        let (declared, value) = line.split_once(" = ").expect("a value");
        let name = declared.split_whitespace().nth(2).expect("a name");
        let is_state = ["CHIP_COUNT", "STEP_COUNT", "U_"].iter().any(|n| name.starts_with(n));
        if !is_state {
            continue;
        }
        let value = value.split(';').next().expect("an end");
        let (width, digits) = value.split_once('\'').expect("a width");
        let radix = if digits.starts_with('h') { 16 } else { 10 };
        let number = u64::from_str_radix(&digits[1..], radix).expect("a number");
        let start = at + declared.len() + " = ".len();
        let width = width.parse().expect("a width");
        found.push((name.to_owned(), start..start + value.len(), width, number));
    }
    found
}

fn scenes() -> Vec<Scene> {
    let gold = [code(Family::Gold(11), 0, 3)];
    let sequence = [code(Family::MSequence(7), 1, 5)];
    vec![
        // Comparisons in pieces, scans without a gap.
        scene(&gold, 0, 8, 0, None, 13_100, None),
        // A start of its own for every scan; few chips and steps.
        scene(&sequence, 0, 4, 5, Some(6), 40, None),
        // The longest integration.
        scene(&gold, 0, 1, 7, Some(70), 1 << 44, None),
    ]
}

#[test]
fn a_wrong_bit_in_a_constant_of_an_lfsr_is_caught_before_the_first_clock() {
    let constants = scenes().into_iter().flat_map(|scene| {
        let prefix = Prefix::default();
        let files = verilog(&Sensor::new(&scene), &prefix, "goldtof emit test.toml");
        let files = files.expect("the scene is fine");
        let folder = tempfile::tempdir().expect("a temporary folder");
        write_files(&files, folder.path());
        assert_eq!(said_by_checks(folder.path(), "sensor_top"), "");
        let of_file = |at: usize| states(&files[at].text).into_iter().map(move |s| (at, s));
        let all: Vec<_> = (0..files.len()).flat_map(of_file).collect();
        all.into_iter().map(move |(at, state)| (files.clone(), at, state))
    });
    let constants: Vec<_> = constants.collect();
    let tried: Vec<(String, u32)> = constants
        .into_par_iter()
        .map(|(files, at, (name, place, width, value))| {
            let folder = tempfile::tempdir().expect("a temporary folder");
            write_files(&files, folder.path());
            let file = &files[at];
            let module = file.name.strip_suffix(".v").expect("a file of Verilog");
            for bit in (0..width).step_by(repeated(3, 1) as usize) {
                let wrong = format!("{width}'h{:x}", value ^ 1 << bit);
                let mut text = file.text.clone();
                text.replace_range(place.clone(), &wrong);
                fs::write(folder.path().join(&file.name), text).expect("it can be written");
                let said = said_by_checks(folder.path(), module);
                let stem = name.to_lowercase();
                let stem = stem.rsplit_once('_').expect("two words").0;
                assert!(
                    said.contains(stem) && said.contains("shifts lead from"),
                    "{name}, bit {bit} wrong, in {}: {said:?}",
                    file.name
                );
            }
            (name, width)
        })
        .collect();
    let mut bits = BTreeMap::<String, u32>::new();
    for (name, width) in tried {
        *bits.entry(name).or_default() += width;
    }
    let names = [
        "CHIP_COUNT_END",
        "CHIP_COUNT_FIRST",
        "CHIP_COUNT_RESET",
        "CHIP_COUNT_TAPS",
        "STEP_COUNT_END",
        "STEP_COUNT_FIRST",
        "STEP_COUNT_TAPS",
        "U_LAST",
        "U_LOAD",
        "U_TAPS",
    ];
    assert!(bits.keys().eq(names), "{bits:?}");
    println!("every wrong bit caught: {bits:?}");
}

#[test]
fn a_wrong_end_state_does_not_pass_the_emitted_testbench() {
    let scene = scene(&[code(Family::Gold(5), 0, 3)], 0, 4, 5, Some(6), 40, None);
    let mut emission: Emission =
        emit(&Sensor::new(&scene), "goldtof emit test.toml").expect("it is fine");
    let controller = emission.files.iter_mut().find(|f| f.name == "scan_controller.v");
    let controller = controller.expect("a scan has one");
    let (_, place, width, value) = states(&controller.text)
        .into_iter()
        .find(|state| state.0 == "CHIP_COUNT_END")
        .expect("steps of 40 chips are counted");
    controller.text.replace_range(place, &format!("{width}'h{:x}", value ^ 1));
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&emission, folder.path()).expect("the files can be written");
    let arguments = ["-g2005", "-s", "sensor_top_tb", "-o", "b.vvp", "-f", "sensor_top_tb.f"];
    run(folder.path(), "iverilog", &arguments);
    let said = run(folder.path(), "vvp", &["-n", "b.vvp"]);
    assert!(said.contains("chip_count_end_check"), "{said}");
    assert!(!said.contains("PASS"), "{said}");
}

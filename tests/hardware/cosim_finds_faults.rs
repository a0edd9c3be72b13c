//! Single edits to emitted Verilog: co-simulation finds each that is planted, at the first clock
//! where a port differs, under one stimulus or the other; the emitted testbench finds
//! each, too.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use goldtof::cosim::engine::Engine;
use goldtof::cosim::source::{SourceFile, Verilog};
use goldtof::cosim::{CosimOptions, Report, StimulusKind, Verdict, cosimulate};
use goldtof::reference::adversarial::{Adversarial, LONGEST_DEFAULT};
use goldtof::rtl::blocks::ScanRegisters;
use goldtof::sensor::Sensor;

use crate::hdl_support::models;
use crate::planted_faults::*;
use rayon::prelude::*;

/// One after the other.
const STIMULI: [StimulusKind; 2] = [StimulusKind::Adversarial, StimulusKind::Photons];

fn goldtof(cache: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .env("GOLDTOF_CACHE_DIR", cache)
        .args(arguments)
        .output()
        .unwrap()
}

/// What co-simulation in lock-step says of the Verilog in a folder. Steps and scans of what is
/// `as_emitted` are shortened.
fn cosim(
    scene: &str,
    rtl: &Path,
    stimulus: StimulusKind,
    clocks: Option<u64>,
    as_emitted: bool,
) -> Report {
    let sensor = Sensor::new(&goldtof::scene::load(Path::new(scene)).unwrap());
    let mut files: Vec<PathBuf> = fs::read_dir(rtl)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "v"))
        .filter(|path| !path.to_str().unwrap().contains("_tb"))
        .collect();
    files.sort();
    let source = |path: PathBuf| SourceFile {
        name: path.file_name().unwrap().to_str().unwrap().to_owned(),
        text: fs::read_to_string(&path).unwrap(),
        origin: Some(path),
    };
    let verilog = Verilog {
        top: goldtof::cosim::TOP.to_owned(),
        sources: files.into_iter().map(source).collect(),
        registers: as_emitted.then(|| ScanRegisters::of(sensor.interface())),
        cache: models(),
    };
    let engine = Engine::Lockstep;
    let options = CosimOptions { stimulus, clocks, engine, ..Default::default() };
    cosimulate(&sensor, &verilog, &options, |_, _| ()).unwrap().report
}

/// Copies the emitted files.
fn copy(rtl: &Path, folder: &Path) {
    fs::create_dir(folder).unwrap();
    for entry in fs::read_dir(rtl).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
}

/// A file without the design's own checks of its constants, which would be faster than
/// what is tried here.
fn unchecked(rtl: &Path, file: &str) -> String {
    let text = fs::read_to_string(rtl.join(file)).unwrap();
    text.replace("`ifndef SYNTHESIS", "`ifdef NEVER")
}

/// The text with the fault in it.
fn edited(text: &str, (file, from, to): &Fault) -> String {
    let found = text.matches(from).count();
    assert_eq!(found, 1, "{file}: {from} -> {to}");
    text.replace(from, to)
}

/// A copy of the Verilog with the fault in it.
fn faulty_copy(work: &Path, rtl: &Path, fault: &Fault, number: usize) -> PathBuf {
    let folder = work.join(format!("fault-{number}"));
    copy(rtl, &folder);
    fs::write(folder.join(fault.0), edited(&unchecked(rtl, fault.0), fault)).unwrap();
    folder
}

/// Several faults in one design, of which a file names the one that is there: the number of
/// the fault from 1, or that of a copy of the first one's module, which is sound.
struct Selectable {
    folder: PathBuf,
    selector: PathBuf,
    sound: usize,
}

impl Selectable {
    /// Puts in the place of each module with faults one that has it sound and with every
    /// fault side by side, all with the same inputs, and hands on the outputs of one. What a
    /// module with a fault instantiates is sound, or the design would grow with the product
    /// of the faults of its levels.
    fn new(work: &Path, name: &str, rtl: &Path, faults: &[Fault]) -> Selectable {
        let all = Selectable {
            folder: work.join(name),
            // Its name is part of the model.
            selector: Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fault-of-{name}")),
            sound: faults.len() + 1,
        };
        copy(rtl, &all.folder);
        let modules = modules(rtl);
        let sound: String = modules
            .iter()
            .map(|module| {
                let text = on_sound_modules(&unchecked(rtl, &format!("{module}.v")), &modules);
                text.replace(&format!("module {module} "), &format!("module {module}_sound "))
            })
            .collect();
        fs::write(all.folder.join("sound.v"), sound).unwrap();
        let files: BTreeSet<&str> = faults.iter().map(|fault| fault.0).collect();
        for file in files {
            let sound = unchecked(rtl, file);
            let name = file.strip_suffix(".v").unwrap();
            let named = |number: usize, text: &str| {
                let head = format!("module {name} ");
                assert_eq!(text.matches(&head).count(), 1, "{file}");
                text.replace(&head, &format!("module {name}_with_{number} "))
            };
            let mut text = named(0, &sound);
            let mut numbers = vec![0];
            for (index, fault) in faults.iter().enumerate().filter(|(_, f)| f.0 == file) {
                let faulty = on_sound_modules(&edited(&sound, fault), &modules);
                text += &named(index + 1, &faulty);
                numbers.push(index + 1);
            }
            if file == faults[0].0 {
                text += &named(all.sound, &on_sound_modules(&sound, &modules));
                numbers.push(all.sound);
            }
            text += &chooser(name, &sound, &numbers, &all.selector);
            fs::write(all.folder.join(file), text).unwrap();
        }
        all
    }

    /// Lets a fault be there from now on.
    fn select(&self, number: usize) {
        fs::write(&self.selector, number.to_string()).unwrap();
    }
}

/// Names of the modules of an emitted folder, each in a file of its name.
fn modules(rtl: &Path) -> Vec<String> {
    let files = fs::read_dir(rtl).unwrap();
    let mut modules: Vec<String> = files
        .filter_map(|file| Some(file.unwrap().file_name().to_str()?.strip_suffix(".v")?.to_owned()))
        .filter(|name| !name.contains("_tb"))
        .collect();
    modules.sort();
    modules
}

/// A module's text with `_sound` after the name of every module that it instantiates.
fn on_sound_modules(text: &str, modules: &[String]) -> String {
    let is_named = |word: &str| modules.iter().any(|module| module == word);
    let lines = text.lines().map(|line| {
        let code = line.trim_start();
        match code.split_once(' ') {
            Some((word, rest)) if is_named(word) => format!("    {word}_sound {rest}\n"),
            _ => format!("{line}\n"),
        }
    });
    lines.collect()
}

/// The module `name` with the header of `sound`, round the modules of these numbers.
fn chooser(name: &str, sound: &str, numbers: &[usize], selector: &Path) -> String {
    let start = sound.find(&format!("module {name} ")).unwrap();
    let length = sound[start..].find("\n);").unwrap();
    let header = &sound[start..start + length + 3];
    let code = header.lines().map(|line| line.split("//").next().unwrap());
    let words: Vec<String> =
        code.map(|line| line.trim().trim_end_matches(',').to_owned()).collect();
    let last = |line: &str| line.split_whitespace().last().unwrap().to_owned();
    let of_kind = |kind: &str| -> Vec<(String, String)> {
        let lines = words.iter().filter(|line| line.starts_with(kind));
        let range = |line: &str| match (line.find('['), line.find(']')) {
            (Some(from), Some(to)) => line[from..=to].to_owned(),
            _ => String::new(),
        };
        lines
            .flat_map(|line| {
                let declared = line.split('=').next().unwrap().trim();
                declared.split(", ").map(|one| (last(one), range(declared)))
            })
            .collect()
    };
    let (inputs, outputs) = (of_kind("input"), of_kind("output"));
    assert!(!outputs.is_empty(), "{name}: {header}");
    let parameters: Vec<String> =
        of_kind("parameter").iter().map(|(name, _)| format!(".{name}({name})")).collect();
    let parameters = match parameters.is_empty() {
        true => String::new(),
        false => format!("#({}) ", parameters.join(", ")),
    };
    let mut text = header.replace("output reg", "output wire") + "\n";
    let _ = writeln!(
        text,
        "    integer file, fault;\n    initial begin\n        file = $fopen(\"{}\", \"r\");\n        \
         if ($fscanf(file, \"%d\", fault) != 1) $fatal;\n        $fclose(file);\n    end",
        selector.display()
    );
    // What is not chosen rests, but for reset: processes with other bits for what is undefined
    // hold the same behind it, and rest, too.
    let is_reset = inputs.iter().any(|(input, _)| input == "i_rst");
    // The sound one stands for every fault of another module, too.
    let elsewhere: Vec<String> = numbers[1..].iter().map(|n| format!("fault != {n}")).collect();
    for number in numbers {
        let clock = match is_reset {
            true => format!("i_clk & (is_{number} | i_rst)"),
            false => format!("i_clk & is_{number}"),
        };
        let is_there = match number {
            0 => elsewhere.join(" && "),
            _ => format!("fault == {number}"),
        };
        let _ = writeln!(text, "    wire is_{number} = {is_there};");
        let driven = |input: &str| match input {
            "i_clk" => format!(".{input}({clock})"),
            _ => format!(".{input}({input})"),
        };
        let mut ports: Vec<String> = inputs.iter().map(|(input, _)| driven(input)).collect();
        for (output, range) in &outputs {
            let _ = writeln!(text, "    wire {range} {output}_{number};");
            ports.push(format!(".{output}({output}_{number})"));
        }
        let ports = ports.join(", ");
        let _ = writeln!(text, "    {name}_with_{number} {parameters}of_{number} ({ports});");
    }
    for (output, _) in &outputs {
        let chosen = numbers[1..]
            .iter()
            .fold(format!("{output}_0"), |rest, n| format!("fault == {n} ? {output}_{n} : {rest}"));
        let _ = writeln!(text, "    assign {output} = {chosen};");
    }
    text + "endmodule\n"
}

/// Clocks that each stimulus takes by itself of Verilog that is not as it was emitted. An adversary is all gone through
/// to know them, which takes longer than most faults.
fn clocks_of_stimuli(scene: &str) -> [Option<u64>; 2] {
    let sensor = Sensor::new(&goldtof::scene::load(Path::new(scene)).unwrap());
    let adversary = Adversarial::new(sensor.interface(), CosimOptions::default().seed);
    STIMULI.map(|stimulus| match stimulus {
        StimulusKind::Adversarial => Some(adversary.clone().clocks_of_a_run(LONGEST_DEFAULT)),
        StimulusKind::Photons => None,
    })
}

/// Finds the fault that is there, or says that it was not found, in so many clocks of each
/// stimulus; gives the clocks of each up to where it was found.
fn find(
    scene: &str,
    rtl: &Path,
    clocks: [Option<u64>; 2],
    fault: &Fault,
    is_timed: bool,
) -> Result<[u64; 2], String> {
    let (file, from, to) = fault;
    let name = format!("{file}: {from} -> {to}");
    for (number, (stimulus, clocks)) in STIMULI.into_iter().zip(clocks).enumerate() {
        let report = cosim(scene, rtl, stimulus, clocks, false);
        if report.verdict == Verdict::Match {
            continue;
        }
        assert_eq!(report.verdict, Verdict::Mismatch, "{name}");
        let first = report.first_mismatch.unwrap();
        assert_ne!(first.expected, first.got, "{name}");
        if is_timed && first.clock < LATE {
            // It is the first clock: a run that ends just before it matches, and
            // one that ends with it does not.
            let verdict_after =
                |clocks: u64| cosim(scene, rtl, stimulus, Some(clocks), false).verdict;
            let clock = first.clock;
            if clock > 0 {
                // It may be too short to tell anything.
                assert_ne!(verdict_after(clock), Verdict::Mismatch, "{name}: clock {clock}");
            }
            assert_eq!(verdict_after(clock + 1), Verdict::Mismatch, "{name}: clock {clock}");
        }
        let mut found_after = [0; 2];
        found_after[number] = first.clock + 1;
        return Ok(found_after);
    }
    Err(format!("{name}: not found"))
}

/// Faults of one model. Every one of them is evaluated at each clock, whichever is there, and
/// what there is to compile grows with them, too; but each model costs a second or two by itself.
const OF_A_MODEL: usize = 13;

/// Clocks behind which nothing is run twice more to see that a mismatch is the first.
const LATE: u64 = 500_000;

fn all_are_found(scene: &str, faults: &[Fault]) {
    let faults = planted(faults);
    let work = tempfile::tempdir().unwrap();
    let rtl: PathBuf = work.path().join("rtl");
    let emitted = goldtof(work.path(), &["emit", scene, "--out", rtl.to_str().unwrap()]);
    assert!(emitted.status.success());
    let name = Path::new(scene).file_stem().unwrap().to_str().unwrap();
    for stimulus in STIMULI {
        let verdict = cosim(scene, &rtl, stimulus, None, true).verdict;
        assert_eq!(verdict, Verdict::Match, "{scene}");
    }
    let clocks = clocks_of_stimuli(scene);
    let missed_of = |(number, faults): (usize, &[Fault])| -> Vec<String> {
        let all = Selectable::new(work.path(), &format!("{name}-{number}"), &rtl, faults);
        let (mut missed, mut found_after) = (Vec::new(), [0_u64; 2]);
        for (index, fault) in faults.iter().enumerate() {
            all.select(index + 1);
            // That the clock is the first is the same claim of every fault: of each module's
            // first one it is looked at.
            let is_timed = faults[..index].iter().all(|other| other.0 != fault.0);
            match find(scene, &all.folder, clocks, fault, is_timed) {
                Ok(after) => found_after = [0, 1].map(|at| found_after[at].max(after[at])),
                Err(reason) => missed.push(reason),
            }
        }
        // What was found is the fault: a copy without one, chosen as they are, matches as far.
        all.select(all.sound);
        for (stimulus, clocks) in STIMULI.into_iter().zip(found_after) {
            if clocks > 0 {
                let verdict = cosim(scene, &all.folder, stimulus, Some(clocks), false).verdict;
                assert_ne!(verdict, Verdict::Mismatch, "{scene} without a fault");
            }
        }
        missed
    };
    let missed: Vec<String> =
        faults.par_chunks(OF_A_MODEL).enumerate().flat_map_iter(missed_of).collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Looks for every fault, several at a time; gives the reasons of those that fail.
fn missed_by(
    faults: &[Fault],
    find: impl Fn(usize, &Fault) -> Result<(), String> + Sync,
) -> Vec<String> {
    let faults = faults.par_iter().enumerate();
    faults.filter_map(|(number, fault)| find(number, fault).err()).collect()
}

/// Runs the testbench of an emitted folder in Icarus Verilog.
fn testbench(folder: &Path) -> Output {
    let compiled = Command::new("iverilog")
        .args(["-g2005", "-s", "sensor_top_tb", "-o", "bench.vvp"])
        .args(["-f", "sensor_top_tb.f"])
        .current_dir(folder)
        .output()
        .expect("iverilog is needed for this test");
    assert!(compiled.status.success(), "{compiled:?}");
    Command::new("vvp")
        .args(["-n", "bench.vvp"])
        .current_dir(folder)
        .output()
        .expect("vvp is needed for this test")
}

/// Emits the scene, runs its testbench over every fault, and gives how many it
/// missed. A fault that is found ends non-zero and names clock and port.
fn missed_by_the_testbench(scene: &str, faults: &[Fault]) -> usize {
    let work = tempfile::tempdir().unwrap();
    let rtl: PathBuf = work.path().join("rtl");
    let out = rtl.to_str().unwrap();
    let emitted = goldtof(work.path(), &["emit", scene, "--out", out]);
    assert!(emitted.status.success());
    let sound = testbench(&rtl);
    assert!(sound.status.success(), "{sound:?}");
    let missed = missed_by(&planted(faults), |number, fault| {
        let folder = faulty_copy(work.path(), &rtl, fault, number);
        let seen = testbench(&folder);
        let said = String::from_utf8_lossy(&seen.stdout);
        if seen.status.success() {
            assert!(said.contains("PASS"), "{fault:?}: {said}");
            return Err(format!("{fault:?}"));
        }
        assert!(!said.contains("PASS"), "{fault:?}: {said}");
        assert!(said.contains("FAIL clock "), "{fault:?}: {said}");
        assert!(said.contains(" expected "), "{fault:?}: {said}");
        Ok(())
    });
    missed.iter().for_each(|fault| println!("missed: {fault}"));
    missed.len()
}

#[test]
fn the_emitted_testbench_finds_every_fault_of_the_plain_sensor() {
    assert_eq!(missed_by_the_testbench("scenes/quick.toml", QUICK), 0);
}

#[test]
fn the_emitted_testbench_finds_every_fault_of_the_other_sensors() {
    assert_eq!(missed_by_the_testbench("tests/scenes/window.toml", WINDOW), 0);
    let scene = "tests/scenes/window-in-step.toml";
    assert_eq!(missed_by_the_testbench(scene, WINDOW_IN_STEP), 0);
    assert_eq!(missed_by_the_testbench("tests/scenes/peak.toml", PEAK), 0);
    assert_eq!(missed_by_the_testbench("tests/scenes/totals.toml", TOTALS), 0);
    assert_eq!(missed_by_the_testbench("scenes/macropixel.toml", MACROPIXEL), 0);
    assert_eq!(missed_by_the_testbench("tests/scenes/odd-cells.toml", ODD_CELLS), 0);
    assert_eq!(missed_by_the_testbench("tests/scenes/adder.toml", ADDER), 0);
}

#[test]
fn every_fault_in_the_plain_sensor_is_found() {
    all_are_found("scenes/quick.toml", QUICK);
}

#[test]
fn every_fault_in_interleaving_realignment_and_saturation_is_found() {
    all_are_found("tests/scenes/window.toml", WINDOW);
}

#[test]
fn a_scan_that_should_follow_at_once_and_does_not_is_found() {
    all_are_found("tests/scenes/window-in-step.toml", WINDOW_IN_STEP);
}

#[test]
fn every_fault_in_total_counts_is_found() {
    all_are_found("tests/scenes/totals.toml", TOTALS);
}

#[test]
fn every_fault_in_the_peak_detector_is_found() {
    all_are_found("tests/scenes/peak.toml", PEAK);
}

#[test]
fn every_fault_in_registers_and_what_they_set_is_found() {
    all_are_found("tests/scenes/registers.toml", REGISTERS);
}

#[test]
fn every_fault_in_taps_that_a_host_sets_is_found() {
    all_are_found("tests/scenes/taps.toml", TAPS);
}

#[test]
fn every_fault_in_following_a_target_is_found() {
    all_are_found("tests/scenes/tracking-short.toml", TRACKING);
}

#[test]
fn every_fault_in_rows_of_detectors_is_found() {
    all_are_found("tests/scenes/rows.toml", ROWS);
}

#[test]
fn every_fault_in_combining_cells_is_found() {
    all_are_found("scenes/macropixel.toml", MACROPIXEL);
    all_are_found("tests/scenes/odd-cells.toml", ODD_CELLS);
    all_are_found("tests/scenes/adder.toml", ADDER);
}

#[test]
fn every_fault_in_a_histogram_is_found() {
    all_are_found("tests/scenes/histogram.toml", HISTOGRAM);
    all_are_found("tests/scenes/histogram-one-memory.toml", ONE_MEMORY);
}

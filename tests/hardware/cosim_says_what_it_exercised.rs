//! A match on nothing is not a match: what a verdict rests on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use goldtof::reference::adversarial::{Adversarial, LONGEST_DEFAULT, Means};
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::coverage::{CoverPoint, Happening, PeakPoint, RegisterPoint};
use goldtof::reference::exercise::{DetectorExercised, Exercised};
use goldtof::reference::predictor::ReferenceModel;
use goldtof::scene::{self, Registers, Setting};
use goldtof::sensor::interface::Interface;
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;
use optics_support::repeated;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::hdl_support::draw::{self, Extent};
use crate::hdl_support::goldtof_json;

const QUICK: &str = "scenes/quick.toml";
const DARK: &str = "tests/scenes/dark.toml";

/// Runs goldtof: exit status and JSON.
fn goldtof(arguments: &[&str]) -> (Option<i32>, Value) {
    goldtof_json(&[&["--json", "--quiet"], arguments].concat())
}

/// The Verilog of a scene, whose edge detector never sees a hit.
fn dead(folder: &Path, scene: &str) -> PathBuf {
    let rtl = folder.join("dead");
    goldtof(&["emit", scene, "--out", rtl.to_str().unwrap()]);
    let file = rtl.join("edge_detector.v");
    let verilog = fs::read_to_string(&file).unwrap();
    let (sound, dead) = ("o_hits <= pairs;", "o_hits <= 0;");
    assert_eq!(verilog.matches(sound).count(), 1);
    fs::write(&file, verilog.replace(sound, dead)).unwrap();
    rtl
}

#[track_caller]
fn assert_inconclusive(found: &(Option<i32>, Value), missing: &str) {
    let (status, report) = found;
    assert_eq!((status, &report["verdict"]), (&Some(1), &"inconclusive".into()));
    let sentence = report["missing"][0].as_str().unwrap();
    assert!(sentence.contains(missing), "{sentence}");
}

#[test]
fn a_dead_detector_matches_neither_in_the_dark_nor_on_no_result() {
    let folder = tempfile::tempdir().unwrap();
    let rtl = dead(folder.path(), DARK);
    let rtl = rtl.to_str().unwrap();
    let in_the_dark = goldtof(&["cosim", DARK, "--rtl", rtl]);
    assert_inconclusive(&in_the_dark, "no hit of detector spad was counted up or down");
    let exercised = &in_the_dark.1["exercised"];
    assert_eq!(exercised["detectors"][0]["hits_up"], 0);
    assert_eq!(exercised["detectors"][0]["results"], 248);
    assert_eq!(exercised["scan_ends"], 1);
    // The sensor that is sound is no better off.
    let sound = goldtof(&["cosim", DARK]);
    assert_inconclusive(&sound, "`--stimulus adversarial` brings such hits");
    let short =
        goldtof(&["cosim", DARK, "--rtl", rtl, "--stimulus", "adversarial", "--cycles", "100"]);
    assert_inconclusive(&short, "no result of detector spad came to the stream");
    let (status, report) = goldtof(&["cosim", DARK, "--rtl", rtl, "--stimulus", "adversarial"]);
    assert_eq!((status, &report["verdict"]), (Some(1), &"mismatch".into()));
    assert_eq!(report["missing"], serde_json::json!([]));
}

#[test]
fn the_clocks_that_the_sentence_names_are_enough_and_one_fewer_is_not() {
    let (_, report) = goldtof(&["cosim", QUICK, "--cycles", "100"]);
    let sentence = report["missing"][0].as_str().unwrap();
    let clocks = sentence.split_whitespace().rev().find_map(|word| word.parse::<u64>().ok());
    let with = |clocks: u64| goldtof(&["cosim", QUICK, "--cycles", &clocks.to_string()]).1;
    let clocks = clocks.unwrap();
    assert_eq!(with(clocks)["verdict"], "match");
    assert_eq!(with(clocks)["exercised"]["results_taken"], 1);
    assert_eq!(with(clocks - 1)["verdict"], "inconclusive");
}

#[test]
fn a_run_in_the_dark_and_one_with_a_dark_detector_are_inconclusive() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (status, report) = goldtof(&["run", DARK, "--out", out.to_str().unwrap()]);
    assert_inconclusive(&(status, report["cosim"].clone()), "no hit of detector spad");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("verdict inconclusive") && page.contains("no hit of detector spad"));
    assert!(!out.join("mismatch.vcd").exists());
    let simulated = goldtof(&["simulate", DARK, "--fidelity", "rtl", "--repeat", "2"]).1;
    let warnings = simulated["warnings"].to_string();
    assert!(warnings.contains("no hit of detector spad"), "{warnings}");

    let text = fs::read_to_string(QUICK).unwrap();
    let start = text.find("[[detector]]").unwrap();
    let end = text.find("[[path]]").unwrap();
    let second = text[start..end].replace("\"spad\"", "\"second\"").replace("71 kcps", "0 cps");
    let scene = folder.path().join("two.toml");
    fs::write(&scene, format!("{text}\n{second}")).unwrap();
    let two = goldtof(&["cosim", scene.to_str().unwrap(), "--cycles", "40000"]);
    assert_inconclusive(&two, "no hit of detector second was counted up or down");
    assert_eq!(two.1["missing"].as_array().unwrap().len(), 1);
    assert!(two.1["exercised"]["detectors"][0]["hits_down"].as_u64() > Some(0));
}

/// What the ports show, clock by clock: of the definition in docs/conventions.md and nothing
/// else.
#[derive(Default)]
struct Watcher {
    seen: Exercised,
    in_reset: bool,
    valid: bool,
    held: bool,
    overrun: bool,
    /// Bits above the count's in a word.
    unused_bits: u32,
    sum: i64,
}

impl Watcher {
    /// Inputs and outputs of a clock; `port` reads one of either.
    fn clock(&mut self, port: impl Fn(&str) -> u64) {
        let is_high = |name| port(name) == 1;
        let takes = is_high("m_axis_tready") && self.valid;
        self.seen.resets += u64::from(is_high("i_rst") && !self.in_reset);
        self.in_reset = is_high("i_rst");
        if !self.in_reset {
            self.seen.results_taken += u64::from(takes);
            self.seen.stalls += u64::from(self.valid && !takes && !self.held);
            self.held = self.valid && !takes;
        }
        let valid = is_high("m_axis_tvalid");
        if valid && (takes || !self.valid) && !self.in_reset {
            self.seen.scan_ends += port("m_axis_tlast");
            self.seen.detectors[0].results += 1;
            let raised = port("m_axis_tdata") << self.unused_bits;
            self.sum += raised.cast_signed() >> self.unused_bits;
            self.held = false;
        }
        self.valid = valid;
        let overrun = is_high("o_overrun");
        self.overrun |= overrun;
    }
}

#[test]
fn what_is_counted_is_what_the_ports_show() {
    let scene = scene::load(Path::new("tests/scenes/window-in-step.toml")).unwrap();
    let interface = Interface::of(&scene);
    let layout = Layout::of(&interface);
    // The hits cannot be told from saturated counts.
    assert!(!interface.saturates() && interface.total().is_none());
    let mut reference = ReferenceModel::new(interface.clone()).unwrap();
    let mut adversary = Adversarial::new(&interface, 3);
    let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, 60_000);
    let mut watcher = Watcher {
        unused_bits: u64::BITS - layout.outputs.field(PortRole::Data).port.width,
        ..Watcher::default()
    };
    watcher.seen.detectors = vec![DetectorExercised::default()];
    let mut block = Block::default();
    while maker.make(&mut block) {
        let inputs = block.records.inputs.chunks_exact(layout.inputs.words);
        let outputs = block.records.expected.chunks_exact(layout.outputs.words);
        for (input, output) in inputs.zip(outputs) {
            watcher.clock(|name| match layout.inputs.fields.iter().find(|f| f.port.name == name) {
                Some(field) => field.low_word(input),
                None => layout.outputs.field(PortRole::of(name).unwrap()).low_word(output),
            });
        }
    }
    let counted = block.exercise;
    let DetectorExercised { results, hits_up, hits_down, .. } = counted.detectors[0];
    assert_eq!(results, watcher.seen.detectors[0].results);
    assert_eq!(hits_up.cast_signed() - hits_down.cast_signed(), watcher.sum);
    let of = |e: &Exercised| [e.results_taken, e.stalls, e.scan_ends, e.resets];
    assert_eq!(of(&counted), of(&watcher.seen));
    assert_eq!(counted.overruns > 0, watcher.overrun);
    // All of it happened, and more than once.
    let each = [hits_up, hits_down, counted.overruns, counted.overruns];
    assert!(of(&counted).iter().chain(&each).all(|&number| number > 1), "{counted:?}");
}

#[test]
fn a_testbench_of_long_steps_shortens_them_and_without_that_is_inconclusive() {
    let folder = tempfile::tempdir().unwrap();
    let long = folder.path().join("long.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    fs::write(&long, text.replace("integration = \"20 us\"", "integration = \"1 ms\"")).unwrap();
    let out = folder.path().join("out");
    let (_, emitted) = goldtof(&["emit", long.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(emitted["testbench"]["hits_up"].as_u64() > Some(0));
    assert!(emitted["testbench"]["clocks"].as_u64() <= Some(100_000));
    // The macro is for designs without the counters: nothing is shortened.
    for (macros, ending) in [(None, "PASS"), (Some("-DSENSOR_TOP_TB_WHOLE"), "INCONCLUSIVE")] {
        let run = |program: &str, arguments: &[&str]| {
            let run = Command::new(program).args(arguments).current_dir(&out).output();
            run.expect("Icarus Verilog is needed for this test")
        };
        let mut compile = vec!["-g2005", "-s", "sensor_top_tb", "-o", "tb.vvp"];
        compile.extend(macros);
        compile.extend(["-f", "sensor_top_tb.f"]);
        assert!(run("iverilog", &compile).status.success());
        let output = run("vvp", &["-n", "tb.vvp"]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.success(), macros.is_none(), "{said}");
        assert!(said.contains(ending), "{said}");
        assert_eq!(said.contains("PASS"), macros.is_none(), "{said}");
    }
}

#[test]
fn what_a_stream_holds_without_tvalid_is_the_designs_own_business() {
    let folder = tempfile::tempdir().unwrap();
    let rtl = folder.path().join("rtl");
    let out = rtl.to_str().unwrap();
    goldtof(&["emit", QUICK, "--out", out]);
    let file = rtl.join("result_stream.v");
    let verilog = fs::read_to_string(&file).unwrap();
    let held = "o_data = {count_r[14], count_r};";
    assert_eq!(verilog.matches(held).count(), 1);
    for (data, verdict) in [
        ("o_valid ? {count_r[14], count_r} : 16'hdead;", "match"),
        ("o_valid & i_ready ? {count_r[14], count_r} : 16'hdead;", "mismatch"),
    ] {
        fs::write(&file, verilog.replace(held, &format!("o_data = {data}"))).unwrap();
        let arguments = ["cosim", QUICK, "--rtl", out, "--stimulus", "adversarial"];
        let (_, report) = goldtof(&arguments);
        assert_eq!(report["verdict"], verdict, "{data}");
        if verdict == "mismatch" {
            assert_eq!(report["first_mismatch"]["port"], "m_axis_tdata");
        }
    }
}

/// The cover points that hostile inputs leave out, and their clocks.
fn left_out(interface: &Interface, means: Means) -> (Vec<CoverPoint>, u64) {
    let layout = Layout::of(interface);
    let mut reference = ReferenceModel::new(interface.clone()).unwrap();
    let points = reference.cover_table().points().to_vec();
    let mut adversary = Adversarial::with_means(interface, 1, means).unwrap();
    let clocks = adversary.clone().clocks_to_cover(LONGEST_DEFAULT);
    let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, clocks);
    let mut block = Block::default();
    while maker.make(&mut block) {}
    let covered = &block.exercise.covered;
    let missed = (0..points.len()).filter(|&number| !covered.contains(number));
    (missed.map(|number| points[number]).collect(), clocks)
}

#[test]
fn every_cover_point_is_reached_where_steps_and_scans_can_be_shortened() {
    for file in [
        "scenes/quick.toml",
        "scenes/paper-single.toml",
        "scenes/paper-square.toml",
        "scenes/paper-interleaved.toml",
        "scenes/dual-view.toml",
        "scenes/multipath.toml",
        "scenes/moving.toml",
        "tests/scenes/window.toml",
        "tests/scenes/window-in-step.toml",
        "tests/scenes/peak.toml",
        "tests/scenes/totals.toml",
        "tests/scenes/histogram.toml",
        "tests/scenes/histogram-one-memory.toml",
        "tests/scenes/registers.toml",
        // A scan that takes longer than any stall.
        "tests/scenes/registers.toml source[0].code.degree=9 source[1].code.degree=9",
        "tests/scenes/taps.toml",
        "tests/scenes/tracking-short.toml",
    ] {
        let mut words = file.split(' ');
        let path = Path::new(words.next().unwrap());
        let settings: Vec<Setting> = words.map(|setting| setting.parse().unwrap()).collect();
        let scene = scene::load_with(path, &settings).unwrap();
        let interface = Interface::of(&scene);
        let means = Means::cosim(true);
        let (missed, clocks) = left_out(&interface, means);
        // Of the number of scans the highest bits alone are out of reach.
        let is_hindered = |&point: &CoverPoint| {
            matches!(point.what, Happening::Registers(RegisterPoint::ScansCounted { bit: 8.. }))
                && Adversarial::hindrance(&interface, means, point).is_some()
        };
        assert!(missed.iter().all(is_hindered), "{file}: {missed:?}");
        assert!(clocks < 2_000_000, "{file}: {clocks}");
    }
}

/// Of twelve scenes none, and of two hundred one in ten, which have many correlators, or windows by chance.
#[test]
fn of_random_scenes_hardly_any_cover_point_is_missed_without_a_reason() {
    let scenes = repeated(12, 200);
    let missed: Vec<_> = (0..scenes)
        .into_par_iter()
        .filter_map(|number| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(7_000 + number);
            let registers = [Registers::None, Registers::Axi4Lite][number as usize % 2];
            let (scene, _) = draw::emitted_with(&mut rng, Extent::SHORT, registers, |_| ());
            let interface = Interface::of(&scene);
            // Of shorter steps groups are lost whatever the receiver does.
            if scene.scan.integration_chips < interface.beats_of_group().max(16) {
                return None;
            }
            let means = Means::cosim(true);
            let (mut missed, _) = left_out(&interface, means);
            missed.retain(|&point| Adversarial::hindrance(&interface, means, point).is_none());
            // Whether hits make the counts of many steps negative at once depends on the code.
            let negative = Happening::Peaks(PeakPoint::Negative);
            missed.retain(|point| interface.parallel() == 1 || point.what != negative);
            (!missed.is_empty()).then_some((number, missed))
        })
        .collect();
    assert!(10 * missed.len() as u64 <= scenes - 12, "{missed:?}");
}

#[test]
fn without_that_what_is_not_reached_is_said_to_be_too_far_away() {
    for file in ["scenes/paper-single.toml", "tests/scenes/window.toml", "tests/scenes/totals.toml"]
    {
        let means = Means::cosim(false);
        let interface = Interface::of(&scene::load(Path::new(file)).unwrap());
        for point in left_out(&interface, means).0 {
            let hindrance = Adversarial::hindrance(&interface, means, point);
            assert!(hindrance.is_some(), "{file}: {point:?}");
        }
    }
}

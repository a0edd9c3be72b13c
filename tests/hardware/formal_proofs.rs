//! The emitted proofs hold for a design with every part and for histograms, and refuse faults in them.

use goldtof::scene::{self, SourceIndex};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use goldtof::deliver::{Emission, emit, write};
use goldtof::sensor::Sensor;
use optics_support::{repeated, some_of_each};
use tempfile::TempDir;

use crate::hdl_support::{self, Family, code};
use crate::histograms;

/// Two detectors, four steps at once with a last group of two, nu = 2, a window,
/// a peak detector, a narrow counter and totals.
fn rich() -> Emission {
    let codes = [code(Family::Gold(5), 2, 3), code(Family::Gold(5), 2, 5)];
    let mut scene = hdl_support::scene(&codes, 0, 4, 118, Some(22), 375, Some(6));
    let mut other = scene.detectors[0].clone();
    other.name = "other".into();
    other.reference = SourceIndex(1);
    scene.detectors.push(other);
    scene.hardware.parallel = 4;
    scene.hardware.peak_detector = true;
    scene.hardware.total_counts = Some(true);
    emit(&Sensor::new(&scene), "goldtof emit rich.toml").expect("the scene is fine")
}

/// What sby says of a task: `PASS`, `FAIL`, or what went wrong.
fn verdict(folder: &Path, task: &str) -> String {
    verdict_in(&output(folder, &[task]), task)
}

/// The same of one of several tasks.
fn verdict_in(said: &str, task: &str) -> String {
    let done = said.split_once(&format!("sensor_top_{task}] DONE (")).map(|(_, rest)| rest);
    match done.and_then(|rest| rest.split_once(',')) {
        Some((verdict @ ("PASS" | "FAIL"), _)) => verdict.to_owned(),
        _ => said.to_owned(),
    }
}

/// That sby says `PASS` of all these tasks, and `FAIL` of the others.
fn assert_verdicts(folder: &Path, passing: &[&str], failing: &[&str]) {
    let said = output(folder, &[passing, failing].concat());
    for (tasks, verdict) in [(passing, "PASS"), (failing, "FAIL")] {
        for task in tasks {
            assert_eq!(verdict_in(&said, task), verdict, "{task}");
        }
    }
}

/// The clock after the proof's beginning at which sby's counterexample of a task ends.
fn frame_of_counterexample(folder: &Path, task: &str) -> u32 {
    let said = output(folder, &[task]);
    let rest = said.split_once("was asserted in frame ").map(|(_, rest)| rest);
    let frame = rest.and_then(|rest| rest.split_once('.')?.0.parse().ok());
    frame.unwrap_or_else(|| panic!("{task} shows no counterexample: {said}"))
}

/// All that sby prints of tasks, which it does side by side.
fn output(folder: &Path, tasks: &[&str]) -> String {
    let output = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/sby"))
        .args(["-f", "formal/sensor_top.sby"])
        .args(tasks)
        .env("CARGO_TARGET_DIR", concat!(env!("CARGO_TARGET_TMPDIR"), "/.."))
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("scripts/sby is there");
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn every_proof_holds_for_a_design_with_every_part() {
    let emission = rich();
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&emission, folder.path()).expect("the files can be written");
    assert_eq!(emission.formal.proofs.len(), 8);
    // The search for a wrong peak is scripts/formal's.
    let proofs: Vec<&str> =
        emission.formal.proofs.iter().copied().filter(|&task| task != "peak").collect();
    // What they are about can be: sby shows how where a task says that it cannot.
    assert_eq!(emission.formal.covers.len(), 7);
    let covers = ["scan_cover", "stream_cover", "axis_cover"];
    for task in covers {
        assert!(emission.formal.covers.iter().any(|cover| cover == task), "{task}");
    }
    assert_verdicts(folder.path(), &proofs, &covers);
}

/// The slave's rules, settings that are steady, codes as they are set, and what does not depend on who sets the scan.
#[test]
fn registers_are_proven_and_faults_in_them_refused() {
    let emission = of_file("registers");
    assert_eq!(
        emission.formal.proofs,
        ["reset", "codes", "registers", "counts", "stream", "peak", "axis"]
    );
    let faults: &[Fault] = &[
        ("registers", "register_file", " | (s_axil_bvalid & ~s_axil_bready)", ""),
        ("registers", "register_file", "& ~s_axil_awready & ~s_axil_bvalid", "& ~s_axil_awready"),
        ("registers", "register_file", "& ~s_axil_arready & ~s_axil_rvalid", "& ~s_axil_arready"),
        ("registers", "scan_sequencer", "i_go & ~o_on & ~taking_r", "i_go & ~taking_r"),
        ("codes", "gold_generator", "v_r <= i_seed", "v_r <= V_LOAD"),
        ("codes", "gold_generator", "V_TAPS = 5'h0f", "V_TAPS = 5'h0d"),
        ("codes", "sensor_top", "transmit_epoch[0] & sequencer_on", "transmit_epoch[0]"),
    ];
    let proofs = ["reset", "codes", "registers", "stream", "axis"];
    assert_refused(&emission, &proofs, &["codes_cover", "registers_cover"], faults);
}

/// A window has settings of its own, which are as steady.
#[test]
fn registers_are_proven_where_a_target_is_followed() {
    let emission = of_file("tracking-short");
    let proofs = ["reset", "codes", "registers", "stream", "axis"];
    assert_refused(&emission, &proofs, &["registers_cover"], &[]);
}

/// Any taps, of any period, in codes of two LFSRs and of one.
#[test]
fn codes_of_any_taps_are_proven_and_faults_in_them_refused() {
    let faults: &[Fault] = &[
        ("codes", "gold_generator", "last_r <= u_r == U_LAST", "last_r <= 1'b0"),
        ("codes", "m_sequence_generator", "^(v_r & taps)", "^(v_r & U_TAPS)"),
        ("codes", "m_sequence_generator", "o_chip = v_r[0]", "o_chip = v_r[0] ^ u_r[0]"),
        ("codes", "interleaver", "i_load) subchip_r", "1'b0) subchip_r"),
    ];
    assert_refused(&of_file("taps"), &["reset", "codes"], &["codes_cover"], faults);
}

/// A scene of the tests with registers, emitted.
fn of_file(name: &str) -> Emission {
    let scene = scene::load(&Path::new("tests/scenes").join(name).with_extension("toml"));
    emit(&Sensor::new(&scene.expect("it is sound")), "goldtof emit").expect("it is fine")
}

/// Proofs and covers of a design that hold, and each fault, whose proof does not.
fn assert_refused(emission: &Emission, proofs: &[&str], covers: &[&str], faults: &[Fault]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(emission, folder.path()).expect("the files can be written");
    assert_verdicts(folder.path(), proofs, covers);
    for (task, module, from, to) in some_of_each(faults, |fault| fault.0) {
        let path = folder.path().join(format!("{module}.v"));
        let text = fs::read_to_string(&path).expect("it was written");
        assert_eq!(text.matches(from).count(), 1, "{module}: {from}");
        fs::write(&path, text.replace(from, to)).expect("it can be written");
        assert_eq!(verdict(folder.path(), task), "FAIL", "{from}");
        fs::write(&path, text).expect("it can be written");
    }
}

/// What of a row of detectors is not in its memories: codes, scan and the references that detectors
/// share.
#[test]
fn rows_of_detectors_have_the_references_of_their_codes() {
    let scene = scene::load(Path::new("tests/scenes/rows.toml")).expect("it is sound");
    let emission = emit(&Sensor::new(&scene), "goldtof emit rows.toml").expect("it is fine");
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&emission, folder.path()).expect("the files can be written");
    assert_eq!(emission.formal.proofs, ["reset", "codes", "scan", "reference", "axis"]);
    assert_verdicts(folder.path(), &emission.formal.proofs, &[]);
    for (file, from, to, task) in [
        ("scan_controller.v", "o_dump = step_done_r[2]", "o_dump = step_done_r[3]", "scan"),
        ("lane_delay.v", "{delayed_r[1:0], 1'b1}", "{delayed_r[1:0], 1'b0}", "reference"),
    ] {
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).expect("it was written");
        assert_eq!(text.matches(from).count(), 1, "{file}: {from}");
        fs::write(&path, text.replace(from, to)).expect("it can be written");
        assert_eq!(verdict(folder.path(), task), "FAIL", "{from}");
        fs::write(&path, text).expect("it can be written");
    }
}

/// In a pause the counters stand where the next step begins, and in no other state.
#[test]
fn steps_of_scans_that_wait_for_an_epoch_are_proven() {
    let emission = standard("moving");
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&emission, folder.path()).expect("the files can be written");
    assert_verdicts(folder.path(), &["scan", "reference"], &[]);
}

/// A proof, a module, and an edit of it.
type Fault = (&'static str, &'static str, &'static str, &'static str);

const FAULTS: &[Fault] = &[
    // Registers that one clock of reset leaves as they are.
    ("reset", "updown_correlator", "} <= 0;", "} <= 0; sum_r <= sum_r;"),
    ("codes", "gold_generator", "u_r == U_LAST", "u_r == U_LOAD"),
    ("scan", "scan_controller", "o_dump = step_done_r[3]", "o_dump = step_done_r[4]"),
    // Seen at the ports after a scan, or after hundreds of chips.
    ("scan", "scan_controller", "if (scan_last_chip_r) begin", "if (1'b0) begin"),
    ("scan", "scan_controller", "CHIP_COUNT_END   = 9'h1eb", "CHIP_COUNT_END   = 9'h0f5"),
    ("reference", "lane_delay", "{4{i_chips[1]}}", "{4{i_chips[0]}}"),
    ("counts", "detector_channel", "clamp_clamped[0] | total_clamped", "clamp_clamped[0]"),
    // Edges at word borders, and hits outside a scan.
    ("counts", "edge_detector", "{i_samples[2:0], last_sample_r}", "{i_samples[2:0], 1'b0}"),
    ("counts", "edge_detector", " & {4{i_run}}", ""),
    ("stream", "result_stream", "(~i_last & (|i_clamped))", "(|i_clamped)"),
    ("axis", "result_stream", "o_valid <= i_counted | blocked", "o_valid <= i_counted | more_r"),
];

/// Counts that a step takes long to come to: refused from a count that has come there, and not by
/// counting.
const FAULTS_OF_LARGE_COUNTS: &[Fault] = &[
    ("counts", "count_clamp", "{5{~i_count[10]}}", "5'h1f"),
    ("counts", "hit_counter", "exact[5:0] | {6{o_clamped}}", "exact[5:0]"),
];

/// The same for one step at once, whose delay grows to a whole chip over several steps.
const FAULTS_OF_SINGLE_STEPS: &[Fault] = &[
    ("reference", "lane_delay", "{delayed_r[5:0], 1'b1}", "{1'b0, delayed_r[4:0], 1'b1}"),
    ("reference", "lane_delay", "delayed_r <= 7'd0;", "delayed_r <= 7'd1;"),
    ("reference", "chip_history", "o_advance = ~i_wrap", "o_advance = 1'b1"),
];

#[test]
fn each_proof_refuses_a_fault() {
    each_is_refused(&rich(), FAULTS);
    each_is_refused(&standard("quick"), FAULTS_OF_SINGLE_STEPS);
}

/// Cells with an input each: any pulses of any of them.
#[test]
fn counts_of_cells_are_proven_and_faults_in_combining_them_refused() {
    let faults: &[Fault] = &[
        ("counts", "cell_combiner", "= sum_1 | carry_2", "= sum_1"),
        ("counts", "cell_combiner", "{sum_0, i_samples[15:12]}", "{sum_0, 4'd0}"),
    ];
    assert_refused(&standard("macropixel"), &["counts"], &[], faults);
    let faults: &[Fault] = &[
        ("counts", "cell_combiner", "i_samples[3:2] ^ i_samples[5:4]", "i_samples[3:2]"),
        ("counts", "sensor_top", "pulses[6*g +: 6]", "pulses[0 +: 6]"),
    ];
    assert_refused(&of_file("odd-cells"), &["counts"], &[], faults);
}

#[test]
#[ignore = "half a minute"]
fn counts_of_added_cells_are_proven_and_faults_in_adding_them_refused() {
    let faults: &[Fault] = &[
        (
            "counts",
            "updown_correlator",
            "quad_sum[3:0] + quad_sum[7:4]",
            "quad_sum[3:0] | quad_sum[7:4]",
        ),
        ("counts", "edge_detector", "last_samples_r[2]", "last_samples_r[1]"),
        ("counts", "hit_counter", "{2'd0, hit_r[5:4]}", "{3'd0, hit_r[4]}"),
    ];
    assert_refused(&of_file("adder"), &["counts"], &[], faults);
}

#[test]
fn a_fault_of_large_counts_shows_without_counting_to_them() {
    for fault in some_of_each(FAULTS_OF_LARGE_COUNTS, |fault| fault.0) {
        let folder = with_fault(&rich(), fault);
        let frame = frame_of_counterexample(folder.path(), fault.0);
        assert!(frame < 4, "{fault:?}: {frame}");
    }
}

/// What is emitted for a standard scene.
fn standard(name: &str) -> Emission {
    let path = format!("{}/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let scene = scene::load(Path::new(&path)).expect("a standard scene is sound");
    emit(&Sensor::new(&scene), "goldtof emit scene.toml").expect("it can be built")
}

fn each_is_refused(emission: &Emission, faults: &[Fault]) {
    for fault in some_of_each(faults, |fault| fault.0) {
        let folder = with_fault(emission, fault);
        let &(task, _, from, _) = fault;
        assert_eq!(verdict(folder.path(), task), "FAIL", "{task}: {from}");
    }
}

/// A folder with the design and a fault in it.
fn with_fault(emission: &Emission, &(_, module, from, to): &Fault) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(emission, folder.path()).expect("the files can be written");
    let path = folder.path().join(format!("{module}.v"));
    let sound = fs::read_to_string(&path).expect("the module is there");
    let faulty = sound.replacen(from, to, 1);
    assert!(faulty != sound, "{module} has no {from}");
    fs::write(&path, faulty).expect("the module can be written");
    folder
}

/// What is emitted for the histogram of this name.
fn histogram(name: &str) -> Emission {
    let scenes = histograms::scenes();
    let (_, scene) =
        scenes.iter().find(|(other, _)| *other == name).expect("there is one of this name");
    emit(&Sensor::new(scene), "goldtof emit histogram.toml").expect("the scene is fine")
}

#[test]
fn every_proof_holds_for_histograms() {
    let names = [
        "two detectors",
        "one memory, bins that saturate",
        "the widest row",
        "one memory, a code period",
    ];
    for name in &names[..repeated(2, 4) as usize] {
        let emission = histogram(name);
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(&emission, folder.path()).expect("the files can be written");
        assert_eq!(emission.formal.proofs, ["reset", "codes", "scan", "stream", "axis"]);
        assert_verdicts(folder.path(), &emission.formal.proofs, &["stream_cover"]);
    }
}

/// The same for a histogram of two detectors.
const FAULTS_OF_HISTOGRAMS: &[Fault] = &[
    ("reset", "bin_adder", "} <= 0;", "} <= 0; above_r <= above_r;"),
    ("reset", "bin_bank", "} <= 0;", "} <= 0; writes_r <= writes_r;"),
    ("reset", "histogram_control", "} <= 0;", "} <= 0; out_r <= out_r;"),
    ("codes", "gold_generator", "u_r == U_LAST", "u_r == U_LOAD"),
    // A frame a code period short, a row too early, and a loss that is not told in one state of
    // the reader.
    ("scan", "histogram_control", "FIRST_PERIOD     = 2'd1", "FIRST_PERIOD     = 2'd2"),
    ("scan", "histogram_control", "= row_before_r[29:25]", "= row_before_r[24:20]"),
    ("stream", "histogram_control", "ends & busy)", "ends & busy & ~(reads_r & read_is_last_r))"),
    ("stream", "histogram_control", "room_r <= 1'b1;", "room_r <= room_r;"),
];

/// The same for one memory.
const FAULTS_OF_ONE_MEMORY: &[Fault] =
    &[("stream", "histogram_control", "~i_ready)", "~i_ready & row_before_r[14:10] != 5'd17)")];

#[test]
fn each_proof_refuses_a_fault_in_a_histogram() {
    each_is_refused(&histogram("two detectors"), FAULTS_OF_HISTOGRAMS);
    each_is_refused(&histogram("one memory, bins that saturate"), FAULTS_OF_ONE_MEMORY);
}

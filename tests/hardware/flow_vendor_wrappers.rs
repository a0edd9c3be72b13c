//! The wrappers of hdl/ fit the emitted core and the vendors' cells, as Yosys
//! knows them; the order of samples is checked where there is a model of the pin.

use std::fs;
use std::path::Path;

use crate::hdl_support::{Family, code, run, scene};
use goldtof::hdl::{emit, write};

/// Wrapper sources of a family.
fn wrappers(family: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("hdl")
        .join(family);
    let mut files: Vec<String> = fs::read_dir(&folder)
        .expect("the wrappers are there")
        .map(|entry| entry.expect("readable").path().display().to_string())
        .filter(|name| name.ends_with(".v"))
        .collect();
    files.sort();
    files
}

/// Synthesizes the board example round a core with `lanes` samples per chip and
/// gives Yosys' count of its cells.
fn synthesized(family: &str, command: &str, lanes: u32) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = scene(
        &[code(Family::Gold(5), 0, 3)],
        0,
        lanes,
        0,
        None,
        13_100,
        None,
    );
    let emission = emit(&scene, "goldtof emit board.toml").expect("the scene is fine");
    write(&emission, folder.path()).expect("the files can be written");
    let design: Vec<&str> = emission.files.iter().map(|f| f.name.as_str()).collect();
    let tdata = emission
        .ports
        .iter()
        .find(|port| port.name == "m_axis_tdata");
    let script = format!(
        "read_verilog {} {}; chparam -set W_TDATA {} {family}_board; \
         {command} -top {family}_board; check -assert; tee -q -o cells.txt stat",
        design.join(" "),
        wrappers(family).join(" "),
        tdata.expect("every core has it").width,
    );
    let said = run(folder.path(), "yosys", &["-q", "-p", &script]);
    assert_eq!(said, "", "{family}");
    fs::read_to_string(folder.path().join("cells.txt")).expect("the cells were counted")
}

fn cells(report: &str, cell: &str) -> u32 {
    report
        .lines()
        .filter_map(|line| line.trim().strip_prefix(cell)?.trim().parse().ok())
        .next_back()
        .unwrap_or(0)
}

#[test]
fn the_ecp5_board_has_one_gear_for_each_pin() {
    let report = synthesized("ecp5", "synth_ecp5", 4);
    for cell in ["IDDRX2F ", "ODDRX1F ", "CLKDIVF ", "ECLKSYNCB "] {
        assert_eq!(cells(&report, cell), 1, "{cell}\n{report}");
    }
}

#[test]
fn the_7_series_board_has_one_deserializer() {
    let report = synthesized("xc7", "synth_xilinx", 8);
    for cell in ["ISERDESE2 ", "BUFIO ", "BUFR "] {
        assert_eq!(cells(&report, cell), 1, "{cell}\n{report}");
    }
}

#[test]
fn the_ice40_board_has_one_cell_for_each_pin() {
    let report = synthesized("ice40", "synth_ice40", 2);
    assert_eq!(cells(&report, "SB_IO "), 2, "{report}");
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
    let bench = format!(
        "module bench;
    reg clk, pin;
    wire [1:0] samples;
    ice40_sampler dut (.i_clk(clk), .i_pin(pin), .o_samples(samples));
    always @(posedge clk) #1 $display(\"%b\", samples);
    initial begin
        clk = 1'b0;
        #2;
{drive}        #1 clk = 1'b1; #2 $finish;
    end
endmodule
"
    );
    fs::write(folder.path().join("bench.v"), bench).expect("the bench can be written");
    // Yosys says where it keeps the model of the pin.
    let said = run(
        folder.path(),
        "yosys",
        &["-p", "read_verilog -lib +/ice40/cells_sim.v"],
    );
    let cells = said
        .split(['`', '\''])
        .find(|part| part.starts_with('/') && part.ends_with("cells_sim.v"))
        .unwrap_or_else(|| panic!("{said}"));
    let sampler = wrappers("ice40")
        .into_iter()
        .find(|file| file.ends_with("ice40_sampler.v"))
        .expect("it is there");
    let mut arguments = vec!["-g2012", "-DNO_ICE40_DEFAULT_ASSIGNMENTS", "-s", "bench"];
    arguments.extend(["-o", "bench.vvp", "bench.v", &sampler, cells]);
    run(folder.path(), "iverilog", &arguments);
    let said = run(folder.path(), "vvp", &["-n", "bench.vvp"]);
    let seen: Vec<&str> = said.lines().collect();
    let expected: Vec<String> = levels
        .chunks_exact(2)
        .map(|pair| format!("{}{}", pair[1], pair[0]))
        .collect();
    // A word is there one clock after its pair.
    assert_eq!(seen[1..=expected.len()], expected);
}

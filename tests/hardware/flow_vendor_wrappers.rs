//! The wrappers of hdl/ fit the emitted core and the vendors' cells, as Yosys
//! knows them; the order of samples is checked where there is a model of the pin.

use std::fs;
use std::path::Path;

use crate::hdl_support::{Family, code, run, scene};
use goldtof::deliver::{emit, write};
use goldtof::sensor::Sensor;

/// Wrapper sources of a family.
fn wrappers(family: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("hdl").join(family);
    let mut files: Vec<String> = fs::read_dir(&folder)
        .expect("the wrappers are there")
        .map(|entry| entry.expect("readable").path().display().to_string())
        .filter(|name| name.ends_with(".v"))
        .collect();
    files.sort();
    files
}

/// The files of a core with `lanes` samples per chip and a code of 31 chips, in a
/// folder of its own; their names.
fn core(folder: &Path, lanes: u32) -> Vec<String> {
    let codes = [code(Family::Gold(5), 0, 3)];
    let scene = scene(&codes, 0, lanes, 0, None, 13_100, None);
    let emission =
        emit(&Sensor::new(&scene), "goldtof emit board.toml").expect("the scene is fine");
    write(&emission, folder).expect("the files can be written");
    emission.files.into_iter().map(|file| file.name).collect()
}

/// Reads the board example of a family round the core in Yosys' own folder.
fn read_board(family: &str, core: &[String]) -> String {
    format!("read_verilog {} {}", core.join(" "), wrappers(family).join(" "))
}

/// Synthesizes the board example round a core with `lanes` samples per chip and
/// gives Yosys' count of its cells.
fn synthesized(family: &str, command: &str, lanes: u32) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = format!(
        "{}; {command} -top {family}_board; check -assert; tee -q -o cells.txt stat",
        read_board(family, &core(folder.path(), lanes)),
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
    let testbench = format!(
        "module testbench;
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
    fs::write(folder.path().join("bench.v"), testbench).expect("the testbench can be written");
    let cells = ice40_cells(folder.path());
    let sampler = wrappers("ice40")
        .into_iter()
        .find(|file| file.ends_with("ice40_sampler.v"))
        .expect("it is there");
    let mut arguments = vec!["-g2012", "-DNO_ICE40_DEFAULT_ASSIGNMENTS", "-s", "testbench"];
    arguments.extend(["-o", "bench.vvp", "bench.v", &sampler, &cells]);
    run(folder.path(), "iverilog", &arguments);
    let said = run(folder.path(), "vvp", &["-n", "bench.vvp"]);
    let seen: Vec<&str> = said.lines().collect();
    let expected: Vec<String> =
        levels.chunks_exact(2).map(|pair| format!("{}{}", pair[1], pair[0])).collect();
    // A word is there one clock after its pair.
    assert_eq!(seen[1..=expected.len()], expected);
}

/// Where Yosys keeps its models of iCE40's cells.
fn ice40_cells(folder: &Path) -> String {
    let said = run(folder, "yosys", &["-p", "read_verilog -lib +/ice40/cells_sim.v"]);
    let cells =
        said.split(['`', '\'']).find(|part| part.starts_with('/') && part.ends_with("cells_sim.v"));
    cells.unwrap_or_else(|| panic!("{said}")).to_owned()
}

/// The vendors' cells as far as clocks and levels go: what their pins' gears do to
/// samples does not matter here.
const CELLS: &str = "
module ECLKSYNCB (input ECLKI, STOP, output ECLKO); assign ECLKO = ECLKI; endmodule
module CLKDIVF #(parameter DIV = \"2.0\") (input CLKI, RST, ALIGNWD, output reg CDIVX);
    initial CDIVX = 0; always @(posedge CLKI) CDIVX <= ~CDIVX;
endmodule
module IDDRX2F (input D, SCLK, ECLK, RST, ALIGNWD, output Q0, Q1, Q2, Q3);
    assign {Q0, Q1, Q2, Q3} = {4{D}};
endmodule
module ODDRX1F (input SCLK, RST, D0, D1, output Q); assign Q = D0; endmodule
module IBUF (input I, output O); assign O = I; endmodule
module OBUF (input I, output O); assign O = I; endmodule
module BUFIO (input I, output O); assign O = I; endmodule
module BUFR #(parameter BUFR_DIVIDE = \"4\") (input I, CE, CLR, output O);
    reg [1:0] count = 0; always @(posedge I) count <= count + 1; assign O = count[1];
endmodule
module ISERDESE2 #(parameter DATA_RATE = \"\", DATA_WIDTH = 8, INTERFACE_TYPE = \"\", IOBDELAY = \"\",
    IS_CLKB_INVERTED = 0, NUM_CE = 1, SERDES_MODE = \"\") (input D, DDLY, CLK, CLKB, CLKDIV, CLKDIVP,
    OCLK, OCLKB, RST, CE1, CE2, BITSLIP, DYNCLKDIVSEL, DYNCLKSEL, OFB, SHIFTIN1, SHIFTIN2,
    output O, SHIFTOUT1, SHIFTOUT2, Q1, Q2, Q3, Q4, Q5, Q6, Q7, Q8);
    assign {Q1, Q2, Q3, Q4, Q5, Q6, Q7, Q8} = {8{D}};
endmodule
";

/// A testbench that never raises reset: the code's epoch has to come once every 31
/// chips, with chips of both kinds between, from soon after power-up on.
fn never_reset(family: &str, clock: &str) -> String {
    format!(
        "module testbench;
    reg pin_clk = 0;
    integer chips = 0, ones = 0, epochs = 0, last = -1;
    wire clk, laser, epoch;
    {family}_board board (.{clock}(pin_clk), .i_rst(1'b0), .i_spad(1'b0), .o_laser(laser),
        .o_clk(clk), .m_axis_tready(1'b1), .o_epoch(epoch));
    always #1 pin_clk = ~pin_clk;
    always @(posedge clk) begin
        chips <= chips + 1;
        if (chips > 8) begin
            if (laser === 1'b1) ones <= ones + 1;
            if ((epoch ^ laser) === 1'bx) $display(\"unknown at %0d\", chips);
            if (epoch === 1'b1) begin
                if (last >= 0 && chips - last != 31) $display(\"epoch after %0d\", chips - last);
                last <= chips;
                epochs <= epochs + 1;
            end
        end
        if (chips == 8 + 310) begin
            $display(\"%0d epochs, %0d\", epochs, ones > 100 && ones < 210);
            $finish;
        end
    end
endmodule
"
    )
}

#[test]
fn every_board_wakes_without_a_reset_from_outside() {
    for (family, clock, lanes) in
        [("ecp5", "i_edge_clk", 4), ("xc7", "i_bit_clk", 8), ("ice40", "i_clk", 2)]
    {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let folder = folder.path();
        let mut sources = core(folder, lanes);
        sources.extend(wrappers(family));
        fs::write(folder.join("bench.v"), never_reset(family, clock)).expect("it can be written");
        fs::write(folder.join("cells.v"), CELLS).expect("it can be written");
        sources.push(match family {
            "ice40" => ice40_cells(folder),
            _ => "cells.v".to_owned(),
        });
        assert_eq!(epochs(folder, &sources), "10 epochs, 1\n", "{family}");
    }
}

#[test]
fn the_ice40_netlist_wakes_though_every_flip_flop_powers_up_at_zero() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let script = format!(
        "{}; synth_ice40 -top ice40_board; write_verilog -noattr netlist.v",
        read_board("ice40", &core(folder, 2))
    );
    run(folder, "yosys", &["-q", "-p", &script]);
    fs::write(folder.join("bench.v"), never_reset("ice40", "i_clk")).expect("it can be written");
    let sources = ["netlist.v".to_owned(), ice40_cells(folder)];
    assert_eq!(epochs(folder, &sources), "10 epochs, 1\n");
}

/// What the testbench in `folder` says of the sources.
fn epochs(folder: &Path, sources: &[String]) -> String {
    let mut arguments = vec!["-g2012", "-DNO_ICE40_DEFAULT_ASSIGNMENTS", "-s", "testbench"];
    arguments.extend(["-o", "bench.vvp", "bench.v"]);
    arguments.extend(sources.iter().map(String::as_str));
    run(folder, "iverilog", &arguments);
    run(folder, "vvp", &["-n", "bench.vvp"])
}

#[test]
fn a_core_that_does_not_fit_the_board_is_refused_by_a_name_that_says_so() {
    for (family, command, fitting, other) in [
        ("ecp5", "synth_ecp5", 4, 8),
        ("xc7", "synth_xilinx", 8, 4),
        ("ice40", "synth_ice40", 2, 4),
    ] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let read = read_board(family, &core(folder.path(), other));
        let script = format!("{read}; {command} -top {family}_board");
        let output = std::process::Command::new("yosys")
            .args(["-q", "-p", &script])
            .current_dir(folder.path())
            .output()
            .expect("yosys starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned()
            + &String::from_utf8_lossy(&output.stdout);
        assert!(!output.status.success(), "{said}");
        let name = format!("{family}_board_needs_a_scene_of_{fitting}_samples_per_chip");
        assert!(said.contains(&name), "{said}");
    }
}

#[test]
fn the_clocks_of_constraints_are_those_of_a_chip_of_8_ns() {
    let text = |path: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("hdl").join(path);
        fs::read_to_string(path).expect("it is there")
    };
    // S / 2 periods of the bit clock in a chip: 8 ns / 4.
    let command = "create_clock -name bit_clk -period 2.000 [get_ports i_bit_clk]\n";
    assert!(text("xc7/xc7_board.xdc").contains(command));
    assert!(text("xc7/xc7_board.v").contains(" i_bit_clk,"));
    // Two edge clocks in a chip.
    assert!(text("ecp5/ecp5_board.lpf").contains("FREQUENCY PORT \"i_edge_clk\" 250 MHZ;"));
    assert!(text("ice40/ice40_board.pcf").contains("--freq 125"));
}

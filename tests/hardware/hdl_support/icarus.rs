//! Runs emitted Verilog in Icarus, one line of outputs for each clock.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use goldtof::deliver::Emission;
use goldtof::sensor::interface::Interface;

use super::naive_sensor::{Inputs, Outputs};
use super::run;

/// Outputs of the emitted hardware after each clock edge.
pub fn simulate(
    emission: &Emission,
    interface: &Interface,
    inputs: &[Inputs],
    folder: &Path,
) -> Vec<Outputs> {
    goldtof::deliver::write(emission, folder).expect("the files can be written");
    let mut stimulus = String::new();
    for input in inputs {
        let word = input.samples << 2 | u128::from(input.ready) << 1 | u128::from(input.reset);
        let _ = writeln!(stimulus, "{word:x}");
    }
    fs::write(folder.join("stimulus.hex"), stimulus).expect("the stimulus can be written");
    fs::write(folder.join("bench.v"), testbench(interface, inputs.len()))
        .expect("so can the bench");
    let files: Vec<&str> = emission.files.iter().map(|f| f.name.as_str()).collect();
    let mut arguments = vec!["-g2005", "-s", "testbench", "-o", "bench.vvp", "bench.v"];
    arguments.extend(&files);
    run(folder, "iverilog", &arguments);
    run(folder, "vvp", &["-n", "bench.vvp"])
        .lines()
        .map(|line| {
            let fields: Vec<u128> = line
                .split_whitespace()
                .map(|field| {
                    u128::from_str_radix(field, 16)
                        .unwrap_or_else(|_| panic!("undefined outputs: {line}"))
                })
                .collect();
            Outputs {
                laser: fields[0] as u64,
                epoch: fields[1] == 1,
                data: fields[2],
                valid: fields[3] == 1,
                last: fields[4] == 1,
                overrun: fields[5] == 1,
                saturated: fields[6] == 1,
                peak_step: fields[7],
                peak_count: fields[8],
                peak_valid: fields[9] == 1,
            }
        })
        .collect()
}

fn testbench(interface: &Interface, cycles: usize) -> String {
    let samples = interface.lanes() as usize * interface.inputs();
    let sources = interface.source_codes.len();
    let data = interface.tdata_bits;
    let (mut connection, saturated) = if interface.saturates() {
        (",\n        .o_saturated(saturated)".to_owned(), "saturated")
    } else {
        (String::new(), "1'b0")
    };
    let detectors = interface.reference_codes.len() as u32;
    let (mut step_top, mut count_top, mut peak) = (0, 0, "1'b0, 1'b0, 1'b0");
    if let Some(plan) = interface.peak() {
        connection += ",\n        .o_peak_step(peak_step), .o_peak_count(peak_count), \
                       .o_peak_valid(peak_valid)";
        step_top = detectors * plan.step_bits - 1;
        count_top = detectors * plan.count_bits - 1;
        peak = "peak_step, peak_count, peak_valid";
    }
    format!(
        r#"`timescale 1ns / 1ps
module testbench;
    reg clk = 0;
    reg [{stimulus_top}:0] stimulus [0:{last}];
    reg [{stimulus_top}:0] now;
    wire [{laser_top}:0] laser;
    wire [{data_top}:0] tdata;
    wire [{step_top}:0] peak_step;
    wire [{count_top}:0] peak_count;
    wire epoch, tvalid, tlast, overrun, saturated, peak_valid;
    integer cycle;
    sensor_top dut (
        .i_clk(clk), .i_rst(now[0]), .m_axis_tready(now[1]), .i_samples(now[{stimulus_top}:2]),
        .o_laser(laser), .o_epoch(epoch), .m_axis_tdata(tdata), .m_axis_tvalid(tvalid),
        .m_axis_tlast(tlast), .o_overrun(overrun){connection});
    initial begin
        $readmemh("stimulus.hex", stimulus);
        for (cycle = 0; cycle <= {last}; cycle = cycle + 1) begin
            now = stimulus[cycle];
            #1 clk = 1;
            #1 $display("%h %h %h %h %h %h %h %h %h %h", laser, epoch, tdata, tvalid, tlast,
                        overrun, {saturated}, {peak});
            clk = 0;
        end
        $finish;
    end
endmodule
"#,
        stimulus_top = samples + 1,
        last = cycles - 1,
        laser_top = sources - 1,
        data_top = data - 1,
    )
}

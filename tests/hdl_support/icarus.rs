//! Runs emitted Verilog in Icarus, one line of outputs for each clock.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use goldtof::hdl::Emission;
use goldtof::model::contract::Contract;

use super::naive_sensor::{Inputs, Outputs};
use super::run;

/// Outputs of the emitted hardware after each clock edge.
pub fn simulate(
    emission: &Emission,
    contract: &Contract,
    inputs: &[Inputs],
    folder: &Path,
) -> Vec<Outputs> {
    goldtof::hdl::write(emission, folder).expect("the files can be written");
    let mut stimulus = String::new();
    for input in inputs {
        let word = input.samples << 2 | u128::from(input.ready) << 1 | u128::from(input.reset);
        let _ = writeln!(stimulus, "{word:x}");
    }
    fs::write(folder.join("stimulus.hex"), stimulus).expect("the stimulus can be written");
    fs::write(folder.join("bench.v"), bench(contract, inputs.len())).expect("so can the bench");
    let files: Vec<&str> = emission.files.iter().map(|f| f.name.as_str()).collect();
    let mut arguments = vec!["-g2005", "-s", "bench", "-o", "bench.vvp", "bench.v"];
    arguments.extend(&files);
    run(folder, "iverilog", &arguments);
    run(folder, "vvp", &["-n", "bench.vvp"])
        .lines()
        .map(|line| {
            let fields: Vec<u64> = line
                .split_whitespace()
                .map(|field| {
                    u64::from_str_radix(field, 16)
                        .unwrap_or_else(|_| panic!("undefined outputs: {line}"))
                })
                .collect();
            Outputs {
                laser: fields[0],
                epoch: fields[1] == 1,
                data: fields[2],
                valid: fields[3] == 1,
                last: fields[4] == 1,
                overrun: fields[5] == 1,
                saturated: fields[6] == 1,
            }
        })
        .collect()
}

fn bench(contract: &Contract, cycles: usize) -> String {
    let samples = contract.lanes as usize * contract.reference_codes.len();
    let sources = contract.source_codes.len();
    let data = contract.tdata_bits;
    let (connection, saturated) = if contract.saturates() {
        (",\n        .o_saturated(saturated)", "saturated")
    } else {
        ("", "1'b0")
    };
    format!(
        r#"`timescale 1ns / 1ps
module bench;
    reg clk = 0;
    reg [{stimulus_top}:0] stimulus [0:{last}];
    reg [{stimulus_top}:0] now;
    wire [{laser_top}:0] laser;
    wire [{data_top}:0] tdata;
    wire epoch, tvalid, tlast, overrun, saturated;
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
            #1 $display("%h %h %h %h %h %h %h", laser, epoch, tdata, tvalid, tlast, overrun, {saturated});
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

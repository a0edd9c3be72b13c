// A testbench with goldtof's scoreboard beside the design. With Verilator:
//
//   $ verilator --binary --timing -Icapi/sv --top testbench -y generated/quick \
//         capi/examples/testbench.sv generated/quick/sensor_top.v \
//         $PWD/target/release/libgoldtof_c.so -LDFLAGS -Wl,-rpath,$PWD/target/release
//   $ obj_dir/Vtestbench

`include "goldtof_scoreboard.svh"

`ifndef DESIGN
`define DESIGN sensor_top
`endif
`ifndef LATENCY
`define LATENCY -1
`endif
`ifndef CLOCKS
`define CLOCKS 20000
`endif

module testbench;
    logic        i_clk = 0;
    logic        i_rst = 1;
    logic [7:0]  i_samples = 0;
    logic        m_axis_tready = 1;
    logic [15:0] m_axis_tdata;
    logic        o_laser, o_epoch, m_axis_tvalid, m_axis_tlast, o_overrun;

    always #4 i_clk = !i_clk;  // 8 ns with --timescale 1ns/1ps

    // Samples that are high one time in eight, a receiver that stalls for longer than a step
    // takes, and a second reset.
    logic [31:0] random = 32'h1234_5678;
    int          clocks = 0;
    always @(posedge i_clk) begin
        random        <= {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        i_samples     <= random[7:0] & random[15:8] & random[23:16];
        m_axis_tready <= !clocks[12];
        i_rst         <= clocks < 4 || clocks == 9000;
        clocks        <= clocks + 1;
        if (clocks == `CLOCKS) $finish;
    end

    `DESIGN sensor (.i_clk, .i_rst, .o_laser, .o_epoch, .i_samples, .m_axis_tdata,
                    .m_axis_tvalid, .m_axis_tready, .m_axis_tlast, .o_overrun);

`ifndef WITHOUT_SCOREBOARD
    goldtof_scoreboard #(
        .SCENE("scenes/quick.toml"), .SAMPLES(8), .TDATA(16), .RESULT_LATENCY(`LATENCY)
    ) scoreboard (
        .i_clk, .i_rst, .i_samples, .m_axis_tready, .o_laser, .o_epoch, .m_axis_tdata,
        .m_axis_tvalid, .m_axis_tlast, .o_overrun, .o_saturated(1'b0), .o_peak_step(1'b0),
        .o_peak_count(1'b0), .o_peak_valid(1'b0));
`endif
endmodule

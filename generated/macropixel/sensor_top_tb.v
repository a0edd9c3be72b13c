// sensor_top_tb: self-checking testbench of sensor_top
//
// Drives recorded inputs and compares every output port, after every rising edge of i_clk and
// before the next one, with what goldtof's reference model gives. The model takes chips from the code's table and hits from
// the list of pulses: no part of the design has a share in the expected values.
//
// Inputs   hostile, with an aim: 38 resets, a receiver that stalls, every kind of hit
// Length   52436 clocks; 311 phase steps and 8 scans end in them
// Counts   26785 hits up and 22605 hits down in the results that come to the stream
// Covers   66 of 66 cover points (hits 14/14, cells 9/9, carries 2/2, stream 13/13, resets 17/17,
//          scans 11/11)
// Short    steps and scans are cut short, so that their ends and many more of them come in this
//          length: between two clocks the testbench XORs a constant into the counters of the scan
//          controller (controller.chip_count_r, controller.step_count_r), which moves them on and
//          touches nothing else. A design without them is checked for the first 7508 clocks,
//          before the first such move, with SENSOR_TOP_TB_WHOLE defined
// Ends     with PASS, what was exercised, and exit status 0; or at the first clock at which a port
//          differs with that clock, the port, the expected value and the one seen, and a non-zero
//          exit status; or with INCONCLUSIVE and a non-zero exit status, if no result was taken
//          that counts anything: a sensor that does nothing would pass then
// Language Verilog-2005, and the system task $fatal of IEEE 1800, which gives the exit status
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)
//
// Run it in this folder with
//   $ iverilog -g2005 -s sensor_top_tb -o sensor_top_tb.vvp -f sensor_top_tb.f
//   $ vvp sensor_top_tb.vvp
// or
//   $ verilator --binary --top-module sensor_top_tb -f sensor_top_tb.f
//   $ obj_dir/Vsensor_top_tb
// With +vcd it writes waves to sensor_top_tb.vcd (Verilator: build with --trace). Time is real:
// a clock takes 8 ns, as on the chip.

`ifndef VERILATOR
`timescale 1 ns / 1 ns
`endif

`default_nettype none

module sensor_top_tb;

`ifdef SENSOR_TOP_TB_WHOLE
    localparam CLOCKS = 7508;
`else
    localparam CLOCKS = 52436;
`endif

`ifdef VERILATOR // in its unit of time, 1 ps
    localparam LOW = 64'd4000, HIGH = 64'd4000;
`else
    localparam LOW = 64'd4, HIGH = 64'd4;
`endif

    // Inputs of the sensor, and its outputs
    reg          i_clk;
    wire         i_rst;
    wire [15:0]  i_samples;
    wire         m_axis_tready;
    wire         o_laser;
    wire         o_epoch;
    wire [15:0]  m_axis_tdata;
    wire         m_axis_tvalid;
    wire         m_axis_tlast;
    wire         o_overrun;

    // What the reference model gives
    wire         expected_o_laser;
    wire         expected_o_epoch;
    wire [15:0]  expected_m_axis_tdata;
    wire         expected_m_axis_tvalid;
    wire         expected_m_axis_tlast;
    wire         expected_o_overrun;
    wire [11:0]  skip_controller_chip_count_r;
    wire [6:0]   skip_controller_step_count_r;
    wire [17:0]  inputs_value;
    wire [1:0]   chips_value;
    wire [18:0]  results_value;
    wire [18:0]  skips_value;

    integer      clock;
    reg          failed;

    // What has been exercised
    integer      results;
    integer      counts;
    integer      scan_ends;
    integer      stalls;
    integer      resets;
    reg          in_reset;

    sensor_top dut (
        .i_clk         (i_clk),
        .i_rst         (i_rst),
        .i_samples     (i_samples),
        .m_axis_tready (m_axis_tready),
        .o_laser       (o_laser),
        .o_epoch       (o_epoch),
        .m_axis_tdata  (m_axis_tdata),
        .m_axis_tvalid (m_axis_tvalid),
        .m_axis_tlast  (m_axis_tlast),
        .o_overrun     (o_overrun)
    );

    sensor_top_tb_vectors #(
        .FILE      ("sensor_top_tb_inputs.hex"),
        .WORDS     (48915),
        .W_REPEATS (4),
        .W_VALUE   (18)
    ) inputs_file (
        .i_clk     (i_clk),
        .o_value   (inputs_value)
    );
    assign {
        m_axis_tready,
        i_samples,
        i_rst
    } = inputs_value;

    sensor_top_tb_vectors #(
        .FILE      ("sensor_top_tb_chips.hex"),
        .WORDS     (30277),
        .W_REPEATS (4),
        .W_VALUE   (2)
    ) chips_file (
        .i_clk     (i_clk),
        .o_value   (chips_value)
    );
    assign {
        expected_o_epoch,
        expected_o_laser
    } = chips_value;

    sensor_top_tb_vectors #(
        .FILE      ("sensor_top_tb_results.hex"),
        .WORDS     (567),
        .W_REPEATS (12),
        .W_VALUE   (19)
    ) results_file (
        .i_clk     (i_clk),
        .o_value   (results_value)
    );
    assign {
        expected_o_overrun,
        expected_m_axis_tlast,
        expected_m_axis_tvalid,
        expected_m_axis_tdata
    } = results_value;

    sensor_top_tb_vectors #(
        .FILE      ("sensor_top_tb_skips.hex"),
        .WORDS     (606),
        .W_REPEATS (12),
        .W_VALUE   (19)
    ) skips_file (
        .i_clk     (i_clk),
        .o_value   (skips_value)
    );
    assign {
        skip_controller_step_count_r,
        skip_controller_chip_count_r
    } = skips_value;

    // Of a clock; its expected values stand from its rising edge to the next one.
    task compare;
        input integer at;
        begin
            if (o_laser !== expected_o_laser) begin
                $display("FAIL clock %0d: o_laser expected %h got %h", at,
                         expected_o_laser, o_laser);
                failed = 1'b1;
            end
            if (o_epoch !== expected_o_epoch) begin
                $display("FAIL clock %0d: o_epoch expected %h got %h", at,
                         expected_o_epoch, o_epoch);
                failed = 1'b1;
            end
            if (expected_m_axis_tvalid && m_axis_tdata !== expected_m_axis_tdata) begin
                $display("FAIL clock %0d: m_axis_tdata expected %h got %h", at,
                         expected_m_axis_tdata, m_axis_tdata);
                failed = 1'b1;
            end
            if (m_axis_tvalid !== expected_m_axis_tvalid) begin
                $display("FAIL clock %0d: m_axis_tvalid expected %h got %h", at,
                         expected_m_axis_tvalid, m_axis_tvalid);
                failed = 1'b1;
            end
            if (expected_m_axis_tvalid && m_axis_tlast !== expected_m_axis_tlast) begin
                $display("FAIL clock %0d: m_axis_tlast expected %h got %h", at,
                         expected_m_axis_tlast, m_axis_tlast);
                failed = 1'b1;
            end
            if (o_overrun !== expected_o_overrun) begin
                $display("FAIL clock %0d: o_overrun expected %h got %h", at,
                         expected_o_overrun, o_overrun);
                failed = 1'b1;
            end
        end
    endtask

    // Inputs, outputs and expected values all change with the rising edge.
    initial begin
        if ($test$plusargs("vcd")) begin
            $dumpfile("sensor_top_tb.vcd");
            $dumpvars(0, sensor_top_tb);
        end
        failed    = 1'b0;
        i_clk     = 1'b0;
        results   = 0;
        counts    = 0;
        scan_ends = 0;
        stalls    = 0;
        resets    = 0;
        in_reset  = 1'b0;
        for (clock = 0; clock < CLOCKS; clock = clock + 1) begin
`ifndef SENSOR_TOP_TB_WHOLE
            // Steps and scans are cut short: nothing else in the design is touched.
            /* verilator lint_off INITIALDLY */
            dut.controller.chip_count_r <= dut.controller.chip_count_r ^ skip_controller_chip_count_r;
            dut.controller.step_count_r <= dut.controller.step_count_r ^ skip_controller_step_count_r;
            /* verilator lint_on INITIALDLY */
`endif
            #LOW;
            if (clock != 0 && !(|skips_value)) compare(clock - 1);
            if (failed) begin
                $display("     it was as expected after that clock's rising edge, and moved before the next");
                $fatal;
            end
            i_clk = 1'b1;
            #HIGH;
            if (^inputs_value === 1'bx || (clock == 0 && !i_rst)) begin
                $display("FAIL clock %0d: sensor_top_tb_inputs.hex is missing or short", clock);
                failed = 1'b1;
            end
            if (^chips_value === 1'bx) begin
                $display("FAIL clock %0d: sensor_top_tb_chips.hex is missing or short", clock);
                failed = 1'b1;
            end
            if (^results_value === 1'bx) begin
                $display("FAIL clock %0d: sensor_top_tb_results.hex is missing or short", clock);
                failed = 1'b1;
            end
            if (^skips_value === 1'bx) begin
                $display("FAIL clock %0d: sensor_top_tb_skips.hex is missing or short", clock);
                failed = 1'b1;
            end
            compare(clock);
            if (failed) $fatal;
            // What stands here is taken with the next rising edge.
            if (m_axis_tvalid && !i_rst) begin
                if (m_axis_tready) begin
                    results = results + 1;
                    if (|m_axis_tdata) counts = counts + 1;
                    if (m_axis_tlast) scan_ends = scan_ends + 1;
                end else begin
                    stalls = stalls + 1;
                end
            end
            if (i_rst && !in_reset) resets = resets + 1;
            in_reset = i_rst;
            i_clk    = 1'b0;
        end
        if (counts == 0) begin
            $display("INCONCLUSIVE: every output port as expected, but of %0d results that were taken",
                     results);
            $display("              none holds a count: nothing shows that the sensor counts");
            $fatal;
        end
        $display("PASS: every output port as expected at each of %0d clocks", CLOCKS);
        $display("exercised: %0d results, %0d of them not zero, %0d scan ends, %0d clocks stalled,",
                 results, counts, scan_ends, stalls);
        $display("           %0d resets", resets);
        $finish;
    end

endmodule

`default_nettype wire

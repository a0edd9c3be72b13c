// @TOP@: self-checking testbench of @DESIGN@
//
// Drives recorded inputs and compares every output port, after every rising edge of i_clk and
// before the next one, with what goldtof's reference model gives. The model takes chips from the code's table and hits from
// the list of pulses: no part of the design has a share in the expected values.
//
// Inputs   hostile, with an aim: @RESETS@ resets, a receiver that stalls, every kind of hit
// Length   @CLOCKS@ clocks; @STEPS@ phase steps and @SCANS@ scans end in them
// Counts   @HITS_UP@ hits up and @HITS_DOWN@ hits down in the results that come to the stream
@COVERS@// Ends     with PASS, what was exercised, and exit status 0; or at the first clock at which a port
//          differs with that clock, the port, the expected value and the one seen, and a non-zero
//          exit status; or with INCONCLUSIVE and a non-zero exit status, if no result was taken
//          that counts anything: a sensor that does nothing would pass then
// Language Verilog-2005, and the system task $fatal of IEEE 1800, which gives the exit status
// Made by  @MADE_BY@
//
// Run it in this folder with
//   $ iverilog -g2005 -s @TOP@ -o @TOP@.vvp -f @TOP@.f
//   $ vvp @TOP@.vvp
// or
//   $ verilator --binary --top-module @TOP@ -f @TOP@.f
//   $ obj_dir/V@TOP@
// With +vcd it writes waves to @TOP@.vcd (Verilator: build with --trace). Time is real:
// @TIME@.

`ifndef VERILATOR
`timescale @UNIT@ / @UNIT@
`endif

`default_nettype none

module @TOP@;

@LENGTH@
`ifdef VERILATOR // in its unit of time, 1 ps
    localparam @HALVES_PS@;
`else
    localparam @HALVES@;
`endif

    // Inputs of the sensor, and its outputs
    reg          i_clk;
@PORTS@
    // What the reference model gives
@EXPECTED@
    integer      clock;
    reg          failed;

    // What has been exercised
    integer      results;
    integer      counts;
    integer      scan_ends;
    integer      stalls;
    integer      resets;
    reg          in_reset;

    @DESIGN@ dut (
@CONNECTIONS@
    );
@READERS@
    // Of a clock; its expected values stand from its rising edge to the next one.
    task compare;
        input integer at;
        begin
@COMPARED@        end
    endtask

    // Inputs, outputs and expected values all change with the rising edge.
    initial begin
        if ($test$plusargs("vcd")) begin
            $dumpfile("@TOP@.vcd");
            $dumpvars(0, @TOP@);
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
@MOVES@            #LOW;
            if (clock != 0@UNMOVED@) compare(clock - 1);
            if (failed) begin
                $display("     it was as expected after that clock's rising edge, and moved before the next");
                $fatal;
            end
            i_clk = 1'b1;
            #HIGH;
@THERE@            compare(clock);
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

// updown_correlator: hits counted up or down as the reference says
//
// Of two neighbouring samples at most one is a rising edge, so a pair counts -1, 0 or +1 in two
// bits. The total is never cleared: a step's count is the difference of two totals, which keeps
// multiplexers out of the carry chain, and wrapping does no harm to a difference.
//
// Latency  4 clocks from i_hits to o_total
// Rate     one word per clock
// Made by  goldtof emit dual-view.toml (goldtof 0.1.0)

`default_nettype none

module updown_correlator (
    // Clock and reset
    input  wire        i_clk,       // one word per cycle
    input  wire        i_rst,       // synchronous, active high

    // Inputs
    input  wire [7:0]  i_hits,      // samples that begin a pulse, bit 0 earliest
    input  wire [7:0]  i_reference, // 1 counts a hit up, 0 down
    input  wire        i_step_end,  // last clock of a phase step, one clock before its hits
    input  wire        i_scan_end,  // the step is the scan's last

    // Outputs
    output reg  [16:0] o_total,     // sum over all hits, modulo its width
    output wire        o_dump,      // o_total has just taken in a step's last hits
    output wire        o_last       // the step is the scan's last
);

    reg  [1:0] sum_0_1_r;  // signed count of lanes 0 to 1
    reg  [1:0] sum_2_3_r;  // signed count of lanes 2 to 3
    reg  [1:0] sum_4_5_r;  // signed count of lanes 4 to 5
    reg  [1:0] sum_6_7_r;  // signed count of lanes 6 to 7
    reg  [2:0] sum_0_3_r;  // signed count of lanes 0 to 3
    reg  [2:0] sum_4_7_r;  // signed count of lanes 4 to 7
    reg  [3:0] sum_0_7_r;  // signed count of lanes 0 to 7
    reg  [4:0] step_end_r; // i_step_end on its way through the pipeline
    reg  [4:0] scan_end_r; // i_scan_end on its way through the pipeline
    wire [7:0] down;       // hits that count down

    assign down = i_hits & ~i_reference;
    assign o_dump = step_end_r[4];
    assign o_last = scan_end_r[4];

    always @(posedge i_clk) begin
        if (i_rst) begin
            sum_0_1_r <= 2'd0;
            sum_2_3_r <= 2'd0;
            sum_4_5_r <= 2'd0;
            sum_6_7_r <= 2'd0;
            sum_0_3_r <= 3'd0;
            sum_4_7_r <= 3'd0;
            sum_0_7_r <= 4'd0;
            o_total <= 17'd0;
            step_end_r <= 5'd0;
            scan_end_r <= 5'd0;
        end else begin
            sum_0_1_r <= {down[0] | down[1], i_hits[0] | i_hits[1]};
            sum_2_3_r <= {down[2] | down[3], i_hits[2] | i_hits[3]};
            sum_4_5_r <= {down[4] | down[5], i_hits[4] | i_hits[5]};
            sum_6_7_r <= {down[6] | down[7], i_hits[6] | i_hits[7]};
            sum_0_3_r <= {sum_0_1_r[1], sum_0_1_r} + {sum_2_3_r[1], sum_2_3_r};
            sum_4_7_r <= {sum_4_5_r[1], sum_4_5_r} + {sum_6_7_r[1], sum_6_7_r};
            sum_0_7_r <= {sum_0_3_r[2], sum_0_3_r} + {sum_4_7_r[2], sum_4_7_r};
            o_total <= o_total + {{13{sum_0_7_r[3]}}, sum_0_7_r};
            step_end_r <= {step_end_r[3:0], i_step_end};
            scan_end_r <= {scan_end_r[3:0], i_scan_end};
        end
    end

endmodule

`default_nettype wire

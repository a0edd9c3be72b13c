// scan_controller: counts chips per phase step and steps per scan
//
// Both counters end when their top bit comes up, so that no comparator is needed, and begin
// again by adding the reload value instead of 1, so that no multiplexer stands before the carry
// chain.
//
// Scans follow one another without a gap, because a scan over the whole code period ends where
// it began.
//
// Dwell    13100 chips per phase step
// Scan     16376 phase steps
// Latency  0 clocks
// Made by  goldtof emit dual-view.toml (goldtof 0.1.0)

`default_nettype none

module scan_controller (
    // Clock and reset
    input  wire  i_clk,      // one chip per cycle
    input  wire  i_rst,      // synchronous, active high

    // Outputs
    output reg   o_run,      // the present clock belongs to a scan
    output wire  o_step_end, // last clock of a phase step
    output wire  o_scan_end  // last clock of a scan
);

    // Dwell counter at a step's first chip
    localparam [14:0] DWELL_RELOAD = 15'hcd5;

    // Step counter at a scan's first step
    localparam [14:0] STEPS_RELOAD = 15'd9;

    reg  [14:0] dwell_r;         // chips of the present step; the top bit marks the last
    reg  [14:0] steps_r;         // steps of the present scan; the top bit marks the last
    wire [14:0] dwell_increment; // 1, or the reload value
    wire [14:0] steps_increment; // 1, or the reload value

    assign o_step_end = dwell_r[14];
    assign dwell_increment = dwell_r[14] ? DWELL_RELOAD : 15'd1;
    assign o_scan_end = o_step_end & steps_r[14];
    assign steps_increment = steps_r[14] ? STEPS_RELOAD : 15'd1;

    always @(posedge i_clk) begin
        if (i_rst) begin
            o_run <= 1'b0;
            dwell_r <= 15'hcd4;
            steps_r <= 15'd9;
        end else begin
            dwell_r <= {1'b0, dwell_r[13:0]} + dwell_increment;
            if (o_step_end) begin
                steps_r <= {1'b0, steps_r[13:0]} + steps_increment;
            end
            o_run <= 1'b1;
        end
    end

endmodule

`default_nettype wire

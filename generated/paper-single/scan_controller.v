// scan_controller: counts chips per phase step and steps per scan
//
// Both counters are LFSRs, which pass through as many states as a binary counter and need no
// carry chain. The states in which they end were computed beforehand, and are recognised a
// clock early, so that every flag comes from a register.
//
// Scans follow one another without a gap, because a scan over the whole code period ends where
// it began.
//
// Dwell    13100 chips per phase step
// Scan     16376 phase steps
// Latency  5 clocks from a step's last one to o_dump
// Made by  goldtof emit paper-single.toml (goldtof 0.1.0)

`default_nettype none

module scan_controller (
    // Clock and reset
    input  wire  i_clk,       // one chip per cycle
    input  wire  i_rst,       // synchronous, active high

    // Outputs
    output reg   o_run,       // the present clock belongs to a scan
    output reg   o_step_ends, // the next clock is the last of a phase step
    output wire  o_step_end,  // last clock of a phase step
    output wire  o_dump,      // the total has just taken in a step's last hits, segment by segment
    output wire  o_counted,   // the step's count is there
    output wire  o_last       // it is the scan's last
);

    // Chip counter a chip before a step's first
    localparam [13:0] DWELL_RESET = 14'h3ffe;

    // Chip counter at a step's first chip
    localparam [13:0] DWELL_LOAD = 14'h3fff;

    // Taps of the chip counter
    localparam [13:0] DWELL_TAPS = 14'h2a01;

    // Chip counter three chips before a step's last
    localparam [13:0] DWELL_ENDING = 14'h19c4;

    // Step counter at a scan's first step
    localparam [13:0] STEPS_LOAD = 14'h3fff;

    // Taps of the step counter
    localparam [13:0] STEPS_TAPS = 14'h2a01;

    // Step counter one step before a scan's last
    localparam [13:0] STEPS_ENDING = 14'h3e00;

    reg  [13:0] dwell_r;             // chips of the present step
    reg         step_end_r;          // last clock of a phase step
    reg  [13:0] steps_r;             // steps of the present scan
    reg         last_step_r;         // the present step is the scan's last
    reg         scan_end_r;          // last clock of a scan
    reg  [5:0]  step_ended_r;        // the end of a step on its way through the correlator
    reg  [5:0]  scan_ended_r;        // the end of a scan on its way through the correlator
    wire        ends_step;           // last clock of a phase step
    wire        ends_scan;           // last clock of a scan
    wire        dumps;               // dump of each segment
    wire        dwell_match_matched; // they were equal one clock ago
    wire        steps_match_matched; // they were equal one clock ago

    assign ends_step = step_end_r;
    assign ends_scan = scan_end_r;
    assign o_step_end = ends_step;
    assign o_counted = step_ended_r[5];
    assign o_last = scan_ended_r[5];
    assign o_dump = dumps;
    assign dumps = step_ended_r[4];

    state_match dwell_match (
        .i_clk     (i_clk),
        .i_rst     (i_rst),
        .i_state   (dwell_r),
        .i_wanted  (DWELL_ENDING),
        .o_matched (dwell_match_matched)
    );

    state_match steps_match (
        .i_clk     (i_clk),
        .i_rst     (i_rst),
        .i_state   (steps_r),
        .i_wanted  (STEPS_ENDING),
        .o_matched (steps_match_matched)
    );

    always @(posedge i_clk) begin
        if (i_rst) begin
            o_run <= 1'b0;
            dwell_r <= DWELL_RESET;
            o_step_ends <= 1'b0;
            step_end_r <= 1'b0;
            steps_r <= STEPS_LOAD;
            last_step_r <= 1'b0;
            scan_end_r <= 1'b0;
            step_ended_r <= 6'd0;
            scan_ended_r <= 6'd0;
        end else begin
            step_end_r <= o_step_ends;
            scan_end_r <= o_step_ends & last_step_r;
            o_run <= 1'b1;
            o_step_ends <= o_run & dwell_match_matched;
            if (ends_step) begin
                dwell_r <= DWELL_LOAD;
            end else begin
                dwell_r <= {^(dwell_r & DWELL_TAPS), dwell_r[13:1]};
            end
            if (ends_step) begin
                last_step_r <= steps_match_matched;
            end
            if (ends_scan) begin
                steps_r <= STEPS_LOAD;
            end else if (ends_step) begin
                steps_r <= {^(steps_r & STEPS_TAPS), steps_r[13:1]};
            end
            step_ended_r <= {step_ended_r[4:0], ends_step};
            scan_ended_r <= {scan_ended_r[4:0], ends_scan};
        end
    end

endmodule

`default_nettype wire

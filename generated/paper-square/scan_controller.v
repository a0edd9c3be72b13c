// scan_controller: counts chips per phase step and steps per scan
//
// Both counters are LFSRs: the next state costs one gate where a binary counter costs a carry
// chain. A count's end is a state computed beforehand; it is recognised early, so that every
// flag comes from a register.
//
// Scans follow one another without a gap, because a scan over the whole code period ends where
// it began.
//
// Step     13100 chips
// Scan     16 phase steps
// Latency  5 clocks from a step's last chip to o_dump
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module scan_controller (
    input  wire i_clk, i_rst,

    output reg  o_run,           // the present chip belongs to a scan
    output reg  o_pre_last_chip, // it is the last but one of a phase step
    output reg  o_last_chip,     // it is the last of a phase step
    output wire o_dump,          // the total has just taken in a step's last hits
    output wire o_counted,       // the step's count is there
    output wire o_scan_counted   // the count of the scan's last step is there
);

    // Chip counter: an LFSR of the polynomial 14,5,3,1,0 (exponents)
    localparam [13:0] CHIP_COUNT_TAPS  = 14'h2a01;
    localparam [13:0] CHIP_COUNT_RESET = 14'h3ffe; // one shift before a step's first chip
    localparam [13:0] CHIP_COUNT_FIRST = 14'h3fff; // at a step's first chip
    localparam [13:0] CHIP_COUNT_END   = 14'h19c4; // 13096 shifts on, 3 chips before a step's last

    // Step counter: an LFSR of the polynomial 4,3,0 (exponents)
    localparam [3:0] STEP_COUNT_TAPS  = 4'h3;
    localparam [3:0] STEP_COUNT_FIRST = 4'hf; // at a scan's first step
    localparam [3:0] STEP_COUNT_END   = 4'he; // 14 shifts on, one step before a scan's last

    reg  [13:0] chip_count_r;
    reg  [3:0]  step_count_r;
    reg         last_step_r;      // the present step is the scan's last
    reg         scan_last_chip_r; // the present chip is the scan's last
    reg  [5:0]  step_done_r;      // bit n: a step's last chip was n + 1 clocks ago
    reg  [5:0]  scan_done_r;      // bit n: a scan's last chip was n + 1 clocks ago
    wire        chip_count_matched;

    assign o_counted = step_done_r[5];
    assign o_scan_counted = scan_done_r[5];
    assign o_dump = step_done_r[4];

    state_match chip_count_match (
        .i_clk (i_clk), .i_rst (i_rst),
        .i_state   (chip_count_r),
        .i_wanted  (CHIP_COUNT_END),
        .o_matched (chip_count_matched)
    );

    always @(posedge i_clk)
        if (i_rst) begin
            {o_run, o_pre_last_chip, o_last_chip, last_step_r, scan_last_chip_r, step_done_r,
            scan_done_r} <= 0;
            chip_count_r <= CHIP_COUNT_RESET;
            step_count_r <= STEP_COUNT_FIRST;
        end else begin
            o_last_chip <= o_pre_last_chip;
            scan_last_chip_r <= o_pre_last_chip & last_step_r;
            o_run <= 1'b1;
            o_pre_last_chip <= o_run & chip_count_matched;
            if (o_last_chip) begin
                chip_count_r <= CHIP_COUNT_FIRST;
                last_step_r <= step_count_r == STEP_COUNT_END;
            end else begin
                chip_count_r <= {^(chip_count_r & CHIP_COUNT_TAPS), chip_count_r[13:1]};
            end
            if (scan_last_chip_r) begin
                step_count_r <= STEP_COUNT_FIRST;
            end else if (o_last_chip) begin
                step_count_r <= {^(step_count_r & STEP_COUNT_TAPS), step_count_r[3:1]};
            end
            step_done_r <= {step_done_r[4:0], o_last_chip};
            scan_done_r <= {scan_done_r[4:0], scan_last_chip_r};
        end

`ifndef SYNTHESIS
    lfsr_check #(
        .WIDTH(14), .TAPS(CHIP_COUNT_TAPS), .SHIFTS(64'd1),
        .FIRST(CHIP_COUNT_RESET), .LAST(CHIP_COUNT_FIRST)
    ) chip_count_first_check ();
    lfsr_check #(
        .WIDTH(14), .TAPS(CHIP_COUNT_TAPS), .SHIFTS(64'd13096),
        .FIRST(CHIP_COUNT_FIRST), .LAST(CHIP_COUNT_END)
    ) chip_count_end_check ();
    lfsr_check #(
        .WIDTH(4), .TAPS(STEP_COUNT_TAPS), .SHIFTS(64'd14),
        .FIRST(STEP_COUNT_FIRST), .LAST(STEP_COUNT_END)
    ) step_count_end_check ();
`endif

endmodule

`default_nettype wire

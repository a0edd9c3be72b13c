// What sensor_top has to do: a module for each proof of sensor_top.sby
//
// Each has the design, a specification of its own, and assertions. Registers start as one clock
// of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any
// time. Outputs of modules inside are seen, or cut and driven by the proof, by sensor_top.sby.
// What a block_memory gives is anything, at any clock.
//
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

// The numbers of this design, and its codes.
`define TOP sensor_top
`define SOURCES 1
`define DETECTORS 1
`define CELLS 1
`define COINCIDENCE 1
`define SAMPLES 8
`define DATA_BITS 64
`define COUNT_BITS 3
`define TOTAL_BITS 1
`define TOTAL_EXACT_BITS 1
`define PEAK_STEP_BITS 1
`define INVERTED 1'b0
`define ODD_CELLS 1'b0
`define ADDED_CELLS 1'b0
`define SATURATES 1'b0
`define SENDS_TOTAL 1'b0
`define FINDS_PEAK 1'b0
`define REALIGNS 1'b0
`define ROWS 2047
`define ROW_BITS 11
`define PERIODS 7
`define TAKES_TURNS 1'b1

module spec_code_of_source #(
    parameter NUMBER = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    generate
        case (NUMBER)
            0: spec_code #(.DEGREE(11), .TAPS_U(11'h201), .FIRST_U(11'h7ff), .TAPS_V(11'h249), .FIRST_V(11'h7ff)) is (.*);
        endcase
    endgenerate
endmodule

module spec_code_of_reference #(
    parameter NUMBER = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    generate
        case (NUMBER)
            0: spec_code #(.DEGREE(11), .TAPS_U(11'h201), .FIRST_U(11'h7ff), .TAPS_V(11'h249), .FIRST_V(11'h7ff)) is (.*);
        endcase
    endgenerate
endmodule

// What a host drives and sees, of a design with registers.
`ifdef SETTINGS_BITS
`define HOST_INPUTS , \
    input wire [11:0] s_axil_awaddr, \
    input wire s_axil_awvalid, \
    input wire [31:0] s_axil_wdata, \
    input wire [3:0] s_axil_wstrb, \
    input wire s_axil_wvalid, \
    input wire s_axil_bready, \
    input wire [11:0] s_axil_araddr, \
    input wire s_axil_arvalid, \
    input wire s_axil_rready
`define HOST_OUTPUTS \
    wire s_axil_awready; \
    wire s_axil_wready; \
    wire [1:0] s_axil_bresp; \
    wire s_axil_bvalid; \
    wire s_axil_arready; \
    wire [31:0] s_axil_rdata; \
    wire [1:0] s_axil_rresp; \
    wire s_axil_rvalid;
`else
`define HOST_INPUTS
`define HOST_OUTPUTS
`endif

// The design and its outputs, of which a proof has those that the design has. A proof has the
// inputs as its own.
`define DESIGN \
    wire [`SOURCES-1:0] o_laser; \
    wire o_epoch; \
    wire [`DATA_BITS-1:0] m_axis_tdata; \
    wire m_axis_tvalid; \
    wire m_axis_tlast; \
    wire o_overrun; \
    wire o_saturated; \
    wire [`DETECTORS*`PEAK_STEP_BITS-1:0] o_peak_step; \
    wire [`DETECTORS*`COUNT_BITS-1:0] o_peak_count; \
    wire o_peak_valid; \
    `HOST_OUTPUTS \
    `TOP dut (.*);

`define INPUTS_BUT_RESET \
    input wire i_clk, \
    input wire [`DETECTORS*`CELLS*`SAMPLES-1:0] i_samples, \
    input wire m_axis_tready \
    `HOST_INPUTS

`define INPUTS \
    input wire i_rst, \
    `INPUTS_BUT_RESET

// That what a proof is about can be: its task `..._cover` shows how.
`ifdef COVER
`define REACHES(condition) always @* assume (!(condition));
`else
`define REACHES(condition)
`endif

// Induction: registers are anything at first, but such that what is to hold does for so many
// clocks; then it does in the next one.
`define HOLDS_BEHIND(count, condition) \
    reg [$clog2(count + 1)-1:0] clocks = 0; \
    reg held; \
    always @(posedge i_clk) begin \
        clocks <= clocks + (clocks != count); \
        held <= (held | clocks == 0) & (condition); \
    end \
    always @* if (clocks == count & held) assert (condition);

// A clock of reset leaves every register at the value that the other proofs start from, whatever
// it held, and no X. The assertions are those of registers.v, one for each register.
module prove_reset (
    `INPUTS_BUT_RESET
);
    wire i_rst = 1'b1;
    `DESIGN
endmodule

// A code: its chips one after another, and the first of its period. It comes of one LFSR, of the
// sum of two, or of a table; interleaved, each chip comes 2^DEPTH times, every other time inverted
// (eq. 23).
module spec_code #(
    parameter DEGREE = 1,
    parameter [DEGREE-1:0] TAPS_U = 0,
    parameter [DEGREE-1:0] FIRST_U = 0,
    parameter [DEGREE-1:0] TAPS_V = 0,
    parameter [DEGREE-1:0] FIRST_V = 0,  // 0: no second LFSR
    parameter CHIPS = 1,                 // of the table, which is there if there is no LFSR
    parameter [CHIPS-1:0] TABLE = 0,
    parameter FIRST = 0,                 // first chip of the table
    parameter DEPTH = 0,
    parameter FIRST_REPETITION = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    wire moves, is_inverted, is_first;
    wire starts = i_rst | load;
    generate
        if (DEPTH > 0) begin : interleaved
            reg [DEPTH-1:0] repetition;
            always @(posedge i_clk)
                if (starts) repetition <= FIRST_REPETITION;
                else if (advance) repetition <= repetition + 1'b1;
            assign moves = advance & (&repetition);
            assign is_inverted = repetition[0];
            assign is_first = repetition == FIRST_REPETITION;
        end else begin : plain
            assign moves = advance;
            assign is_inverted = 1'b0;
            assign is_first = 1'b1;
        end
        if (FIRST_U != 0) begin : generated
            reg [DEGREE-1:0] u;
            always @(posedge i_clk)
                if (starts) u <= FIRST_U;
                else if (moves) u <= {^(u & TAPS_U), u[DEGREE-1:1]};
            always @* assert (u != 0);
            wire of_second;
            if (FIRST_V != 0) begin : pair
                reg [DEGREE-1:0] v;
                always @(posedge i_clk)
                    if (starts) v <= FIRST_V;
                    else if (moves) v <= {^(v & TAPS_V), v[DEGREE-1:1]};
                always @* assert (v != 0);
                assign of_second = v[0];
            end else begin : single
                assign of_second = 1'b0;
            end
            assign chip = u[0] ^ of_second ^ is_inverted;
            assign epoch = u == FIRST_U & is_first;
        end else begin : listed
            localparam BITS = CHIPS > 2 ? $clog2(CHIPS) : 1;
            reg [BITS-1:0] index;
            always @(posedge i_clk)
                if (starts) index <= FIRST;
                else if (moves) index <= index == CHIPS - 1 ? 0 : index + 1'b1;
            always @* assert (index <= CHIPS - 1);
            wire [CHIPS-1:0] chips = TABLE;
            assign chip = chips[index] ^ is_inverted;
            assign epoch = index == FIRST & is_first;
        end
    endgenerate
endmodule

// After reset every laser shows its source's code, chip by chip, and o_epoch the first chip of the
// reference's. No LFSR reaches zero. (That an LFSR comes back to its first state after 2^n - 1
// chips and not before is a matter of its polynomial, not of the design.)
module prove_codes (
    `INPUTS
);
    `DESIGN
    wire [`SOURCES-1:0] chips;
    wire epoch;
    genvar m;
    generate
        for (m = 0; m < `SOURCES; m = m + 1) begin : source
            spec_code_of_source #(.NUMBER(m)) spec (
                .i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(chips[m]), .epoch()
            );
        end
    endgenerate
    spec_code_of_reference reference (
        .i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(), .epoch(epoch)
    );
    reg [`SOURCES-1:0] laser;
    reg first;
    always @(posedge i_clk) begin
        laser <= i_rst ? 0 : chips;
        first <= i_rst ? 0 : epoch;
    end
    always @* assert (o_laser == laser);
    always @* assert (o_epoch == first);
    // What the controller waits for, where a scan waits for an epoch.
    wire epoch_seen;
    generate
        if (`REALIGNS) begin : awaited
            always @* assert (epoch_seen == epoch);
        end
    endgenerate
    `REACHES(o_epoch & ~i_rst)
endmodule

// The words of a histogram's frames: row, code period, and what reaches the memories with and
// behind a word.
module spec_frame_words #(
    parameter ROW_BITS = 1
) (
    input wire i_clk,
    input wire i_rst,
    output wire first,
    output wire ends_frame,
    output reg [6*ROW_BITS-1:0] rows_before,
    output wire holds
);
    localparam PERIOD_BITS = `PERIODS > 2 ? $clog2(`PERIODS) : 1;
    // Of the design's control.
    wire run_seen, first_seen, ahead_is_last_seen, row_is_last_seen, period_is_last_seen;
    wire come_first_seen, held_first_seen, added_first_seen;
    wire [ROW_BITS-1:0] row_seen, ahead_seen;
    wire [6*ROW_BITS-1:0] rows_seen;
    wire [PERIOD_BITS-1:0] period_seen;
    wire [5:1] firsts_seen;

    // Row of the present word, and code period of its frame, counted from 0.
    reg running;
    reg began;
    reg [ROW_BITS-1:0] row;
    wire ends_period = began & row == `ROWS - 1;
    always @(posedge i_clk) begin
        running <= i_rst ? 1'b0 : 1'b1;
        began <= i_rst ? 1'b0 : running;
        row <= i_rst | ends_period ? 0 : row + began;
    end
    wire period_holds;
    generate
        if (`PERIODS == 1) begin : single
            assign first = 1'b1;
            assign ends_frame = ends_period;
            assign period_holds = 1'b1;
        end else begin : several
            reg [PERIOD_BITS-1:0] period;
            reg last_before;
            assign first = period == 0;
            assign ends_frame = ends_period & period == `PERIODS - 1;
            always @(posedge i_clk) begin
                period <= i_rst | ends_frame ? 0 : period + ends_period;
                last_before <= i_rst ? 1'b0 : period == `PERIODS - 1;
            end
            // The design counts up to all ones, from where these are as many code periods.
            wire [PERIOD_BITS-1:0] period_in_design = period - `PERIODS;
            assign period_holds = (period <= `PERIODS - 1)
                & (began | period == 0)
                & (period_seen == period_in_design)
                & (period_is_last_seen == last_before)
                & (row == 0 | last_before == (period == `PERIODS - 1));
        end
    endgenerate

    // The same of the words before it.
    reg [5:1] firsts;
    always @(posedge i_clk) begin
        rows_before <= i_rst ? 0 : {rows_before, row};
        firsts <= i_rst ? 5'h1f : {firsts, first};
    end
    assign holds = (run_seen == running)
        & (row_seen == row)
        & (row <= `ROWS - 1)
        & (running | ~began)
        & (began | row == 0)
        // The counter is a clock ahead.
        & (ahead_seen == (~began | ends_period ? 0 : row + 1))
        & (ahead_is_last_seen == (ahead_seen == `ROWS - 1))
        & (row_is_last_seen == (row == `ROWS - 1))
        & (first_seen == first) & period_holds
        & (rows_seen == rows_before)
        & (firsts_seen == firsts)
        & (`TAKES_TURNS | come_first_seen == firsts[2])
        & (held_first_seen == firsts[3])
        & (added_first_seen == firsts[5]);
endmodule

// Words count from the second clock after reset on: a row each, so many rows a code period, so many
// code periods a frame, one behind the other without a pause. Row and first code period reach the
// memories after a fixed number of clocks.
module prove_scan (
    `INPUTS
);
    `DESIGN
    wire holds;
    spec_frame_words #(.ROW_BITS(`ROW_BITS)) words (
        .i_clk(i_clk), .i_rst(i_rst), .first(), .ends_frame(), .rows_before(), .holds(holds)
    );
    `HOLDS_BEHIND(1, holds)
    `REACHES(clocks == 1 & held)
endmodule

// Two memories: a frame that ends when all rows of the one before have been taken, or with the
// clock that takes the last, is read whole: each row once, in order, detector 0's, then detector
// 1's, ..., tlast at the last and nowhere else. Any other is lost, whole. Memories change places
// with each frame that is read, and with no other. o_overrun rises if and only if a frame is lost,
// and stays.
//
// One memory: behind a whole frame its rows come one a clock, in order, tlast at the last and
// nowhere else. One that comes while another waits that is not taken is lost. o_overrun rises if
// and only if a row is lost, and stays until reset.
module prove_stream (
    `INPUTS
);
    `DESIGN
    localparam ALL = `ROWS * `DETECTORS;
    // Clocks from the end of a frame to its first row; and from a word that comes of a single
    // memory until its row may be taken.
    localparam TO_ROW = 4;
    localparam TO_COME = 3;
    localparam BITS = $clog2(ALL + TO_ROW + 2);

    wire first, ends_frame, words_hold, stream_holds;
    wire [6*`ROW_BITS-1:0] rows_before;
    spec_frame_words #(.ROW_BITS(`ROW_BITS)) words (
        .i_clk(i_clk), .i_rst(i_rst), .first(first), .ends_frame(ends_frame),
        .rows_before(rows_before), .holds(words_hold)
    );

    // Of the design's control.
    wire half_seen, come_half_seen, held_half_seen, write_half_seen, room_seen, reads_seen;
    wire read_is_last_seen, go_seen, shows_seen, follows_seen;
    wire [6:1] halves_seen;
    wire [`ROW_BITS-1:0] read_row_seen;
    wire [`DETECTORS-1:0] detector_seen;
    wire [2:0] out_seen, last_out_seen;
    wire [3*`DETECTORS-1:0] detector_out_seen;
    wire [TO_COME:1] wholes_seen;
    wire [TO_COME-1:0] lasts_seen;

    reg lost;
    wire loses;
    always @(posedge i_clk) lost <= i_rst ? 1'b0 : lost | loses;
    genvar d, s;
    generate
        if (`TAKES_TURNS) begin : two_memories
            // Rows of the frame that is read that are still to be taken, and clocks until the first
            // stands.
            reg [BITS-1:0] left;
            reg [2:0] pause;
            reg half;
            reg [6:1] halves;
            wire stands = left != 0 & pause == 0;
            wire taken = stands & m_axis_tready;
            wire free = left == 0 | (left == 1 & taken);
            wire is_read = ends_frame & free;
            assign loses = ends_frame & ~free;
            always @(posedge i_clk) begin
                left <= i_rst ? 0 : is_read ? ALL : left - taken;
                pause <= i_rst ? 0 : is_read ? TO_ROW : pause - (pause != 0);
                half <= i_rst ? 1'b0 : half ^ is_read;
                halves <= i_rst ? 0 : {halves, half};
            end
            // The row of the frame that is asked for, counted through all detectors.
            wire [BITS-1:0] asked = ALL - left + TO_ROW - pause;
            wire asks = left != 0 & asked < ALL;
            // Rows on their way out of the memories.
            wire [2:0] flies;
            wire [2:0] out_holds;
            wire [`DETECTORS-1:0] asked_holds;
            for (d = 0; d < `DETECTORS; d = d + 1) begin : asked_of
                wire other = ~asks | asked < d * `ROWS | asked >= (d + 1) * `ROWS;
                assign asked_holds[d] = (other | read_row_seen == asked - d * `ROWS)
                    & (other | read_is_last_seen == (asked == (d + 1) * `ROWS - 1))
                    & (`DETECTORS == 1 | other | detector_seen == 1 << d);
            end
            for (s = 0; s < 3; s = s + 1) begin : stage
                assign flies[s] =
                    left != 0 & pause <= TO_ROW - 1 - s & asked - (s + 1) < ALL;
                wire [`DETECTORS-1:0] detector_holds;
                for (d = 0; d < `DETECTORS; d = d + 1) begin : out_of
                    assign detector_holds[d] = `DETECTORS == 1 | ~flies[s]
                        | asked < d * `ROWS + s + 1 | asked >= (d + 1) * `ROWS + s + 1
                        | detector_out_seen[s*`DETECTORS +: `DETECTORS] == 1 << d;
                end
                assign out_holds[s] = (out_seen[s] == flies[s])
                    & (last_out_seen[s] == (flies[s] & asked - (s + 1) == ALL - 1))
                    & (&detector_holds);
            end
            assign stream_holds = (m_axis_tvalid == stands)
                & (~stands | m_axis_tlast == (left == 1))
                & (left <= ALL & (pause == 0 | left == ALL))
                & (pause <= TO_ROW)
                & (half_seen == half)
                & (halves_seen == halves)
                & (come_half_seen == halves[2])
                & (held_half_seen == halves[3])
                & (write_half_seen == halves[6])
                & (room_seen == ~stands)
                & (reads_seen == asks)
                & (asks | (read_row_seen == 0 & ~read_is_last_seen))
                & (`DETECTORS == 1 | asks | detector_seen == 1)
                & (&asked_holds) & (&out_holds)
                & (go_seen == (~stands | m_axis_tready))
                & (shows_seen == (go_seen & flies[2]));
        end else begin : one_memory
            // A whole frame is in the memory; its rows come some clocks behind the words that find
            // them.
            reg follows;
            reg [TO_COME:1] wholes;
            reg stands;
            reg is_last;
            wire comes = wholes[TO_COME];
            wire free = ~stands | m_axis_tready;
            assign loses = comes & ~free;
            wire [TO_COME:1] lasts;
            for (s = 1; s <= TO_COME; s = s + 1) begin : row
                assign lasts[s] = rows_before[(s-1)*`ROW_BITS +: `ROW_BITS] == `ROWS - 1;
            end
            always @(posedge i_clk) begin
                follows <= i_rst ? 1'b0 : follows | ends_frame;
                wholes <= i_rst ? 0 : {wholes, follows & first};
                stands <= i_rst ? 1'b0 : comes | ~free;
                is_last <= i_rst ? 1'b0 : comes & free ? lasts[TO_COME] : is_last;
            end
            assign stream_holds = (m_axis_tvalid == stands)
                & (m_axis_tlast == is_last)
                & (shows_seen == (comes & free))
                & (room_seen == ~stands)
                & (follows_seen == follows)
                & (wholes_seen == wholes)
                & (lasts_seen == lasts);
        end
    endgenerate
    wire holds = words_hold & stream_holds & (o_overrun == lost);
    `HOLDS_BEHIND(1, holds)
    `REACHES(clocks == 1 & held & loses)
endmodule

// In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken
// or reset. Flags stay until reset, the peak's ports until o_peak_valid.
module prove_axis (
    `INPUTS
);
    `DESIGN
    reg began = 1'b0;
    reg reset_before;
    reg waited;
    reg held_last;
    reg overran;
    reg [`DATA_BITS-1:0] held_data;
    always @(posedge i_clk) begin
        began <= 1'b1;
        reset_before <= i_rst;
        waited <= m_axis_tvalid & ~m_axis_tready;
        held_last <= m_axis_tlast;
        held_data <= m_axis_tdata;
        overran <= o_overrun;
    end
    wire stays = began & ~reset_before;
    always @* if (stays & waited) assert (m_axis_tvalid);
    always @* if (stays & waited) assert (m_axis_tlast == held_last);
    always @* if (stays & waited) assert (m_axis_tdata == held_data);
    always @* if (stays & overran) assert (o_overrun);
    always @* if (~stays) assert (o_laser == 0);
    always @* if (~stays) assert (o_epoch == 0);
    always @* if (~stays) assert (m_axis_tdata == 0);
    always @* if (~stays) assert (m_axis_tvalid == 0);
    always @* if (~stays) assert (m_axis_tlast == 0);
    always @* if (~stays) assert (o_overrun == 0);
    generate
        if (`SATURATES) begin : saturation
            reg saturated;
            always @(posedge i_clk) saturated <= o_saturated;
            always @* if (stays & saturated) assert (o_saturated);
            always @* if (~stays) assert (o_saturated == 0);
        end
        if (`FINDS_PEAK) begin : peaks
            reg [`DETECTORS*(`PEAK_STEP_BITS+`COUNT_BITS)-1:0] peak;
            always @(posedge i_clk) peak <= {o_peak_step, o_peak_count};
            always @* if (stays & ~o_peak_valid) assert ({o_peak_step, o_peak_count} == peak);
            always @* if (~stays) assert (o_peak_step == 0);
            always @* if (~stays) assert (o_peak_count == 0);
            always @* if (~stays) assert (o_peak_valid == 0);
        end
    endgenerate
    `REACHES(stays & waited & overran)
endmodule

`default_nettype wire

// What sensor_top has to do: a module for each proof of sensor_top.sby
//
// Each has the design, a specification of its own, and assertions. Registers start as one clock
// of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any
// time. Outputs of modules inside are seen, or cut and driven by the proof, by sensor_top.sby.
//
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module code_of_source_0 (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    reg [10:0] u;
    reg [10:0] v;
    always @* assert (u != 0);
    always @* assert (v != 0);
    assign chip = u[0] ^ v[0];
    assign epoch = u == 11'h7ff;
    always @(posedge i_clk) begin
        if (i_rst | load) u <= 11'h7ff;
        else if (advance) u <= {u[0] ^ u[9], u[10:1]};
        if (i_rst | load) v <= 11'h7ff;
        else if (advance) v <= {v[0] ^ v[3] ^ v[6] ^ v[9], v[10:1]};
    end
endmodule

module code_of_reference (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    reg [10:0] u;
    reg [10:0] v;
    always @* assert (u != 0);
    always @* assert (v != 0);
    assign chip = u[0] ^ v[0];
    assign epoch = u == 11'h7ff;
    always @(posedge i_clk) begin
        if (i_rst | load) u <= 11'h7ff;
        else if (advance) u <= {u[0] ^ u[9], u[10:1]};
        if (i_rst | load) v <= 11'h7ff;
        else if (advance) v <= {v[0] ^ v[3] ^ v[6] ^ v[9], v[10:1]};
    end
endmodule

// With i_rst high every register's next value is the one that the other proofs start from, whatever
// the registers hold: one clock of reset leaves nothing of the state before, and no X. (The
// assertions are those of registers.v, one for each register.)
// What a block_memory gives is anything, at any clock.
module prove_reset (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(1'b1),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

endmodule

// After reset every laser shows its source's code, chip by chip, and o_epoch the first chip of
// the reference's. No LFSR reaches zero. (That an LFSR comes back to its first state after
// 2^n - 1 chips and not before is a matter of its polynomial, not of the design.)
// What a block_memory gives is anything, at any clock.
module prove_codes (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(i_rst),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

    wire chips;
    code_of_source_0 spec_code_of_source_0 (.i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(chips), .epoch());
    wire epoch;
    code_of_reference spec_code_of_reference (.i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(), .epoch(epoch));
    reg laser;
    reg first;
    always @(posedge i_clk) begin
        laser <= i_rst ? 0 : chips;
        first <= i_rst ? 0 : epoch;
    end
    always @* assert (o_laser == laser);
    always @* assert (o_epoch == first);
`ifdef COVER
    always @* assume (~((o_epoch & ~i_rst)));
`endif
endmodule

// Words count from the second clock after reset on: a row each, 2047 rows a code period, 7 code
// periods a frame, one behind the other without a pause. Row and first code period reach the
// memories after a fixed number of clocks.
// What a histogram_channel gives is anything, at any clock.
// What a block_memory gives is anything, at any clock.
module prove_scan (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    wire first_seen;
    wire [2:0] period_seen;
    wire period_is_last_seen;
    wire run_seen;
    wire [10:0] row_seen;
    wire [10:0] ahead_seen;
    wire ahead_is_last_seen;
    wire row_is_last_seen;
    wire [10:0] row_1_seen;
    wire [10:0] row_2_seen;
    wire [10:0] row_3_seen;
    wire [10:0] row_4_seen;
    wire [10:0] row_5_seen;
    wire [10:0] row_6_seen;
    wire [4:0] firsts_seen;
    wire held_first_seen;
    wire added_first_seen;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(i_rst),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

    // Row of the present word, and code period of its frame, counted from 0.
    reg running;
    reg began;
    reg [10:0] row;
    wire ends_period = began & row == 11'h7fe;
    always @(posedge i_clk) begin
        running <= i_rst ? 1'b0 : 1'b1;
        began <= i_rst ? 1'b0 : running;
        row <= i_rst | ends_period ? 0 : row + began;
    end
    reg [2:0] period;
    reg last_before;
    wire first = period == 0;
    wire ends_frame = ends_period & period == 3'h6;
    always @(posedge i_clk) begin
        period <= i_rst | ends_frame ? 0 : period + ends_period;
        last_before <= i_rst ? 1'b0 : period == 3'h6;
    end
    wire [2:0] period_in_design = period + 3'h1;
    // The same of the words before it.
    reg [65:0] rows_before;
    reg [5:1] firsts;
    always @(posedge i_clk) begin
        rows_before <= i_rst ? 0 : {rows_before, row};
        firsts <= i_rst ? 5'h1f : {firsts, first};
    end

    // What holds at every clock.
    wire [22:0] holds;
    assign holds[0] = first_seen == first;
    assign holds[1] = period <= 3'h6;
    assign holds[2] = began | period == 0;
    assign holds[3] = period_seen == period_in_design;
    assign holds[4] = period_is_last_seen == last_before;
    assign holds[5] = row == 0 | last_before == (period == 3'h6);
    assign holds[6] = run_seen == running;
    assign holds[7] = row_seen == row;
    assign holds[8] = row <= 11'h7fe;
    assign holds[9] = running | ~began;
    assign holds[10] = began | row == 0;
    assign holds[11] = ahead_seen == (~began | ends_period ? 0 : row + 11'd1);
    assign holds[12] = ahead_is_last_seen == (ahead_seen == 11'h7fe);
    assign holds[13] = row_is_last_seen == (row == 11'h7fe);
    assign holds[14] = row_1_seen == rows_before[10:0];
    assign holds[15] = row_2_seen == rows_before[21:11];
    assign holds[16] = row_3_seen == rows_before[32:22];
    assign holds[17] = row_4_seen == rows_before[43:33];
    assign holds[18] = row_5_seen == rows_before[54:44];
    assign holds[19] = row_6_seen == rows_before[65:55];
    assign holds[20] = firsts_seen == firsts;
    assign holds[21] = held_first_seen == firsts[3];
    assign holds[22] = added_first_seen == firsts[5];
    // Registers are anything at first, but such that all of it holds for 1 clock.
    reg clocks = 0;
    reg held;
    always @(posedge i_clk) begin
        clocks <= clocks + (clocks != 1);
        held <= (held | clocks == 0) & (&holds);
    end
    always @* if (clocks == 1 & held) assert (&holds);
`ifdef COVER
    always @* assume (~((clocks == 1 & held)));
`endif
endmodule

// A frame that ends when all rows of the one before have been taken, or with the clock that takes
// the last, is read whole: each row once, in order, detector 0's, then detector 1's, ..., tlast at
// the last and nowhere else. Any other is lost, whole. Memories change places with each frame
// that is read, and with no other. o_overrun rises if and only if a frame is lost, and stays.
// What a histogram_channel gives is anything, at any clock.
// What a block_memory gives is anything, at any clock.
module prove_stream (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    wire first_seen;
    wire [2:0] period_seen;
    wire period_is_last_seen;
    wire run_seen;
    wire [10:0] row_seen;
    wire [10:0] ahead_seen;
    wire ahead_is_last_seen;
    wire row_is_last_seen;
    wire [10:0] row_1_seen;
    wire [10:0] row_2_seen;
    wire [10:0] row_3_seen;
    wire [10:0] row_4_seen;
    wire [10:0] row_5_seen;
    wire [10:0] row_6_seen;
    wire [4:0] firsts_seen;
    wire held_first_seen;
    wire added_first_seen;
    wire half_seen;
    wire [5:0] halves_seen;
    wire come_half_seen;
    wire held_half_seen;
    wire write_half_seen;
    wire room_seen;
    wire reads_seen;
    wire [10:0] read_row_seen;
    wire read_is_last_seen;
    wire [2:0] out_seen;
    wire [2:0] last_out_seen;
    wire go_seen;
    wire shows_seen;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(i_rst),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

    // Row of the present word, and code period of its frame, counted from 0.
    reg running;
    reg began;
    reg [10:0] row;
    wire ends_period = began & row == 11'h7fe;
    always @(posedge i_clk) begin
        running <= i_rst ? 1'b0 : 1'b1;
        began <= i_rst ? 1'b0 : running;
        row <= i_rst | ends_period ? 0 : row + began;
    end
    reg [2:0] period;
    reg last_before;
    wire first = period == 0;
    wire ends_frame = ends_period & period == 3'h6;
    always @(posedge i_clk) begin
        period <= i_rst | ends_frame ? 0 : period + ends_period;
        last_before <= i_rst ? 1'b0 : period == 3'h6;
    end
    wire [2:0] period_in_design = period + 3'h1;
    // The same of the words before it.
    reg [65:0] rows_before;
    reg [5:1] firsts;
    always @(posedge i_clk) begin
        rows_before <= i_rst ? 0 : {rows_before, row};
        firsts <= i_rst ? 5'h1f : {firsts, first};
    end
    // Rows of the frame that is read that are still to be taken, and clocks until the first stands.
    reg [11:0] left;
    reg [2:0] pause;
    reg half;
    reg [6:1] halves;
    reg lost;
    wire stands = left != 0 & pause == 0;
    wire taken = stands & m_axis_tready;
    wire free = left == 0 | (left == 1 & taken);
    wire is_read = ends_frame & free;
    always @(posedge i_clk) begin
        left <= i_rst ? 0 : is_read ? 12'h7ff : left - taken;
        pause <= i_rst ? 0 : is_read ? 3'd4 : pause - (pause != 0);
        half <= i_rst ? 1'b0 : half ^ is_read;
        halves <= i_rst ? 0 : {halves, half};
        lost <= i_rst ? 1'b0 : lost | (ends_frame & ~free);
    end
    // The row of the frame that is asked for, counted through all detectors.
    wire [11:0] asked = 12'h7ff - left + 12'd4 - pause;
    wire asks = left != 0 & asked < 12'h7ff;
    wire flies_0 = left != 0 & pause <= 3 & asked - 1 < 12'h7ff;
    wire flies_1 = left != 0 & pause <= 2 & asked - 2 < 12'h7ff;
    wire flies_2 = left != 0 & pause <= 1 & asked - 3 < 12'h7ff;

    // What holds at every clock.
    wire [45:0] holds;
    assign holds[0] = first_seen == first;
    assign holds[1] = period <= 3'h6;
    assign holds[2] = began | period == 0;
    assign holds[3] = period_seen == period_in_design;
    assign holds[4] = period_is_last_seen == last_before;
    assign holds[5] = row == 0 | last_before == (period == 3'h6);
    assign holds[6] = run_seen == running;
    assign holds[7] = row_seen == row;
    assign holds[8] = row <= 11'h7fe;
    assign holds[9] = running | ~began;
    assign holds[10] = began | row == 0;
    assign holds[11] = ahead_seen == (~began | ends_period ? 0 : row + 11'd1);
    assign holds[12] = ahead_is_last_seen == (ahead_seen == 11'h7fe);
    assign holds[13] = row_is_last_seen == (row == 11'h7fe);
    assign holds[14] = row_1_seen == rows_before[10:0];
    assign holds[15] = row_2_seen == rows_before[21:11];
    assign holds[16] = row_3_seen == rows_before[32:22];
    assign holds[17] = row_4_seen == rows_before[43:33];
    assign holds[18] = row_5_seen == rows_before[54:44];
    assign holds[19] = row_6_seen == rows_before[65:55];
    assign holds[20] = firsts_seen == firsts;
    assign holds[21] = held_first_seen == firsts[3];
    assign holds[22] = added_first_seen == firsts[5];
    assign holds[23] = m_axis_tvalid == stands;
    assign holds[24] = ~stands | m_axis_tlast == (left == 1);
    assign holds[25] = o_overrun == lost;
    assign holds[26] = left <= 12'h7ff & (pause == 0 | left == 12'h7ff);
    assign holds[27] = pause <= 4;
    assign holds[28] = half_seen == half;
    assign holds[29] = halves_seen == halves;
    assign holds[30] = come_half_seen == halves[2];
    assign holds[31] = held_half_seen == halves[3];
    assign holds[32] = write_half_seen == halves[6];
    assign holds[33] = room_seen == ~stands;
    assign holds[34] = reads_seen == asks;
    assign holds[35] = asks | (read_row_seen == 0 & ~read_is_last_seen);
    assign holds[36] = ~asks | asked < 0 | asked >= 2047 | read_row_seen == asked - 0;
    assign holds[37] = ~asks | asked < 0 | asked >= 2047 | read_is_last_seen == (asked == 2046);
    assign holds[38] = out_seen[0] == flies_0;
    assign holds[39] = last_out_seen[0] == (flies_0 & asked - 1 == 12'h7ff - 1);
    assign holds[40] = out_seen[1] == flies_1;
    assign holds[41] = last_out_seen[1] == (flies_1 & asked - 2 == 12'h7ff - 1);
    assign holds[42] = out_seen[2] == flies_2;
    assign holds[43] = last_out_seen[2] == (flies_2 & asked - 3 == 12'h7ff - 1);
    assign holds[44] = go_seen == (~stands | m_axis_tready);
    assign holds[45] = shows_seen == (go_seen & flies_2);
    // Registers are anything at first, but such that all of it holds for 1 clock.
    reg clocks = 0;
    reg held;
    always @(posedge i_clk) begin
        clocks <= clocks + (clocks != 1);
        held <= (held | clocks == 0) & (&holds);
    end
    always @* if (clocks == 1 & held) assert (&holds);
`ifdef COVER
    always @* assume (~((clocks == 1 & held) & (ends_frame & ~free)));
`endif
endmodule

// In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken
// or reset. Flags stay until reset, the peak's ports until o_peak_valid.
// What a block_memory gives is anything, at any clock.
module prove_axis (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(i_rst),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

    reg began = 1'b0;
    reg reset_before;
    reg waited;
    reg held_last;
    reg overran;
    always @(posedge i_clk) begin
        began <= 1'b1;
        reset_before <= i_rst;
        waited <= m_axis_tvalid & ~m_axis_tready;
        held_last <= m_axis_tlast;
        overran <= o_overrun;
    end
    wire stays = began & ~reset_before;
    always @* if (stays & waited) assert (m_axis_tvalid);
    always @* if (stays & waited) assert (m_axis_tlast == held_last);
    always @* if (stays & overran) assert (o_overrun);
    always @* if (~stays) assert (o_laser == 0);
    always @* if (~stays) assert (o_epoch == 0);
    always @* if (~stays) assert (m_axis_tdata == 0);
    always @* if (~stays) assert (m_axis_tvalid == 0);
    always @* if (~stays) assert (m_axis_tlast == 0);
    always @* if (~stays) assert (o_overrun == 0);
    reg [63:0] held_data;
    always @(posedge i_clk) held_data <= m_axis_tdata;
    always @* if (stays & waited) assert (m_axis_tdata == held_data);
`ifdef COVER
    always @* assume (~((stays & waited & overran)));
`endif
endmodule

`default_nettype wire

// histogram_control: rows and frames of the histogram
//
// A frame ends with the last row of its last code period. If all rows of the frame before it
// have been taken, or the last is taken at that clock's edge, the memories change places and it
// is read. If not it is lost, whole, and counts begin anew in its memory.
//
// o_overrun stays high until reset.
//
// Frame    7 code periods of 2047 chips
// Latency  5 clocks from a frame's last word to o_valid
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module histogram_control (
    input  wire        i_clk, i_rst,

    input  wire        i_ready,       // the receiver takes a row

    output reg         o_run,         // words count from now on

    // Row, memory and first code period of a word on its way
    output reg  [10:0] o_row,         // row of the present word
    output reg         o_half,        // memory that counts it
    output wire        o_come_half,   // memory of the word two clocks ago
    // the word three clocks ago is one of a frame's first code period
    output wire        o_held_first,
    output wire        o_held_half,   // memory of the word three clocks ago
    // the word five clocks ago is one of a frame's first code period
    output wire        o_added_first,
    output wire [10:0] o_write_row,   // row of the word six clocks ago
    output wire        o_write_half,  // its memory

    // Reader
    output reg  [10:0] o_read_row,    // row to be read
    output wire        o_go,          // it goes on
    output wire        o_shows,       // a row comes to the stream

    output reg         o_valid,       // a row waits
    output reg         o_last,        // it is the frame's last
    output reg         o_overrun      // a frame was lost
);

    localparam [10:0] LAST_ROW_BUT_ONE = 11'd2045; // the row before the last
    // the first code period of a frame, so that the last is all ones
    localparam [2:0]  FIRST_PERIOD     = 3'd1;

    reg  [10:0] ahead_r;          // row of the next word
    reg         ahead_is_last_r;  // the next word's row is the last
    reg         row_is_last_r;    // the present word's row is the last
    reg  [2:0]  period_r;         // code period of the frame
    reg         period_is_last_r; // the present code period is the frame's last
    reg         first_r;          // the first code period of a frame
    reg  [65:0] row_before_r;     // rows of the words 1 to 6 clocks ago
    reg  [5:0]  half_before_r;    // memory of the words 1 to 6 clocks ago
    reg  [4:0]  first_before_r;   // whether the words 1 to 5 clocks ago are of a first code period
    reg         reads_r;          // rows are read
    reg         read_is_last_r;   // the row that is read is the last
    // a row is in the memories, comes out of them, and is in the register behind them
    reg  [2:0]  out_r;
    reg  [2:0]  last_out_r;       // it is a frame's last
    reg         room_r;           // none waits

    wire       ends = row_is_last_r & period_is_last_r; // the last row of a frame
    // the next one, and above it whether the present one is all ones
    wire [3:0] next_period = {1'b0, period_r} + 4'd1;
    wire       busy = reads_r | (|out_r) | ~o_go; // rows of the frame before are still to be taken

    assign o_held_first = first_before_r[2];
    assign o_added_first = first_before_r[4];
    assign o_write_row = row_before_r[65:55];
    assign o_come_half = half_before_r[1];
    assign o_held_half = half_before_r[2];
    assign o_write_half = half_before_r[5];
    assign o_go = room_r | i_ready;
    assign o_shows = o_go & out_r[2];

    always @(posedge i_clk)
        if (i_rst) begin
            {o_run, ahead_r, ahead_is_last_r, o_row, row_is_last_r, period_is_last_r, o_half,
            row_before_r, half_before_r, reads_r, o_read_row, read_is_last_r, out_r, last_out_r,
            o_valid, o_last, o_overrun} <= 0;
            period_r <= FIRST_PERIOD;
            first_r <= 1'b1;
            first_before_r <= {5{1'b1}};
            room_r <= 1'b1;
        end else begin
            o_run <= 1'b1;
            ahead_is_last_r <= ahead_r == LAST_ROW_BUT_ONE;
            if (o_run) ahead_r <= ahead_r + 11'd1;
            if (ahead_is_last_r) ahead_r <= 11'd0;
            o_row <= ahead_r;
            row_is_last_r <= ahead_is_last_r;
            period_is_last_r <= next_period[3];
            if (row_is_last_r) begin
                first_r <= period_is_last_r;
                period_r <= next_period[2:0];
            end
            if (ends) period_r <= FIRST_PERIOD;
            row_before_r <= {row_before_r[54:0], o_row};
            first_before_r <= {first_before_r[3:0], first_r};
            half_before_r <= {half_before_r[4:0], o_half};
            if (o_go) begin
                out_r <= {out_r[1:0], reads_r};
                last_out_r <= {last_out_r[1:0], read_is_last_r};
                o_valid <= out_r[2];
                room_r <= ~out_r[2];
                if (out_r[2]) o_last <= last_out_r[2];
                if (reads_r) begin
                    read_is_last_r <= o_read_row == LAST_ROW_BUT_ONE;
                    o_read_row <= o_read_row + 11'd1;
                    if (read_is_last_r) o_read_row <= 11'd0;
                    reads_r <= ~read_is_last_r;
                end
            end
            if (ends & ~busy) begin
                o_half <= ~o_half;
                reads_r <= 1'b1;
            end
            if (ends & busy) o_overrun <= 1'b1;
        end

endmodule

`default_nettype wire

// bin_bank: a histogram's bins of one sample of the chip, twice
//
// One memory counts while the other is read. A word's bin is read, goes to the adder that
// neighbouring samples share, and is written when it comes back. In a frame's first code period
// every bin is written, 0 where there was no hit, so that counts begin anew.
//
// Memory   2 x 2047 bins of 3 bits
// Latency  2 clocks from i_row to o_counted and from i_read_row to o_read; written 6 clocks
//          after i_row
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module bin_bank (
    input  wire        i_clk,
    input  wire        i_rst,

    // Rows
    input  wire [10:0] i_row,          // row of the present word
    input  wire        i_half,         // memory that counts the present word
    input  wire [10:0] i_read_row,     // row to be read from the other memory
    input  wire        i_go,           // the reader goes on
    input  wire        i_counted_half, // memory of the word that reaches o_counted

    // What is written
    input  wire        i_hit,          // the word has its hit here
    input  wire        i_first,        // it is one of a frame's first code period
    input  wire        i_lowest,       // lowest bit of the bin with its hit
    input  wire [1:0]  i_above,        // the bits above it, a clock later
    input  wire [10:0] i_write_row,    // its row, a clock later
    input  wire        i_write_half,   // its memory, a clock later

    output wire [2:0]  o_counted,      // bin of the row that was counted
    output wire [2:0]  o_read          // bin of the row that was read
);

    reg  [2:0] held_0_r;   // bin out of memory 0
    reg  [2:0] held_1_r;   // bin out of memory 1
    reg        writes_r;   // to be written
    reg        lowest_r;   // lowest bit of what is written
    reg  [2:0] memory_0_q;
    reg  [2:0] memory_1_q;
    // memories that go on: the one that counts, and the other with its reader
    wire [1:0] goes;
    wire [2:0] written;    // what is written

    assign o_counted = i_counted_half ? held_1_r : held_0_r;
    assign o_read = i_half ? held_0_r : held_1_r;
    assign goes = {i_go | i_half, i_go | ~i_half};
    assign written = {i_above, lowest_r};

    always @(posedge i_clk) begin
        if (i_rst) begin
            held_0_r <= 3'd0;
            held_1_r <= 3'd0;
            writes_r <= 1'b0;
            lowest_r <= 1'b0;
        end else begin
            writes_r <= i_hit | i_first;
            lowest_r <= i_lowest;
            if (i_first) begin
                lowest_r <= i_hit;
            end
            if (goes[0]) begin
                held_0_r <= memory_0_q;
            end
            if (goes[1]) begin
                held_1_r <= memory_1_q;
            end
        end
    end

    // No word is used that is read at the clock that writes it.
    (* no_rw_check *)
    reg [2:0] memory_0 [0:2046]; // Bins of memory 0, one for each row
    always @(posedge i_clk) begin
        if (writes_r & ~i_write_half)
            memory_0[i_write_row] <= written;
        if (goes[0])
            memory_0_q <= memory_0[i_half ? i_read_row : i_row];
    end

    // No word is used that is read at the clock that writes it.
    (* no_rw_check *)
    reg [2:0] memory_1 [0:2046]; // Bins of memory 1, one for each row
    always @(posedge i_clk) begin
        if (writes_r & i_write_half)
            memory_1[i_write_row] <= written;
        if (goes[1])
            memory_1_q <= memory_1[i_half ? i_row : i_read_row];
    end

endmodule

`default_nettype wire

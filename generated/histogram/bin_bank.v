// bin_bank: a histogram's bins of one sample of the chip, twice
//
// One memory counts while the other is read. A word's bin is read, goes to the adder that
// neighbouring samples share, and is written when it comes back. In a frame's first code period
// every bin is written, 0 where there was no hit, so that counts begin anew.
//
// Memory   2 x 2047 bins of 3 bits
// Latency  3 clocks from i_row to o_bin or o_other, and from i_read_row to o_read; written 7
//          clocks after i_row
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module bin_bank (
    input  wire        i_clk, i_rst,

    // Rows
    input  wire [10:0] i_row,        // row of the present word
    input  wire        i_half,       // memory that counts the present word
    input  wire [10:0] i_read_row,   // row to be read from the other memory
    input  wire        i_go,         // the reader goes on
    input  wire        i_come_hit,   // the word two clocks ago has its hit here
    input  wire        i_come_half,  // its memory

    // What is written
    input  wire        i_hit,        // the word has its hit here
    input  wire        i_first,      // it is one of a frame's first code period
    input  wire        i_lowest,     // lowest bit of the bin with its hit
    input  wire [1:0]  i_above,      // the bits above it, a clock later
    input  wire [10:0] i_write_row,  // its row, a clock later
    input  wire        i_write_half, // its memory, a clock later

    output reg  [2:0]  o_bin,        // bin out of memory 0; 0 if it counts and has no hit
    output reg  [2:0]  o_other,      // bin out of memory 1, as well
    output wire [2:0]  o_read        // bin of the row that was read
);

    reg         writes_r; // to be written
    reg         lowest_r; // lowest bit of what is written
    wire [21:0] memory_i_address;
    wire [5:0]  memory_word;
    wire [1:0]  memory_write;
    genvar g;

    // memories that go on: the one that counts, and the other with its reader
    wire [1:0] goes = {i_go | i_half, i_go | ~i_half};
    wire [2:0] written = {i_above, lowest_r}; // what is written

    assign memory_i_address[10:0] = i_half ? i_read_row : i_row;
    assign memory_i_address[21:11] = i_half ? i_row : i_read_row;
    assign o_read = i_half ? o_bin : o_other;
    assign memory_write[0] = writes_r & ~i_write_half;
    assign memory_write[1] = writes_r & i_write_half;

    for (g = 0; g < 2; g = g + 1) begin : gen_memory
        // bins, one for each row
        block_memory #(
            .WORDS(2047),
            .ADDRESS_BITS(11),
            .BITS(3)
        ) memory (
            .i_clk           (i_clk),
            .i_write         (memory_write[g]),
            .i_write_address (i_write_row),
            .i_data          (written),
            .i_read          (goes[g]),
            .i_address       (memory_i_address[11*g +: 11]),
            .o_word          (memory_word[3*g +: 3])
        );
    end

    always @(posedge i_clk)
        if (i_rst) begin
            {o_bin, o_other, writes_r, lowest_r} <= 0;
        end else begin
            writes_r <= i_hit | i_first;
            lowest_r <= i_hit;
            if (~i_lowest) lowest_r <= 1'b0;
            if (goes[0]) o_bin <= memory_word[2:0];
            if (goes[1]) o_other <= memory_word[5:3];
            if (~i_come_hit & ~i_come_half) o_bin <= 3'd0;
            if (~i_come_hit & i_come_half) o_other <= 3'd0;
        end

endmodule

`default_nettype wire

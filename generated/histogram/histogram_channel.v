// histogram_channel: histogram of one detector's arrival times
//
// Bins     2047 rows of 8, 3 bits each; no stimulus can overflow them
// Adders   1, each for 8 neighbouring samples
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module histogram_channel (
    input  wire        i_clk, i_rst,

    input  wire [7:0]  i_samples,     // level of the SPAD, bit 0 earliest
    input  wire        i_run,         // words count
    input  wire [10:0] i_row,         // row of the present word
    input  wire        i_half,        // memory that counts the present word
    input  wire [10:0] i_read_row,    // row to be read from the other memory
    input  wire        i_go,          // the reader goes on
    input  wire        i_come_half,   // memory of the word two clocks ago
    // the word three clocks ago is one of a frame's first code period
    input  wire        i_held_first,
    input  wire        i_held_half,   // memory of the word three clocks ago
    // the word five clocks ago is one of a frame's first code period
    input  wire        i_added_first,
    input  wire [10:0] i_write_row,   // row of the word six clocks ago
    input  wire        i_write_half,  // its memory

    output wire [63:0] o_bins         // bins of the row that was read, 8 bits each, bit 0 earliest
);

    wire [3:0]  edges_hits, edges_early;
    wire [23:0] adder_bins;

    assign o_bins = {5'd0, adder_bins[23:21], 5'd0, adder_bins[20:18], 5'd0, adder_bins[17:15],
        5'd0, adder_bins[14:12], 5'd0, adder_bins[11:9], 5'd0, adder_bins[8:6], 5'd0,
        adder_bins[5:3], 5'd0, adder_bins[2:0]};

    edge_detector edges (
        .i_clk (i_clk), .i_rst (i_rst), .i_samples (i_samples), .i_run (i_run),
        .o_hits (edges_hits), .o_early (edges_early)
    );

    bin_adder adder (
        .i_clk (i_clk), .i_rst (i_rst), .i_hits (edges_hits), .i_early (edges_early),
        .i_row (i_row), .i_half (i_half), .i_read_row (i_read_row), .i_go (i_go),
        .i_come_half (i_come_half), .i_held_first (i_held_first), .i_held_half (i_held_half),
        .i_added_first (i_added_first), .i_write_row (i_write_row),
        .i_write_half (i_write_half),
        .o_bins (adder_bins)
    );

endmodule

`default_nettype wire

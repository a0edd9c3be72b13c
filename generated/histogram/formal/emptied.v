// Modules of sensor_top of which a proof drives the outputs, or leaves them free: their ports and no more
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

`ifdef PROVE_RESET
module block_memory #(
    parameter WORDS        = 2,
    parameter ADDRESS_BITS = 1, // of the last word
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read,          // both registers go on
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);
    (* anyseq *) wire [BITS-1:0] any_o_word;
    assign o_word = any_o_word;
endmodule
`endif

`ifdef PROVE_CODES
module block_memory #(
    parameter WORDS        = 2,
    parameter ADDRESS_BITS = 1, // of the last word
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read,          // both registers go on
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);
    (* anyseq *) wire [BITS-1:0] any_o_word;
    assign o_word = any_o_word;
endmodule
`endif

`ifdef PROVE_SCAN
module block_memory #(
    parameter WORDS        = 2,
    parameter ADDRESS_BITS = 1, // of the last word
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read,          // both registers go on
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);
    (* anyseq *) wire [BITS-1:0] any_o_word;
    assign o_word = any_o_word;
endmodule
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
    (* anyseq *) wire [63:0] any_o_bins;
    assign o_bins = any_o_bins;
endmodule
`endif

`ifdef PROVE_STREAM
module block_memory #(
    parameter WORDS        = 2,
    parameter ADDRESS_BITS = 1, // of the last word
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read,          // both registers go on
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);
    (* anyseq *) wire [BITS-1:0] any_o_word;
    assign o_word = any_o_word;
endmodule
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
    (* anyseq *) wire [63:0] any_o_bins;
    assign o_bins = any_o_bins;
endmodule
`endif

`ifdef PROVE_AXIS
module block_memory #(
    parameter WORDS        = 2,
    parameter ADDRESS_BITS = 1, // of the last word
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read,          // both registers go on
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);
    (* anyseq *) wire [BITS-1:0] any_o_word;
    assign o_word = any_o_word;
endmodule
`endif

`default_nettype wire

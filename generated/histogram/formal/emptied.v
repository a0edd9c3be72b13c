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

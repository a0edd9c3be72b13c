// lookup_memory: words in lookup tables, a port that writes, one that reads without a clock
//
// Words have no value at power-up, and i_rst does not reach them. Synthesizers make distributed memory of it.
//
// Latency  0 clocks from i_address to o_word
//

`default_nettype none

module lookup_memory #(
    parameter ADDRESS_BITS = 1,
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);

    (* ram_style = "distributed" *)
    reg [BITS-1:0] words [0:(1<<ADDRESS_BITS)-1];

    assign o_word = words[i_address];

    always @(posedge i_clk)
        if (i_write) words[i_write_address] <= i_data;

endmodule

`default_nettype wire

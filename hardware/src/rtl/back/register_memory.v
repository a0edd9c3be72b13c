// register_memory: words of 32 bits, a port that writes, one that reads without a clock
//
// At power-up it holds INITIAL, word 0 lowest. Reset leaves it as it is: nothing is written in reset,
// for which the registers before it may have had no value. Synthesizers make distributed memory of it
// or, where there is none, block RAM with the register behind it.
//
// Latency  0 clocks from i_address to o_word
//

`default_nettype none

module register_memory #(
    parameter ADDRESS_BITS = 4,
    parameter [32*(1<<ADDRESS_BITS)-1:0] INITIAL = 0
) (
    input  wire                    i_clk, i_rst,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [31:0]             i_data,

    // Port that reads
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [31:0]             o_word
);

    reg [31:0] words [0:(1<<ADDRESS_BITS)-1];
    integer k;

    assign o_word = words[i_address];

    initial
        for (k = 0; k < (1 << ADDRESS_BITS); k = k + 1) words[k] = INITIAL[32*k +: 32];

    always @(posedge i_clk)
        if (i_write & ~i_rst) words[i_write_address] <= i_data;

endmodule

`default_nettype wire

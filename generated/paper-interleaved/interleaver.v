// interleaver: a code with every chip repeated and every other repetition inverted
//
// The code and its inverse take turns chip by chip (eq. 23), which removes the side lobes' mean
// from the correlation near the peak.
//
// Depth    1: each chip of the generator 2 times
// Latency  0 clocks from register to o_chip
// Made by  goldtof emit paper-interleaved.toml (goldtof 0.1.0)

`default_nettype none

module interleaver (
    input  wire i_clk, i_rst,

    input  wire i_advance, // go on to the next chip

    output wire o_chip,    // present chip
    output wire o_epoch    // the present chip is the one that reset gives
);

    localparam SUBCHIP_LOAD = 1'b0; // that reset gives

    reg  subchip_r; // repetition of the generator's chip
    wire generator_chip, generator_epoch;

    assign o_chip = generator_chip ^ subchip_r;
    assign o_epoch = generator_epoch & (subchip_r == SUBCHIP_LOAD);

    gold_generator generator (
        .i_clk (i_clk), .i_rst (i_rst),
        .i_advance (i_advance & subchip_r),
        .o_chip (generator_chip), .o_epoch (generator_epoch)
    );

    always @(posedge i_clk)
        if (i_rst) subchip_r <= SUBCHIP_LOAD;
        else if (i_advance) subchip_r <= subchip_r + 1'b1;

endmodule

`default_nettype wire

// square_generator: square wave, chips 1, 0
//
// Period   2 chips
// Latency  0 clocks from register to o_chip
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module square_generator (
    input  wire i_clk, i_rst,

    input  wire i_advance, // go on to the next chip

    output reg  o_chip,    // present chip
    output wire o_epoch    // the present chip is the one that reset gives
);

    localparam CHIP_LOAD = 1'b1; // that reset gives

    assign o_epoch = o_chip == CHIP_LOAD;

    always @(posedge i_clk)
        if (i_rst) o_chip <= CHIP_LOAD;
        else if (i_advance) o_chip <= ~o_chip;

endmodule

`default_nettype wire

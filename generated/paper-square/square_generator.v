// square_generator: square wave, chips 1, 0
//
// Period   2 chips
// Latency  0 clocks from register to o_chip
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module square_generator (
    input  wire i_clk,
    input  wire i_rst,

    input  wire i_advance, // go on to the next chip

    output reg  o_chip,    // present chip
    output wire o_epoch    // the present chip is the one that reset gives
);

    localparam CHIP_LOAD = 1'b1; // that reset gives

    assign o_epoch = o_chip == CHIP_LOAD;

    always @(posedge i_clk) begin
        if (i_rst) begin
            o_chip <= CHIP_LOAD;
        end else if (i_advance) begin
            o_chip <= ~o_chip;
        end
    end

endmodule

`default_nettype wire

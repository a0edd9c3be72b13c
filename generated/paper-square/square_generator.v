// square_generator: square wave, chips 1, 0
//
// Period   2 chips
// Latency  0 clocks from register to o_chip
// Rate     one chip per clock with i_advance high
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module square_generator (
    // Clock and reset
    input  wire  i_clk,     // one chip per cycle at most
    input  wire  i_rst,     // synchronous, active high

    // Inputs
    input  wire  i_advance, // go on to the next chip

    // Outputs
    output reg   o_chip,    // present chip
    output wire  o_epoch    // the present chip is the one that reset gives
);

    // Chip that reset gives
    localparam CHIP_LOAD = 1'b1;

    assign o_epoch = o_chip == CHIP_LOAD;

    always @(posedge i_clk) begin
        if (i_rst) begin
            o_chip <= CHIP_LOAD;
        end else begin
            if (i_advance) begin
                o_chip <= ~o_chip;
            end
        end
    end

endmodule

`default_nettype wire

// board_laser: a laser's chip from the register of its pin, on Lattice ECP5
//
// A chip lasts a whole clock, so both halves of the output gear carry it.
// In reset the core's chips are 0.

`default_nettype none

module board_laser (
    input  wire i_clk,
    input  wire i_chip,
    output wire o_pin
);

    ODDRX1F gear (
        .SCLK (i_clk),
        .RST  (1'b0),
        .D0   (i_chip),
        .D1   (i_chip),
        .Q    (o_pin)
    );

endmodule

`default_nettype wire

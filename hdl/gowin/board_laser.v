// board_laser: a laser's chip from the register of its pin, on Gowin GW1N or GW2A
//
// A chip lasts a whole clock, so both halves of the output register carry it.
// In reset the core's chips are 0.

`default_nettype none

module board_laser (
    input  wire i_clk,
    input  wire i_chip,
    output wire o_pin
);

    ODDR register (
        .CLK (i_clk),
        .TX  (1'b0),
        .D0  (i_chip),
        .D1  (i_chip),
        .Q0  (o_pin),
        .Q1  ()
    );

endmodule

`default_nettype wire

// board_laser: a laser's chip from the register of its pin, on Lattice iCE40
//
// In reset the core's chips are 0.

`default_nettype none

module board_laser (
    input  wire i_clk,
    input  wire i_chip,
    output wire o_pin
);

    SB_IO #(
        .PIN_TYPE (6'b0101_01), // output registered, always driven; plain input
        .PULLUP   (1'b0)
    ) pad (
        .PACKAGE_PIN       (o_pin),
        .LATCH_INPUT_VALUE (1'b0),
        .CLOCK_ENABLE      (1'b1),
        .INPUT_CLK         (1'b0),
        .OUTPUT_CLK        (i_clk),
        .OUTPUT_ENABLE     (1'b1),
        .D_OUT_0           (i_chip),
        .D_OUT_1           (1'b0),
        .D_IN_0            (),
        .D_IN_1            ()
    );

endmodule

`default_nettype wire

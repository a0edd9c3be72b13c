// board_laser: a laser's chip from the register of its pin, on Xilinx 7-series
//
// In reset the core's chips are 0.

`default_nettype none

module board_laser (
    input  wire i_clk,
    input  wire i_chip,
    output wire o_pin
);

    (* IOB = "TRUE" *) reg chip_r;

    always @(posedge i_clk) begin
        chip_r <= i_chip;
    end

    OBUF pad (
        .I (chip_r),
        .O (o_pin)
    );

endmodule

`default_nettype wire

// board_laser: a laser's chip from the register of its pin, on Xilinx 7-series

`default_nettype none

module board_laser (
    input  wire i_clk,
    input  wire i_rst,
    input  wire i_chip,
    output wire o_pin
);

    (* IOB = "TRUE" *) reg chip_r;

    always @(posedge i_clk) begin
        if (i_rst) begin
            chip_r <= 1'b0;
        end else begin
            chip_r <= i_chip;
        end
    end

    OBUF pad (
        .I (chip_r),
        .O (o_pin)
    );

endmodule

`default_nettype wire

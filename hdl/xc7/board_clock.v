// board_clock: the clocks of a board with AMD 7-series
//
// MMCM, bit clock of half the samples' rate on BUFIO, and the chip clock from it on BUFR: they reach
// the pins and logic of the MMCM's clock region (UG472, "I/O clock buffer", "regional clock buffer").
// VCO = oscillator x CLKFBOUT_MULT_F / DIVCLK_DIVIDE, CLKOUT0 = VCO / CLKOUT0_DIVIDE_F.

`include "board.vh"

`default_nettype none

module board_clock (
    input  wire i_oscillator,
    output wire o_fast_clk,  // bit clock
    output wire o_clk,       // one cycle is one chip
    output wire o_uart_clk,
    output wire o_ready
);

    wire oscillator;
    wire feedback;
    wire pll_clk;

    IBUF oscillator_pad (
        .I (i_oscillator),
        .O (oscillator)
    );

    BUFG uart_clock (
        .I (oscillator),
        .O (o_uart_clk)
    );

    MMCME2_BASE #(
        .CLKIN1_PERIOD    (`BOARD_OSCILLATOR_NS),
        .DIVCLK_DIVIDE    (`BOARD_PLL_INPUT_DIVIDER),
        .CLKFBOUT_MULT_F  (`BOARD_PLL_FEEDBACK),
        .CLKOUT0_DIVIDE_F (`BOARD_PLL_OUTPUT_DIVIDER)
    ) pll (
        .CLKIN1   (oscillator),
        .CLKFBIN  (feedback),
        .CLKFBOUT (feedback),
        .CLKOUT0  (pll_clk),
        .RST      (1'b0),
        .PWRDWN   (1'b0),
        .LOCKED   (o_ready)
    );

    BUFIO bit_clock (
        .I (pll_clk),
        .O (o_fast_clk)
    );

    BUFR #(
        .BUFR_DIVIDE (`BOARD_FAST_CLOCKS)
    ) chip_clock (
        .I   (pll_clk),
        .CE  (1'b1),
        .CLR (!o_ready),
        .O   (o_clk)
    );

endmodule

`default_nettype wire

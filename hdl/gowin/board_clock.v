// board_clock: the clocks of a board with Gowin GW1N or GW2A
//
// PLL, bit clock of half the samples' rate, and the chip clock from it.
// CLKOUT = oscillator x (FBDIV_SEL + 1) / (IDIV_SEL + 1), VCO = CLKOUT x ODIV_SEL (Gowin UG286, rPLL).

`include "board.vh"

`default_nettype none

module board_clock (
    input  wire i_oscillator,
    output wire o_fast_clk,  // bit clock
    output wire o_clk,       // one cycle is one chip
    output wire o_uart_clk,
    output wire o_ready
);

    assign o_uart_clk = i_oscillator;

    rPLL #(
        .DEVICE           (`BOARD_PLL_DEVICE),
        .FCLKIN           (`BOARD_OSCILLATOR_MHZ),
        .IDIV_SEL         (`BOARD_PLL_INPUT_DIVIDER - 1),
        .FBDIV_SEL        (`BOARD_PLL_FEEDBACK - 1),
        .ODIV_SEL         (`BOARD_PLL_OUTPUT_DIVIDER),
        .DYN_IDIV_SEL     ("false"),
        .DYN_FBDIV_SEL    ("false"),
        .DYN_ODIV_SEL     ("false"),
        .DYN_DA_EN        ("false"),
        .PSDA_SEL         ("0000"),
        .DUTYDA_SEL       ("1000"),
        .CLKFB_SEL        ("internal"),
        .CLKOUT_BYPASS    ("false"),
        .CLKOUTP_BYPASS   ("false"),
        .CLKOUTD_BYPASS   ("false"),
        .CLKOUTD_SRC      ("CLKOUT"),
        .CLKOUTD3_SRC     ("CLKOUT"),
        .DYN_SDIV_SEL     (2)
    ) pll (
        .CLKIN    (i_oscillator),
        .CLKFB    (1'b0),
        .RESET    (1'b0),
        .RESET_P  (1'b0),
        .FBDSEL   (6'b0),
        .IDSEL    (6'b0),
        .ODSEL    (6'b0),
        .PSDA     (4'b0),
        .DUTYDA   (4'b0),
        .FDLY     (4'b0),
        .CLKOUT   (o_fast_clk),
        .LOCK     (o_ready),
        .CLKOUTP  (),
        .CLKOUTD  (),
        .CLKOUTD3 ()
    );

    // Where dedicated wires lead from the PLL to the divider and on; nextpnr does not see to that.
    (* BEL = `BOARD_DIVIDER_BEL *)
    CLKDIV #(
        .DIV_MODE (`BOARD_FAST_CLOCKS),
        .GSREN    ("false")
    ) chip_clock (
        .HCLKIN (o_fast_clk),
        .RESETN (o_ready),
        .CALIB  (1'b0),
        .CLKOUT (o_clk)
    );

endmodule

`default_nettype wire

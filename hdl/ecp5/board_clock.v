// board_clock: the clocks of a board with Lattice ECP5
//
// PLL, edge clock of half the samples' rate at a pin, and the chip clock from it. The PLL's feedback
// is CLKOP, so CLKOP = oscillator x CLKFB_DIV / CLKI_DIV and VCO = CLKOP x CLKOP_DIV (Lattice
// FPGA-TN-02200, section 17). nextpnr follows the clocks through all of these from the oscillator's.

`include "board.vh"

`default_nettype none

module board_clock (
    input  wire i_oscillator,
    output wire o_fast_clk,  // edge clock
    output wire o_clk,       // one cycle is one chip
    output wire o_uart_clk,
    output wire o_ready
);

    wire pll_clk;

    (* FREQUENCY_PIN_CLKI = `BOARD_OSCILLATOR_MHZ *)
    (* ICP_CURRENT = "12" *)
    (* LPF_RESISTOR = "8" *)
    (* MFG_ENABLE_FILTEROPAMP = "1" *)
    (* MFG_GMCREF_SEL = "2" *)
    EHXPLLL #(
        .PLLRST_ENA       ("DISABLED"),
        .INTFB_WAKE       ("DISABLED"),
        .STDBY_ENABLE     ("DISABLED"),
        .DPHASE_SOURCE    ("DISABLED"),
        .OUTDIVIDER_MUXA  ("DIVA"),
        .OUTDIVIDER_MUXB  ("DIVB"),
        .OUTDIVIDER_MUXC  ("DIVC"),
        .OUTDIVIDER_MUXD  ("DIVD"),
        .FEEDBK_PATH      ("CLKOP"),
        .CLKI_DIV         (`BOARD_PLL_INPUT_DIVIDER),
        .CLKFB_DIV        (`BOARD_PLL_FEEDBACK),
        .CLKOP_ENABLE     ("ENABLED"),
        .CLKOP_DIV        (`BOARD_PLL_OUTPUT_DIVIDER),
        .CLKOP_CPHASE     (`BOARD_PLL_OUTPUT_DIVIDER - 1),
        .CLKOP_FPHASE     (0),
        .CLKOS_ENABLE     ("ENABLED"),
        .CLKOS_DIV        (`BOARD_UART_PLL_DIVIDER),
        .CLKOS_CPHASE     (`BOARD_UART_PLL_DIVIDER - 1),
        .CLKOS_FPHASE     (0)
    ) pll (
        .CLKI         (i_oscillator),
        .CLKFB        (pll_clk),
        .CLKOP        (pll_clk),
        .CLKOS        (o_uart_clk),
        .LOCK         (o_ready),
        .RST          (1'b0),
        .STDBY        (1'b0),
        .PHASESEL0    (1'b0),
        .PHASESEL1    (1'b0),
        .PHASEDIR     (1'b0),
        .PHASESTEP    (1'b0),
        .PHASELOADREG (1'b0),
        .PLLWAKESYNC  (1'b0),
        .ENCLKOP      (1'b1),
        .ENCLKOS      (1'b1)
    );

    ECLKSYNCB edge_clock (
        .ECLKI (pll_clk),
        .STOP  (1'b0),
        .ECLKO (o_fast_clk)
    );

    CLKDIVF #(
        .DIV ("2.0")
    ) chip_clock (
        .CLKI    (o_fast_clk),
        .RST     (!o_ready),
        .ALIGNWD (1'b0),
        .CDIVX   (o_clk)
    );

endmodule

`default_nettype wire

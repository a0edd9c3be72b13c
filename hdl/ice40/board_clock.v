// board_clock: the clocks of a board with Lattice iCE40
//
// PLL at the oscillator's pin, with the oscillator beside its output.
// Output = oscillator x (DIVF + 1) / (2^DIVQ (DIVR + 1)), VCO = output x 2^DIVQ (Lattice
// FPGA-TN-02052, "simple" feedback).

`include "board.vh"

`default_nettype none

module board_clock (
    input  wire i_oscillator,
    output wire o_fast_clk,  // that of the chips
    output wire o_clk,       // one cycle is one chip
    output wire o_uart_clk,
    output wire o_ready
);

    assign o_fast_clk = o_clk;

    SB_PLL40_2_PAD #(
        .FEEDBACK_PATH       ("SIMPLE"),
        .DIVR                (`BOARD_PLL_INPUT_DIVIDER - 1),
        .DIVF                (`BOARD_PLL_FEEDBACK - 1),
        .DIVQ                ($clog2(`BOARD_PLL_OUTPUT_DIVIDER)),
        .FILTER_RANGE        (`BOARD_PLL_FILTER),
        .PLLOUT_SELECT_PORTB ("GENCLK")
    ) pll (
        .PACKAGEPIN    (i_oscillator),
        .RESETB        (1'b1),
        .BYPASS        (1'b0),
        .PLLOUTGLOBALA (o_uart_clk),
        .PLLOUTGLOBALB (o_clk),
        .LOCK          (o_ready)
    );

endmodule

`default_nettype wire

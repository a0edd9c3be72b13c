// simulated_board: board_top for a simulation that drives the outputs of the PLL
//
// simulated_board.cpp changes the inputs: i_fast_clk at the rate that the PLL's dividers make of the
// oscillator's (o_fast_*), i_line_clk at that of the UART's clock (o_line_*; the oscillator's own, of a
// board whose UART runs on it), i_step and the pins once in a sample period. The cells' models are wired to
// these inputs by name.

`include "board.vh"

`default_nettype none

module simulated_board (
    input  wire                                                      i_fast_clk,
    input  wire                                                      i_line_clk,
    input  wire                                                      i_step,     // changes with each sample
    input  wire                                                      i_locked,   // PLL
    input  wire                                                      i_rx,
    output wire                                                      o_tx,
    input  wire [`BOARD_DETECTORS*`BOARD_PINS_PER_DETECTOR-1:0]      i_detector,
    output wire [`BOARD_LASERS-1:0]                                  o_laser,
    output wire                                                      o_led,
    output wire                                                      o_held,     // 0 of a board that holds nothing

    // What the cells' parameters make of the oscillator, and of a second pin's delay; 0 of no such cell
    output reg  [31:0]                                               o_fast_multiplier = 32'd0,
    output reg  [31:0]                                               o_fast_divider = 32'd0,
    output reg  [31:0]                                               o_line_multiplier = 32'd0,
    output reg  [31:0]                                               o_line_divider = 32'd0,
    output reg  [31:0]                                               o_delay_taps = 32'd0
`ifndef SIMULATED_BENCH
    ,
    // What the core sees, by which the simulation finds how late the gears are
    output wire                                                      o_clk,
    output wire                                                      o_rst,
    output wire [`BOARD_SAMPLES_PER_CHIP-1:0]                        o_samples   // of detector 0
`endif
);

    board_top board (
        .i_oscillator (i_line_clk),
        .i_rx         (i_rx),
        .o_tx         (o_tx),
        .i_detector   (i_detector),
        .o_laser      (o_laser),
`ifdef BOARD_HELD
        .o_held       (o_held),
`endif
        .o_led        (o_led)
    );

`ifndef BOARD_HELD
    assign o_held = 1'b0;
`endif
`ifndef SIMULATED_BENCH
    assign o_clk     = board.clk;
    assign o_rst     = board.rst;
    assign o_samples = board.samples[`BOARD_SAMPLES_PER_CHIP-1:0];
`endif

endmodule

`default_nettype wire

// Behavioural models of Lattice iCE40's cells, as far as board_clock, board_sampler and board_laser use
// them; simulated_board.v says how time goes. Written from Lattice FPGA-TN-02052 (PLL) and the iCE
// Technology Library (SB_IO).

`default_nettype none

// Port A is the oscillator, port B = oscillator x (DIVF + 1) / (2^DIVQ (DIVR + 1)).
module SB_PLL40_2_PAD #(
    parameter FEEDBACK_PATH       = "SIMPLE",
    parameter DIVR                = 0,
    parameter DIVF                = 0,
    parameter DIVQ                = 0,
    parameter FILTER_RANGE        = 0,
    parameter PLLOUT_SELECT_PORTB = "GENCLK"
) (
    input  wire PACKAGEPIN, RESETB, BYPASS,
    output wire PLLOUTGLOBALA, PLLOUTGLOBALB, LOCK
);
    assign PLLOUTGLOBALA = PACKAGEPIN;
    assign PLLOUTGLOBALB = simulated_board.i_fast_clk;
    assign LOCK          = simulated_board.i_locked;

    initial begin
        simulated_board.o_fast_multiplier = DIVF + 1;
        simulated_board.o_fast_divider    = (DIVR + 1) << DIVQ;
    end
endmodule

// Inputs registered at both edges (PIN_TYPE 0000_00), or an output registered at the rising one (0101_01).
module SB_IO #(
    parameter [5:0] PIN_TYPE = 6'd0,
    parameter       PULLUP   = 1'b0
) (
    inout  wire PACKAGE_PIN,
    input  wire LATCH_INPUT_VALUE, CLOCK_ENABLE, INPUT_CLK, OUTPUT_CLK, OUTPUT_ENABLE, D_OUT_0, D_OUT_1,
    output wire D_IN_0, D_IN_1
);
    reg at_rise, at_fall, out;
    always @(posedge INPUT_CLK) at_rise <= PACKAGE_PIN;
    always @(negedge INPUT_CLK) at_fall <= PACKAGE_PIN;
    always @(posedge OUTPUT_CLK) out <= D_OUT_0;
    assign D_IN_0 = at_rise;
    assign D_IN_1 = at_fall;

    generate
        if (PIN_TYPE == 6'b0101_01) begin : gen_output
            assign PACKAGE_PIN = out;
        end
    endgenerate
endmodule

`default_nettype wire

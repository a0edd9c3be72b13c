// Behavioural models of Lattice ECP5's cells, as far as board_clock, board_sampler and board_laser use
// them; simulated_board.v says how time goes. Written from Lattice FPGA-TN-02200 (clocks) and
// FPGA-TN-02035 (I/O).

`default_nettype none

// Feedback from CLKOP: CLKOP = CLKI x CLKFB_DIV / CLKI_DIV, VCO = CLKOP x CLKOP_DIV, CLKOS = VCO / CLKOS_DIV.
module EHXPLLL #(
    parameter PLLRST_ENA      = "",
    parameter INTFB_WAKE      = "",
    parameter STDBY_ENABLE    = "",
    parameter DPHASE_SOURCE   = "",
    parameter OUTDIVIDER_MUXA = "",
    parameter OUTDIVIDER_MUXB = "",
    parameter OUTDIVIDER_MUXC = "",
    parameter OUTDIVIDER_MUXD = "",
    parameter FEEDBK_PATH     = "",
    parameter CLKI_DIV        = 1,
    parameter CLKFB_DIV       = 1,
    parameter CLKOP_ENABLE    = "",
    parameter CLKOP_DIV       = 8,
    parameter CLKOP_CPHASE    = 0,
    parameter CLKOP_FPHASE    = 0,
    parameter CLKOS_ENABLE    = "",
    parameter CLKOS_DIV       = 8,
    parameter CLKOS_CPHASE    = 0,
    parameter CLKOS_FPHASE    = 0
) (
    input  wire CLKI, CLKFB, RST, STDBY, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP, PHASELOADREG,
    input  wire PLLWAKESYNC, ENCLKOP, ENCLKOS,
    output wire CLKOP, CLKOS, LOCK
);
    assign CLKOP = simulated_board.i_fast_clk;
    assign CLKOS = simulated_board.i_line_clk;
    assign LOCK  = simulated_board.i_locked;

    initial begin
        simulated_board.o_fast_multiplier = CLKFB_DIV;
        simulated_board.o_fast_divider    = CLKI_DIV;
        simulated_board.o_line_multiplier = CLKFB_DIV * CLKOP_DIV;
        simulated_board.o_line_divider    = CLKI_DIV * CLKOS_DIV;
    end
endmodule

module ECLKSYNCB (
    input  wire ECLKI, STOP,
    output wire ECLKO
);
    assign ECLKO = ECLKI;
endmodule

module CLKDIVF #(
    parameter DIV = "2.0"
) (
    input  wire CLKI, RST, ALIGNWD,
    output reg  CDIVX
);
    initial CDIVX = 1'b0;
    always @(posedge CLKI or posedge RST) begin
        if (RST) CDIVX <= 1'b0;
        else     CDIVX <= !CDIVX;
    end
endmodule

// DEL_VALUE taps of 25 ps, which the simulation holds against its own step: that is by how much it
// delays here. An edge of ECLK at the step still sees what was there before.
module DELAYG #(
    parameter DEL_MODE  = "",
    parameter DEL_VALUE = 0
) (
    input  wire A,
    output reg  Z
);
    always @(posedge simulated_board.i_step or negedge simulated_board.i_step) Z <= A;

    initial simulated_board.o_delay_taps = DEL_VALUE;
endmodule

// A sample at each edge of ECLK; SCLK takes the four before its own edge, Q0 the earliest.
module IDDRX2F (
    input  wire D, SCLK, ECLK, RST, ALIGNWD,
    output reg  Q0, Q1, Q2, Q3
);
    reg [4:0] taken;
    always @(posedge ECLK or negedge ECLK) taken <= {D, taken[4:1]};
    always @(posedge SCLK) {Q3, Q2, Q1, Q0} <= RST ? 4'd0 : taken[3:0];
endmodule

module ODDRX1F (
    input  wire SCLK, RST, D0, D1,
    output wire Q
);
    reg at_rise, at_fall;
    always @(posedge SCLK) {at_fall, at_rise} <= RST ? 2'd0 : {D1, D0};
    assign Q = SCLK ? at_rise : at_fall;
endmodule

`default_nettype wire

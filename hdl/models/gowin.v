// Behavioural models of Gowin's cells, as far as board_clock, board_sampler and board_laser use them;
// simulated_board.v says how time goes. Written from Gowin UG286 (clocks) and UG289 (I/O).

`default_nettype none

// CLKOUT = CLKIN x (FBDIV_SEL + 1) / (IDIV_SEL + 1).
module rPLL #(
    parameter DEVICE         = "",
    parameter FCLKIN         = "",
    parameter IDIV_SEL       = 0,
    parameter FBDIV_SEL      = 0,
    parameter ODIV_SEL       = 8,
    parameter DYN_IDIV_SEL   = "false",
    parameter DYN_FBDIV_SEL  = "false",
    parameter DYN_ODIV_SEL   = "false",
    parameter DYN_DA_EN      = "false",
    parameter PSDA_SEL       = "0000",
    parameter DUTYDA_SEL     = "1000",
    parameter CLKFB_SEL      = "internal",
    parameter CLKOUT_BYPASS  = "false",
    parameter CLKOUTP_BYPASS = "false",
    parameter CLKOUTD_BYPASS = "false",
    parameter CLKOUTD_SRC    = "CLKOUT",
    parameter CLKOUTD3_SRC   = "CLKOUT",
    parameter DYN_SDIV_SEL   = 2
) (
    input  wire       CLKIN, CLKFB, RESET, RESET_P,
    input  wire [5:0] FBDSEL, IDSEL, ODSEL,
    input  wire [3:0] PSDA, DUTYDA, FDLY,
    output wire       CLKOUT, LOCK, CLKOUTP, CLKOUTD, CLKOUTD3
);
    assign CLKOUT   = simulated_board.i_fast_clk;
    assign LOCK     = simulated_board.i_locked;
    assign CLKOUTP  = 1'b0;
    assign CLKOUTD  = 1'b0;
    assign CLKOUTD3 = 1'b0;

    initial begin
        simulated_board.o_fast_multiplier = FBDIV_SEL + 1;
        simulated_board.o_fast_divider    = IDIV_SEL + 1;
    end
endmodule

// DIV_MODE "2" or "4".
module CLKDIV #(
    parameter DIV_MODE = "2",
    parameter GSREN    = "false"
) (
    input  wire HCLKIN, RESETN, CALIB,
    output wire CLKOUT
);
    reg [1:0] count;
    initial count = 2'd0;
    always @(posedge HCLKIN or negedge RESETN) begin
        if (!RESETN) count <= 2'd0;
        else         count <= count + 2'd1;
    end
    assign CLKOUT = DIV_MODE == "4" ? count[1] : count[0];
endmodule

// A sample at each edge of FCLK; PCLK takes the eight before its own edge, Q0 the earliest.
module IDES8 #(
    parameter GSREN = "false",
    parameter LSREN = "true"
) (
    input  wire D, FCLK, PCLK, CALIB, RESET,
    output reg  Q0, Q1, Q2, Q3, Q4, Q5, Q6, Q7
);
    reg [8:0] taken;
    always @(posedge FCLK or negedge FCLK) taken <= {D, taken[8:1]};
    always @(posedge PCLK) {Q7, Q6, Q5, Q4, Q3, Q2, Q1, Q0} <= RESET ? 8'd0 : taken[7:0];
endmodule

module IDES4 #(
    parameter GSREN = "false",
    parameter LSREN = "true"
) (
    input  wire D, FCLK, PCLK, CALIB, RESET,
    output reg  Q0, Q1, Q2, Q3
);
    reg [4:0] taken;
    always @(posedge FCLK or negedge FCLK) taken <= {D, taken[4:1]};
    always @(posedge PCLK) {Q3, Q2, Q1, Q0} <= RESET ? 4'd0 : taken[3:0];
endmodule

module ODDR (
    input  wire CLK, TX, D0, D1,
    output wire Q0, Q1
);
    reg at_rise, at_fall;
    always @(posedge CLK) {at_fall, at_rise} <= {D1, D0};
    assign Q0 = CLK ? at_rise : at_fall;
    assign Q1 = TX;
endmodule

`default_nettype wire

// Behavioural models of AMD 7-series' cells, as far as board_clock, board_sampler and board_laser use
// them; simulated_board.v says how time goes. Written from AMD UG472 (clocks) and UG471 (I/O).

`default_nettype none

// CLKOUT0 = CLKIN1 x CLKFBOUT_MULT_F / (DIVCLK_DIVIDE CLKOUT0_DIVIDE_F), here with whole numbers.
module MMCME2_BASE #(
    parameter CLKIN1_PERIOD    = 0.0,
    parameter DIVCLK_DIVIDE    = 1,
    parameter CLKFBOUT_MULT_F  = 5,
    parameter CLKOUT0_DIVIDE_F = 1
) (
    input  wire CLKIN1, CLKFBIN, RST, PWRDWN,
    output wire CLKFBOUT, CLKOUT0, LOCKED
);
    assign CLKFBOUT = CLKIN1;
    assign CLKOUT0  = simulated_board.i_fast_clk;
    assign LOCKED   = simulated_board.i_locked;

    initial begin
        simulated_board.o_fast_multiplier = CLKFBOUT_MULT_F;
        simulated_board.o_fast_divider    = DIVCLK_DIVIDE * CLKOUT0_DIVIDE_F;
    end
endmodule

module IBUF (input wire I, output wire O);
    assign O = I;
endmodule

module OBUF (input wire I, output wire O);
    assign O = I;
endmodule

module BUFG (input wire I, output wire O);
    assign O = I;
endmodule

module BUFIO (input wire I, output wire O);
    assign O = I;
endmodule

// BUFR_DIVIDE "2" or "4".
module BUFR #(
    parameter BUFR_DIVIDE = "2"
) (
    input  wire I, CE, CLR,
    output wire O
);
    reg [1:0] count;
    initial count = 2'd0;
    always @(posedge I or posedge CLR) begin
        if (CLR)     count <= 2'd0;
        else if (CE) count <= count + 2'd1;
    end
    assign O = BUFR_DIVIDE == "4" ? count[1] : count[0];
endmodule

// A sample at each edge of CLK; CLKDIV takes those before its own edge, Q1 the latest.
module ISERDESE2 #(
    parameter DATA_RATE        = "DDR",
    parameter DATA_WIDTH       = 8,
    parameter INTERFACE_TYPE   = "NETWORKING",
    parameter IOBDELAY         = "NONE",
    parameter IS_CLKB_INVERTED = 1'b0,
    parameter NUM_CE           = 1,
    parameter SERDES_MODE      = "MASTER"
) (
    input  wire D, DDLY, CLK, CLKB, CLKDIV, CLKDIVP, OCLK, OCLKB, RST, CE1, CE2, BITSLIP,
    input  wire DYNCLKDIVSEL, DYNCLKSEL, OFB, SHIFTIN1, SHIFTIN2,
    output wire O, SHIFTOUT1, SHIFTOUT2,
    output reg  Q1, Q2, Q3, Q4, Q5, Q6, Q7, Q8
);
    reg [8:0] taken; // bit 0 latest
    always @(posedge CLK or negedge CLK) taken <= {taken[7:0], D};
    always @(posedge CLKDIV) {Q8, Q7, Q6, Q5, Q4, Q3, Q2, Q1} <= RST ? 8'd0 : taken[8:1];
    assign O         = D;
    assign SHIFTOUT1 = 1'b0;
    assign SHIFTOUT2 = 1'b0;
endmodule

`default_nettype wire

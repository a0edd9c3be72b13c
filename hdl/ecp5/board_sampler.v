// board_sampler: the samples of a detector in each chip, on Lattice ECP5
//
// A pin has a gear of four (IDDRX2F): S = 4 on one pin. S = 8 takes the same signal at two pins, the
// second delayed by one sample period, and one edge clock and divider for both, so that nothing can
// put their words apart. The delay is `BOARD_DELAY_TAPS taps of about 25 ps (Lattice FPGA-DS-02012,
// "DELAYG"), which move with voltage and temperature.
// Latency  whole clocks in the pins' gears, the same for every sample

`include "board.vh"

`default_nettype none

module board_sampler #(
    parameter PINS    = 1,                // 1 or 2
    parameter SAMPLES = 4                 // 4 for each pin
) (
    input  wire               i_fast_clk, // twice the rate of i_clk, from ECLKSYNCB
    input  wire               i_clk,      // from CLKDIVF of i_fast_clk
    input  wire               i_rst,
    input  wire [PINS-1:0]    i_pins,     // the comparator, at each pin
    output wire [SAMPLES-1:0] o_samples   // bit 0 earliest
);

    genvar p;
    generate
        for (p = 0; p < PINS; p = p + 1) begin : gen_pin
            wire       level;
            wire [3:0] word;  // bit 0 earliest

            if (p == 0) begin : gen_direct
                assign level = i_pins[0];
            end else begin : gen_delayed
                // A number: of the text "DELAY40" the tools would make tap 0 without a word.
                DELAYG #(
                    .DEL_MODE  ("USER_DEFINED"),
                    .DEL_VALUE (`BOARD_DELAY_TAPS)
                ) delay (
                    .A (i_pins[p]),
                    .Z (level)
                );
            end

            IDDRX2F gear (
                .D       (level),
                .SCLK    (i_clk),
                .ECLK    (i_fast_clk),
                .RST     (i_rst),
                .ALIGNWD (1'b0),
                .Q0      (word[0]),
                .Q1      (word[1]),
                .Q2      (word[2]),
                .Q3      (word[3])
            );

            // An edge takes from the delayed pin what came a sample earlier.
            assign o_samples[0*PINS + PINS - 1 - p] = word[0];
            assign o_samples[1*PINS + PINS - 1 - p] = word[1];
            assign o_samples[2*PINS + PINS - 1 - p] = word[2];
            assign o_samples[3*PINS + PINS - 1 - p] = word[3];
        end
    endgenerate

endmodule

`default_nettype wire

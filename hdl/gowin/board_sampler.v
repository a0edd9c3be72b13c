// board_sampler: the samples of a detector in each chip, on Gowin GW1N or GW2A
//
// IDES4 or IDES8 at one pin: S = 4 or 8. They take the pads of a pair, of which the detector has the
// first ("A").
// Latency  whole clocks in the pin's gear, the same for every sample

`default_nettype none

module board_sampler #(
    parameter PINS    = 1,                // 1
    parameter SAMPLES = 8                 // 4 or 8
) (
    input  wire               i_fast_clk, // SAMPLES / 2 times the rate of i_clk
    input  wire               i_clk,      // from CLKDIV of i_fast_clk
    input  wire               i_rst,
    input  wire [PINS-1:0]    i_pins,     // the comparator
    output wire [SAMPLES-1:0] o_samples   // bit 0 earliest
);

    // Q0 is the earliest sample (Gowin UG289, timing of IDES4 and IDES8).
    generate
        if (SAMPLES == 8) begin : gen_gear
            IDES8 #(
                .GSREN ("false"),
                .LSREN ("true")
            ) gear (
                .D     (i_pins[0]),
                .FCLK  (i_fast_clk),
                .PCLK  (i_clk),
                .CALIB (1'b0),
                .RESET (i_rst),
                .Q0    (o_samples[0]),
                .Q1    (o_samples[1]),
                .Q2    (o_samples[2]),
                .Q3    (o_samples[3]),
                .Q4    (o_samples[4]),
                .Q5    (o_samples[5]),
                .Q6    (o_samples[6]),
                .Q7    (o_samples[7])
            );
        end else begin : gen_gear
            IDES4 #(
                .GSREN ("false"),
                .LSREN ("true")
            ) gear (
                .D     (i_pins[0]),
                .FCLK  (i_fast_clk),
                .PCLK  (i_clk),
                .CALIB (1'b0),
                .RESET (i_rst),
                .Q0    (o_samples[0]),
                .Q1    (o_samples[1]),
                .Q2    (o_samples[2]),
                .Q3    (o_samples[3])
            );
        end
    endgenerate

endmodule

`default_nettype wire

// board_sampler: the samples of a detector in each chip, on AMD 7-series
//
// ISERDESE2 at one pin: S = 4 or 8. S = 16 is not on one pin: ISERDESE2 reaches 14, by cascading.
// Latency  whole clocks in the pin's gear, the same for every sample

`default_nettype none

module board_sampler #(
    parameter PINS    = 1,                // 1
    parameter SAMPLES = 8                 // 4 or 8
) (
    input  wire               i_fast_clk, // SAMPLES / 2 times the rate of i_clk, from BUFIO
    input  wire               i_clk,      // from BUFR, in phase with i_fast_clk
    input  wire               i_rst,
    input  wire [PINS-1:0]    i_pins,     // the comparator
    output wire [SAMPLES-1:0] o_samples   // bit 0 earliest
);

    wire       pin;
    wire [7:0] word; // bit j is Q(j + 1), of which Q1 is the latest sample

    IBUF pad (
        .I (i_pins[0]),
        .O (pin)
    );

    ISERDESE2 #(
        .DATA_RATE        ("DDR"),
        .DATA_WIDTH       (SAMPLES),
        .INTERFACE_TYPE   ("NETWORKING"),
        .IOBDELAY         ("NONE"),
        .IS_CLKB_INVERTED (1'b1),
        .NUM_CE           (1),
        .SERDES_MODE      ("MASTER")
    ) gear (
        .D            (pin),
        .DDLY         (1'b0),
        .CLK          (i_fast_clk),
        .CLKB         (i_fast_clk),
        .CLKDIV       (i_clk),
        .CLKDIVP      (1'b0),
        .OCLK         (1'b0),
        .OCLKB        (1'b0),
        .RST          (i_rst),
        .CE1          (1'b1),
        .CE2          (1'b1),
        .BITSLIP      (1'b0),
        .DYNCLKDIVSEL (1'b0),
        .DYNCLKSEL    (1'b0),
        .OFB          (1'b0),
        .SHIFTIN1     (1'b0),
        .SHIFTIN2     (1'b0),
        .O            (),
        .SHIFTOUT1    (),
        .SHIFTOUT2    (),
        .Q1           (word[0]),
        .Q2           (word[1]),
        .Q3           (word[2]),
        .Q4           (word[3]),
        .Q5           (word[4]),
        .Q6           (word[5]),
        .Q7           (word[6]),
        .Q8           (word[7])
    );

    genvar j;
    generate
        for (j = 0; j < SAMPLES; j = j + 1) begin : gen_order
            assign o_samples[j] = word[SAMPLES - 1 - j];
        end
    endgenerate

endmodule

`default_nettype wire

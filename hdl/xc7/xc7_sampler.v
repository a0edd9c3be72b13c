// xc7_sampler: four or eight samples of a pin per clock, on Xilinx 7-series
//
// S = 4 or 8. S = 16 is not on one pin: ISERDESE2 reaches 14, by cascading.
// Latency  whole clocks in the pin's gear, the same for every sample

`default_nettype none

module xc7_sampler #(
    parameter S = 8                 // samples per clock: 4 or 8
) (
    input  wire         i_bit_clk, // S / 2 times the rate of i_clk, from BUFIO
    input  wire         i_clk,     // from BUFR, in phase with i_bit_clk
    input  wire         i_rst,
    input  wire         i_pin,     // the SPAD's comparator, from its IBUF
    output wire [S-1:0] o_samples  // bit 0 earliest
);

    wire [7:0] word; // bit j is Q(j + 1), of which Q1 is the latest sample

    ISERDESE2 #(
        .DATA_RATE        ("DDR"),
        .DATA_WIDTH       (S),
        .INTERFACE_TYPE   ("NETWORKING"),
        .IOBDELAY         ("NONE"),
        .IS_CLKB_INVERTED (1'b1),
        .NUM_CE           (1),
        .SERDES_MODE      ("MASTER")
    ) gear (
        .D            (i_pin),
        .DDLY         (1'b0),
        .CLK          (i_bit_clk),
        .CLKB         (i_bit_clk),
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
        for (j = 0; j < S; j = j + 1) begin : gen_order
            assign o_samples[j] = word[S - 1 - j];
        end
    endgenerate

endmodule

`default_nettype wire

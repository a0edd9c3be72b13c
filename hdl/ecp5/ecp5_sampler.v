// ecp5_sampler: four samples of a pin per clock, on Lattice ECP5
//
// S = 4 only. IDDRX1F would give two; the ECP5 has no pin gear of 8 or 16.
// Latency  whole clocks in the pin's gear, the same for every sample

`default_nettype none

module ecp5_sampler (
    input  wire       i_edge_clk, // twice the rate of i_clk, from ECLKSYNCB
    input  wire       i_clk,      // from CLKDIVF of i_edge_clk
    input  wire       i_rst,
    input  wire       i_pin,      // the SPAD's comparator
    output wire [3:0] o_samples   // bit 0 earliest
);

    // Q0 is the sample of the first edge, Q3 that of the last.
    IDDRX2F gear (
        .D       (i_pin),
        .SCLK    (i_clk),
        .ECLK    (i_edge_clk),
        .RST     (i_rst),
        .ALIGNWD (1'b0),
        .Q0      (o_samples[0]),
        .Q1      (o_samples[1]),
        .Q2      (o_samples[2]),
        .Q3      (o_samples[3])
    );

endmodule

`default_nettype wire

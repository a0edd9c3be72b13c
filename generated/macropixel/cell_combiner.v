// cell_combiner: level of a detector, from those of its 4 cells
//
// A sample of it shows a pulse where at least 2 cells' samples do.
//
// Latency  none
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

`default_nettype none

module cell_combiner (
    input  wire [15:0] i_samples, // level of each cell, bit 0 earliest, cell 0 lowest

    output wire [3:0]  o_level    // level of the detector, bit 0 earliest
);

    wire [3:0] word_0; // pulses of cells; then sum and carry of each adder
    wire [3:0] word_1;
    wire [3:0] word_2;
    wire [3:0] word_3;
    wire [3:0] word_4;
    wire [3:0] word_5;
    wire [3:0] word_6;
    wire [3:0] word_7;
    wire [3:0] word_8;

    assign word_0 = i_samples[3:0];
    assign word_1 = i_samples[7:4];
    assign word_2 = i_samples[11:8];
    assign word_3 = i_samples[15:12];
    assign word_4 = word_0 ^ word_1 ^ word_2;
    assign word_5 = (word_0 & word_1) | (word_2 & (word_0 | word_1));
    assign word_6 = word_3 & word_4;
    assign word_7 = word_5 ^ word_6;
    assign word_8 = word_5 & word_6;
    assign o_level = word_7 | word_8;

endmodule

`default_nettype wire

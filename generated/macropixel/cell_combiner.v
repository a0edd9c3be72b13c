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

    // their sums, as far as these matter
    wire [3:0] sum_0 = i_samples[3:0] ^ i_samples[7:4] ^ i_samples[11:8];
    // and their carries
    wire [3:0] carry_0 = (i_samples[3:0] & i_samples[7:4])
        | (i_samples[11:8] & (i_samples[3:0] | i_samples[7:4]));
    wire [7:0] addends_1 = {sum_0, i_samples[15:12]};
    wire [3:0] carry_1 = addends_1[3:0] & addends_1[7:4];
    wire [7:0] addends_2 = {carry_1, carry_0};
    wire [3:0] sum_1 = addends_2[3:0] ^ addends_2[7:4];
    wire [3:0] carry_2 = addends_2[3:0] & addends_2[7:4];

    assign o_level = sum_1 | carry_2;

endmodule

`default_nettype wire

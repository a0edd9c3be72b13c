// edge_detector: one hit per rising edge of the SPAD's level
//
// Of two neighbouring samples at most one is a rising edge, and it is the earlier one exactly
// when that sample is high: two bits say all about a pair. The last sample of a word is kept
// outside scans too, so that a pulse that began before a scan does not count in it.
//
// Latency  1 clock
// Made by  goldtof emit dual-view.toml (goldtof 0.1.0)

`default_nettype none

module edge_detector (
    input  wire       i_clk, i_rst,

    input  wire [7:0] i_samples, // level of the SPAD, bit 0 earliest
    input  wire       i_run,     // the word belongs to a scan

    output reg  [3:0] o_hits,    // pairs of samples with a high one after a low one
    output reg  [3:0] o_early    // the hit is the earlier sample of its pair
);

    reg        last_sample_r; // of the word before
    wire [3:0] pairs, earlier;
    genvar g;

    wire [7:0] rising = i_samples & ~{i_samples[6:0], last_sample_r} & {8{i_run}};

    for (g = 0; g < 4; g = g + 1) begin : gen_pairs
        assign pairs[g] = rising[2*g] | rising[2*g + 1];
        assign earlier[g] = i_samples[2*g];
    end

    always @(posedge i_clk)
        if (i_rst) begin
            {last_sample_r, o_hits, o_early} <= 0;
        end else begin
            last_sample_r <= i_samples[7];
            o_hits <= pairs;
            o_early <= earlier;
        end

endmodule

`default_nettype wire

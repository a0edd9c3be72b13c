// edge_detector: one hit per rising edge of the SPAD's level
//
// The last sample of a word is kept outside scans too, so that a pulse that began before a scan
// is no hit of it.
//
// Latency  1 clock
// Rate     one word per clock
// Made by  goldtof emit paper-single.toml (goldtof 0.1.0)

`default_nettype none

module edge_detector (
    // Clock and reset
    input  wire       i_clk,     // one sample word per cycle
    input  wire       i_rst,     // synchronous, active high

    // Inputs
    input  wire [7:0] i_samples, // level of the SPAD, bit 0 earliest
    input  wire       i_run,     // the word belongs to a scan

    // Outputs
    output reg  [7:0] o_hits     // samples that are high after a low one
);

    reg  last_sample_r; // last sample of the word before

    always @(posedge i_clk) begin
        if (i_rst) begin
            last_sample_r <= 1'b0;
            o_hits <= 8'd0;
        end else begin
            last_sample_r <= i_samples[7];
            o_hits <= i_samples & ~{i_samples[6:0], last_sample_r} & {8{i_run}};
        end
    end

endmodule

`default_nettype wire

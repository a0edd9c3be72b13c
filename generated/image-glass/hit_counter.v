// hit_counter: hits of a phase step, up and down together
//
// All steps of a group see the same light, so one counter serves them all. It keeps time with
// their correlators and takes the same i_dump; its first registers hold what theirs do, and a
// synthesizer that looks across modules makes one of both.
//
// Latency  5 clocks from i_hits to o_total
// Made by  goldtof emit image-glass.toml (goldtof 0.1.0)

`default_nettype none

module hit_counter (
    input  wire        i_clk, i_rst,

    input  wire [3:0]  i_hits, // pairs of samples with a hit
    input  wire        i_dump, // the total has just taken in a step's last hits

    output wire [19:0] o_total // hits of the last step, unsigned
);

    reg  [3:0] hit_r;  // pairs with a hit
    wire [3:0] addend; // hits of one word

    quad_counter quad (
        .i_clk (i_clk), .i_rst (i_rst), .i_hit (hit_r),
        .i_down (4'd0),
        .o_sum  (addend)
    );

    accumulator #(.BITS(20)) total (
        .i_clk (i_clk), .i_rst (i_rst), .i_addend (addend), .i_dump (i_dump),
        .o_count (o_total)
    );

    always @(posedge i_clk)
        if (i_rst) hit_r <= 4'd0;
        else hit_r <= i_hits;

endmodule

`default_nettype wire

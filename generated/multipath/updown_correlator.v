// updown_correlator: hits counted up or down as the reference says
//
// A hit adds 1 where the reference is 1, and subtracts 1 where it is 0 (eq. 11): the sum over a
// word is the number of hits less twice the number of those that count down.
//
// Latency  5 clocks from i_hits to o_count
// Made by  goldtof emit multipath.toml (goldtof 0.1.0)

`default_nettype none

module updown_correlator (
    input  wire        i_clk, i_rst,

    input  wire [3:0]  i_hits,      // pairs of samples with a hit
    input  wire [3:0]  i_early,     // the hit is the earlier sample of its pair
    input  wire [7:0]  i_reference, // 1 counts a hit up, 0 down; bit 0 earliest
    input  wire        i_dump,      // the total has just taken in a step's last hits

    output wire [16:0] o_count      // count of the last step, signed
);

    reg  [3:0] hit_r;  // pairs with a hit
    reg  [3:0] down_r; // pairs whose hit counts down
    wire [3:0] addend; // signed count of one word
    wire [3:0] early_reference, late_reference;
    genvar g;

    for (g = 0; g < 4; g = g + 1) begin : gen_early_reference
        assign early_reference[g] = i_reference[2*g];
        assign late_reference[g] = i_reference[2*g + 1];
    end

    quad_counter quad (
        .i_clk (i_clk), .i_rst (i_rst), .i_hit (hit_r), .i_down (down_r),
        .o_sum (addend)
    );

    accumulator total (
        .i_clk (i_clk), .i_rst (i_rst), .i_addend (addend), .i_dump (i_dump),
        .o_count (o_count)
    );

    always @(posedge i_clk)
        if (i_rst) begin
            {hit_r, down_r} <= 0;
        end else begin
            down_r <= i_hits & ~((i_early & early_reference) | (~i_early & late_reference));
            hit_r <= i_hits;
        end

endmodule

`default_nettype wire

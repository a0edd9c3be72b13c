// updown_correlator: hits counted up or down as the reference says
//
// A hit adds 1 where the reference is 1, and subtracts 1 where it is 0 (eq. 11): the sum over a
// word is the number of hits less twice the number of those that count down.
//
// Latency  4 clocks from i_hits to o_count
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

`default_nettype none

module updown_correlator (
    input  wire        i_clk, i_rst,

    input  wire [1:0]  i_hits,      // pairs of samples with a hit
    input  wire [1:0]  i_early,     // the hit is the earlier sample of its pair
    input  wire [3:0]  i_reference, // 1 counts a hit up, 0 down; bit 0 earliest
    input  wire        i_dump,      // the total has just taken in a step's last hits

    output wire [13:0] o_count      // count of the last step, signed
);

    reg  [1:0] hit_r;  // pairs with a hit
    reg  [1:0] down_r; // pairs whose hit counts down
    reg  [2:0] sum_r;  // signed count of two pairs

    wire [1:0] early_reference = {i_reference[2], i_reference[0]};
    wire [1:0] late_reference = {i_reference[3], i_reference[1]};

    accumulator total (
        .i_clk (i_clk), .i_rst (i_rst),
        .i_addend (sum_r),
        .i_dump   (i_dump),
        .o_count  (o_count)
    );

    always @(posedge i_clk)
        if (i_rst) begin
            {hit_r, down_r, sum_r} <= 0;
        end else begin
            down_r <= i_hits & ~((i_early & early_reference) | (~i_early & late_reference));
            hit_r <= i_hits;
            sum_r <= {down_r[0], down_r[0], hit_r[0]} + {down_r[1], down_r[1], hit_r[1]};
        end

endmodule

`default_nettype wire

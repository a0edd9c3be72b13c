// quad_counter: signed count of four pairs of samples
//
// A hit adds 1, and a hit that counts down takes 2 off again. Four ones are counted by two half
// adders whose sums and carries meet in one gate each.
//
// Latency  2 clocks
// Made by  goldtof emit paper-interleaved.toml (goldtof 0.1.0)

`default_nettype none

module quad_counter (
    input  wire       i_clk, i_rst,

    input  wire [3:0] i_hit,  // pairs with a hit
    input  wire [3:0] i_down, // those whose hit counts down

    output reg  [3:0] o_sum   // hits that count up less hits that count down, signed
);

    reg  [2:0] hits_r, downs_r;

    // or three
    wire two_hits = (i_hit[0] & i_hit[1]) ^ (i_hit[2] & i_hit[3])
        ^ ((i_hit[0] ^ i_hit[1]) & (i_hit[2] ^ i_hit[3]));
    // or three
    wire two_downs = (i_down[0] & i_down[1]) ^ (i_down[2] & i_down[3])
        ^ ((i_down[0] ^ i_down[1]) & (i_down[2] ^ i_down[3]));

    always @(posedge i_clk)
        if (i_rst) begin
            {hits_r, downs_r, o_sum} <= 0;
        end else begin
            hits_r <= {&i_hit, two_hits, ^i_hit};
            downs_r <= {&i_down, two_downs, ^i_down};
            o_sum <= {1'b0, hits_r} - {downs_r, 1'b0};
        end

endmodule

`default_nettype wire

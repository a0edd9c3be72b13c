// state_match: recognises a state of a counter
//
// The pieces of a wide comparison have a register each.
//
// Latency  1 clock
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module state_match (
    input  wire        i_clk, i_rst,

    input  wire [13:0] i_state,  // state of a counter
    input  wire [13:0] i_wanted, // the state that is waited for

    output wire        o_matched // they were equal one clock ago
);

    reg  [1:0] matched_r; // one bit for each piece

    wire [13:0] equal = ~(i_state ^ i_wanted);
    wire [1:0]  all_equal = {&equal[13:8], &equal[7:0]};

    assign o_matched = &matched_r;

    always @(posedge i_clk)
        if (i_rst) matched_r <= 2'd0;
        else matched_r <= all_equal;

endmodule

`default_nettype wire

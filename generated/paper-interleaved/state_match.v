// state_match: recognises a state of a counter
//
// The pieces of a wide comparison have a register each.
//
// Latency  1 clock
// Made by  goldtof emit paper-interleaved.toml (goldtof 0.1.0)

`default_nettype none

module state_match #(
    parameter WIDTH = 14 // bits of a state, 9 to 16
) (
    input  wire               i_clk, i_rst,

    input  wire [WIDTH - 1:0] i_state,  // state of a counter
    input  wire [WIDTH - 1:0] i_wanted, // the state that is waited for

    output wire               o_matched // they were equal one clock ago
);

    // Elaboration ends here: there is no module of this name.
    if (WIDTH < 9 || WIDTH > 16) begin : gen_refused
        state_match_takes_WIDTH_of_9_to_16 refused ();
    end

    reg  [1:0] matched_r; // one bit for each piece

    wire [WIDTH - 1:0] equal = ~(i_state ^ i_wanted);
    wire [1:0]         all_equal = {&equal[WIDTH - 1:8], &equal[7:0]};

    assign o_matched = &matched_r;

    always @(posedge i_clk)
        if (i_rst) matched_r <= 2'd0;
        else matched_r <= all_equal;

endmodule

`default_nettype wire

// state_match: recognises a state of a counter
//
// The pieces of a wide comparison have a register each.
//
// Latency  1 clock
// Rate     one state per clock
// Made by  goldtof emit moving.toml (goldtof 0.1.0)

`default_nettype none

module state_match (
    // Clock and reset
    input  wire        i_clk,     // one state per cycle
    input  wire        i_rst,     // synchronous, active high

    // Inputs
    input  wire [13:0] i_state,   // state of a counter
    input  wire [13:0] i_wanted,  // the state that is waited for

    // Outputs
    output wire        o_matched  // they were equal one clock ago
);

    reg  [1:0]  matched_r; // pieces that were equal
    wire [13:0] equal;     // bits that are equal
    wire [7:0]  piece_0;   // bits of a piece
    wire [5:0]  piece_1;   // bits of a piece
    wire [1:0]  all_equal; // pieces that are equal

    assign equal = ~(i_state ^ i_wanted);
    assign o_matched = &matched_r;
    assign piece_0 = equal[7:0];
    assign piece_1 = equal[13:8];
    assign all_equal = {&piece_1, &piece_0};

    always @(posedge i_clk) begin
        if (i_rst) begin
            matched_r <= 2'd0;
        end else begin
            matched_r <= all_equal;
        end
    end

endmodule

`default_nettype wire

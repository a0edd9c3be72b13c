// A code: its chips one after another, and the first of its period. It comes of one LFSR, of the
// sum of two, or of a table; interleaved, each chip comes 2^DEPTH times, every other time inverted
// (eq. 23).
module spec_code #(
    parameter DEGREE = 1,
    parameter [DEGREE-1:0] TAPS_U = 0,
    parameter [DEGREE-1:0] FIRST_U = 0,
    parameter [DEGREE-1:0] TAPS_V = 0,
    parameter [DEGREE-1:0] FIRST_V = 0,  // 0: no second LFSR
    parameter CHIPS = 1,                 // of the table, which is there if there is no LFSR
    parameter [CHIPS-1:0] TABLE = 0,
    parameter FIRST = 0,                 // first chip of the table
    parameter DEPTH = 0,
    parameter FIRST_REPETITION = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    wire moves, is_inverted, is_first;
    wire starts = i_rst | load;
    generate
        if (DEPTH > 0) begin : interleaved
            reg [DEPTH-1:0] repetition;
            always @(posedge i_clk)
                if (starts) repetition <= FIRST_REPETITION;
                else if (advance) repetition <= repetition + 1'b1;
            assign moves = advance & (&repetition);
            assign is_inverted = repetition[0];
            assign is_first = repetition == FIRST_REPETITION;
        end else begin : plain
            assign moves = advance;
            assign is_inverted = 1'b0;
            assign is_first = 1'b1;
        end
        if (FIRST_U != 0) begin : generated
            reg [DEGREE-1:0] u;
            always @(posedge i_clk)
                if (starts) u <= FIRST_U;
                else if (moves) u <= {^(u & TAPS_U), u[DEGREE-1:1]};
            always @* assert (u != 0);
            wire of_second;
            if (FIRST_V != 0) begin : pair
                reg [DEGREE-1:0] v;
                always @(posedge i_clk)
                    if (starts) v <= FIRST_V;
                    else if (moves) v <= {^(v & TAPS_V), v[DEGREE-1:1]};
                always @* assert (v != 0);
                assign of_second = v[0];
            end else begin : single
                assign of_second = 1'b0;
            end
            assign chip = u[0] ^ of_second ^ is_inverted;
            assign epoch = u == FIRST_U & is_first;
        end else begin : listed
            localparam BITS = CHIPS > 2 ? $clog2(CHIPS) : 1;
            reg [BITS-1:0] index;
            always @(posedge i_clk)
                if (starts) index <= FIRST;
                else if (moves) index <= index == CHIPS - 1 ? 0 : index + 1'b1;
            always @* assert (index <= CHIPS - 1);
            wire [CHIPS-1:0] chips = TABLE;
            assign chip = chips[index] ^ is_inverted;
            assign epoch = index == FIRST & is_first;
        end
    endgenerate
endmodule

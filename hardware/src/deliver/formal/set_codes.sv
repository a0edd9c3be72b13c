// A code of which a host sets the last LFSR: its first chips, in the lower bits of `seed`, and above
// them, if it sets them, its taps; then that LFSR begins anew with each period of the first one. Of a
// code of one LFSR the first one has the period alone.
module spec_set_code #(
    parameter DEGREE = 1,
    parameter [DEGREE-1:0] TAPS_U = 0,
    parameter [DEGREE-1:0] FIRST_U = 0,
    parameter [DEGREE-1:0] TAPS_V = 0,  // 0: the host's
    parameter SUMS = 1,                 // the chips are those of both
    parameter SEED_BITS = 1,
    parameter DEPTH = 0,
    parameter FIRST_REPETITION = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    input wire [SEED_BITS-1:0] seed,
    output wire chip,
    output wire epoch
);
    wire of_first;
    spec_code #(
        .DEGREE(DEGREE), .TAPS_U(TAPS_U), .FIRST_U(FIRST_U),
        .DEPTH(DEPTH), .FIRST_REPETITION(FIRST_REPETITION)
    ) first (
        .i_clk(i_clk), .i_rst(i_rst), .advance(advance), .load(load), .chip(of_first), .epoch(epoch)
    );
    wire moves, is_inverted;
    generate
        if (DEPTH > 0) begin : interleaved
            reg [DEPTH-1:0] repetition;
            always @(posedge i_clk)
                if (i_rst | load) repetition <= FIRST_REPETITION;
                else if (advance) repetition <= repetition + 1'b1;
            assign moves = advance & (&repetition);
            assign is_inverted = repetition[0];
        end else begin : plain
            assign moves = advance;
            assign is_inverted = 1'b0;
        end
    endgenerate
    reg [DEGREE-1:0] v;
    wire [DEGREE-1:0] now = TAPS_V == 0 & epoch ? seed[DEGREE-1:0] : v;
    wire [DEGREE-1:0] taps = TAPS_V == 0 ? seed[SEED_BITS-1:SEED_BITS-DEGREE] : TAPS_V;
    always @(posedge i_clk)
        if (i_rst | load) v <= seed[DEGREE-1:0];
        else if (moves) v <= {^(now & taps), now[DEGREE-1:1]};
        else v <= now;
    assign chip = now[0] ^ (SUMS ? of_first : is_inverted);
endmodule

// While the sequencer lets the codes run every laser shows its source's, chip by chip from the first one
// on, and o_epoch the first chip of the reference's, four clocks after the generators; else the lasers
// are dark. Seeds and taps are anything, such that they stay while codes run, as `registers` shows of
// the sequencer; after reset the codes rest first.
module prove_codes (
    `INPUTS,
    input wire may_run,
    input wire [`SEED_BITS-1:0] any_seed
);
    `DESIGN
    reg rested;
    reg [`SEED_BITS-1:0] last_seed;
    wire on = may_run & rested & ~i_rst;
    wire [`SEED_BITS-1:0] seed = on ? last_seed : any_seed;
    always @(posedge i_clk) begin
        rested <= i_rst ? 1'b0 : rested | ~may_run;
        last_seed <= seed;
    end
    wire [`SOURCES-1:0] chips;
    wire epoch;
    genvar m;
    generate
        for (m = 0; m < `SOURCES; m = m + 1) begin : source
            spec_code_of_source #(.NUMBER(m)) spec (
                .i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(~on), .seed(seed), .chip(chips[m]),
                .epoch()
            );
        end
    endgenerate
    spec_code_of_reference reference (
        .i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(~on), .seed(seed), .chip(), .epoch(epoch)
    );
    reg [4*`SOURCES-1:0] lasers;
    reg [3:0] firsts;
    always @(posedge i_clk) begin
        lasers <= i_rst ? 0 : {lasers, chips & {`SOURCES{on}}};
        firsts <= i_rst ? 0 : {firsts, epoch & on};
    end
    always @* assert (o_laser == lasers[4*`SOURCES-1:3*`SOURCES]);
    always @* assert (o_epoch == firsts[3]);
    `REACHES(o_epoch & ~i_rst)
endmodule

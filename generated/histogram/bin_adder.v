// bin_adder: a histogram's bins of neighbouring samples, and the adder that they share
//
// The detectors' dead time lets at most one of 8 neighbouring samples be a hit. Of several,
// which no such detector makes, the earliest counts.
//
// Latency  5 clocks from i_hits to the bin with its hit, 7 until it is written
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module bin_adder (
    input  wire        i_clk, i_rst,

    input  wire [3:0]  i_hits,        // pairs of samples with a hit
    input  wire [3:0]  i_early,       // it is the earlier sample of its pair
    input  wire [10:0] i_row,         // row of the present word
    input  wire        i_half,        // memory that counts the present word
    input  wire [10:0] i_read_row,    // row to be read from the other memory
    input  wire        i_go,          // the reader goes on
    input  wire        i_come_half,   // memory of the word two clocks ago
    // the word three clocks ago is one of a frame's first code period
    input  wire        i_held_first,
    input  wire        i_held_half,   // memory of the word three clocks ago
    // the word five clocks ago is one of a frame's first code period
    input  wire        i_added_first,
    input  wire [10:0] i_write_row,   // row of the word six clocks ago
    input  wire        i_write_half,  // its memory

    output wire [23:0] o_bins         // bins of the row that was read, the first sample's lowest
);

    reg  [39:0] hit_r;    // sample with the hit of the words 1 to 5 clocks ago
    // bin with a hit, if it is in the first half of the samples; then in the second
    reg  [5:0]  chosen_r;
    reg  [2:0]  sum_r;    // the same with the hit
    reg  [1:0]  above_r;  // its bits above the lowest, a clock later
    wire [5:0]  choice;   // bin with the hit, of the samples of a half
    wire [5:0]  other;    // the same, out of memory 1
    wire [7:0]  addend;   // below either a 1: the carry makes the sum one more
    wire [7:0]  place;
    wire [23:0] bank_bin, bank_other;
    genvar g;

    wire [3:0] both = addend[3:0] + addend[7:4]; // both, and the 1; below them a 0
    wire       unused = both[0]; // the 0 has no use; linters know by the name
    // the earliest pair that has a hit
    wire [3:0] earliest = {i_hits[3] & ~(|i_hits[2:0]), i_hits[2] & ~(|i_hits[1:0]),
        i_hits[1] & ~i_hits[0], i_hits[0]};

    assign choice[2:0] = bank_bin[2:0] | bank_bin[5:3] | bank_bin[8:6] | bank_bin[11:9];
    assign choice[5:3] = bank_bin[14:12] | bank_bin[17:15] | bank_bin[20:18] | bank_bin[23:21];
    assign other[2:0] = bank_other[2:0] | bank_other[5:3] | bank_other[8:6] | bank_other[11:9];
    assign other[5:3] =
        bank_other[14:12] | bank_other[17:15] | bank_other[20:18] | bank_other[23:21];
    assign addend[3:0] = {chosen_r[2:0], 1'b1};
    assign addend[7:4] = {chosen_r[5:3], 1'b1};

    for (g = 0; g < 4; g = g + 1) begin : gen_place
        assign place[2*g] = earliest[g] & i_early[g];
        assign place[2*g + 1] = earliest[g] & ~i_early[g];
    end

    for (g = 0; g < 8; g = g + 1) begin : gen_bank
        bin_bank bank (
            .i_clk (i_clk), .i_rst (i_rst), .i_row (i_row), .i_half (i_half),
            .i_read_row (i_read_row), .i_go (i_go),
            .i_come_hit  (hit_r[g + 8]),
            .i_come_half (i_come_half),
            .i_hit       (hit_r[g + 32]),
            .i_first     (i_added_first),
            .i_lowest    (sum_r[0]),
            .i_above (above_r), .i_write_row (i_write_row), .i_write_half (i_write_half),
            .o_bin       (bank_bin[3*g +: 3]),
            .o_other     (bank_other[3*g +: 3]),
            .o_read      (o_bins[3*g +: 3])
        );
    end

    always @(posedge i_clk)
        if (i_rst) begin
            {hit_r, chosen_r, sum_r, above_r} <= 0;
        end else begin
            hit_r <= {hit_r[31:0], place};
            chosen_r <= choice;
            if (i_held_half) chosen_r <= other;
            if (i_held_first) chosen_r <= 6'd0;
            sum_r <= both[3:1];
            above_r <= sum_r[2:1];
        end

endmodule

`default_nettype wire

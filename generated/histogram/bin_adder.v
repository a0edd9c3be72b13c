// bin_adder: a histogram's bins of neighbouring samples, and the adder that they share
//
// The detectors' dead time lets at most one of 8 neighbouring samples be a hit. Of several,
// which no such detector makes, the earliest counts.
//
// Latency  5 clocks from i_hits to the bin with its hit, 7 until it is written
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module bin_adder (
    input  wire        i_clk,
    input  wire        i_rst,

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

    reg  [7:0] hit_0_r;         // sample with the hit of the word 1 clock ago
    reg  [7:0] hit_1_r;         // sample with the hit of the word 2 clocks ago
    reg  [7:0] hit_2_r;         // sample with the hit of the word 3 clocks ago
    reg  [7:0] hit_3_r;         // sample with the hit of the word 4 clocks ago
    reg  [7:0] hit_4_r;         // sample with the hit of the word 5 clocks ago
    reg  [2:0] chosen_0_r;      // bin with a hit, if it is in the first half of the samples
    reg  [2:0] chosen_1_r;      // if it is in the second
    reg  [2:0] sum_r;           // the same with the hit
    reg  [1:0] above_r;         // its bits above the lowest, a clock later
    wire       hit_before_0;    // a pair or one before it has a hit
    wire       hit_before_1;    // a pair or one before it has a hit
    wire       hit_before_2;    // a pair or one before it has a hit
    wire [2:0] choice_0;        // bin of sample 0, if the hit is there
    wire [2:0] choice_1;        // and of sample 1
    wire [2:0] choice_2;        // and of sample 2
    wire [2:0] choice_3;        // and of sample 3
    wire [2:0] choice_4;        // and of sample 4
    wire [2:0] choice_5;        // and of sample 5
    wire [2:0] choice_6;        // and of sample 6
    wire [2:0] choice_7;        // and of sample 7
    wire [2:0] other_0;         // the same, out of memory 1
    wire [2:0] other_1;         // and of sample 1
    wire [2:0] other_2;         // and of sample 2
    wire [2:0] other_3;         // and of sample 3
    wire [2:0] other_4;         // and of sample 4
    wire [2:0] other_5;         // and of sample 5
    wire [2:0] other_6;         // and of sample 6
    wire [2:0] other_7;         // and of sample 7
    // both, and the 1; below them a 0 that is not used, as linters know by the name
    wire [3:0] both_and_unused;
    wire [7:0] place;
    wire [3:0] addend_0;        // the first, and below it a 1 that carries: one more than the sum
    wire [3:0] addend_1;        // and the second
    wire [2:0] bank_0_read;
    wire [2:0] bank_1_bin;
    wire [2:0] bank_1_other;
    wire [2:0] bank_1_read;
    wire [2:0] bank_2_bin;
    wire [2:0] bank_2_other;
    wire [2:0] bank_2_read;
    wire [2:0] bank_3_bin;
    wire [2:0] bank_3_other;
    wire [2:0] bank_3_read;
    wire [2:0] bank_4_read;
    wire [2:0] bank_5_bin;
    wire [2:0] bank_5_other;
    wire [2:0] bank_5_read;
    wire [2:0] bank_6_bin;
    wire [2:0] bank_6_other;
    wire [2:0] bank_6_read;
    wire [2:0] bank_7_bin;
    wire [2:0] bank_7_other;
    wire [2:0] bank_7_read;

    assign hit_before_0 = i_hits[0];
    assign hit_before_1 = hit_before_0 | i_hits[1];
    assign hit_before_2 = hit_before_1 | i_hits[2];
    assign choice_1 = choice_0 | bank_1_bin;
    assign choice_2 = choice_1 | bank_2_bin;
    assign choice_3 = choice_2 | bank_3_bin;
    assign choice_5 = choice_4 | bank_5_bin;
    assign choice_6 = choice_5 | bank_6_bin;
    assign choice_7 = choice_6 | bank_7_bin;
    assign other_1 = other_0 | bank_1_other;
    assign other_2 = other_1 | bank_2_other;
    assign other_3 = other_2 | bank_3_other;
    assign other_5 = other_4 | bank_5_other;
    assign other_6 = other_5 | bank_6_other;
    assign other_7 = other_6 | bank_7_other;
    assign both_and_unused = addend_0 + addend_1;
    assign place =
        {i_hits[3] & ~i_early[3] & ~hit_before_2, i_hits[3] & i_early[3] & ~hit_before_2,
        i_hits[2] & ~i_early[2] & ~hit_before_1, i_hits[2] & i_early[2] & ~hit_before_1,
        i_hits[1] & ~i_early[1] & ~hit_before_0, i_hits[1] & i_early[1] & ~hit_before_0,
        i_hits[0] & ~i_early[0], i_hits[0] & i_early[0]};
    assign o_bins =
        {bank_7_read, bank_6_read, bank_5_read, bank_4_read, bank_3_read, bank_2_read,
        bank_1_read, bank_0_read};
    assign addend_0 = {chosen_0_r, 1'b1};
    assign addend_1 = {chosen_1_r, 1'b1};

    bin_bank bank_0 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[0]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[0]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (choice_0),
        .o_other      (other_0),
        .o_read       (bank_0_read)
    );

    bin_bank bank_1 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[1]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[1]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (bank_1_bin),
        .o_other      (bank_1_other),
        .o_read       (bank_1_read)
    );

    bin_bank bank_2 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[2]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[2]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (bank_2_bin),
        .o_other      (bank_2_other),
        .o_read       (bank_2_read)
    );

    bin_bank bank_3 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[3]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[3]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (bank_3_bin),
        .o_other      (bank_3_other),
        .o_read       (bank_3_read)
    );

    bin_bank bank_4 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[4]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[4]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (choice_4),
        .o_other      (other_4),
        .o_read       (bank_4_read)
    );

    bin_bank bank_5 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[5]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[5]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (bank_5_bin),
        .o_other      (bank_5_other),
        .o_read       (bank_5_read)
    );

    bin_bank bank_6 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[6]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[6]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (bank_6_bin),
        .o_other      (bank_6_other),
        .o_read       (bank_6_read)
    );

    bin_bank bank_7 (
        .i_clk        (i_clk),
        .i_rst        (i_rst),
        .i_row        (i_row),
        .i_half       (i_half),
        .i_read_row   (i_read_row),
        .i_go         (i_go),
        .i_come_hit   (hit_1_r[7]),
        .i_come_half  (i_come_half),
        .i_hit        (hit_4_r[7]),
        .i_first      (i_added_first),
        .i_lowest     (sum_r[0]),
        .i_above      (above_r),
        .i_write_row  (i_write_row),
        .i_write_half (i_write_half),
        .o_bin        (bank_7_bin),
        .o_other      (bank_7_other),
        .o_read       (bank_7_read)
    );

    always @(posedge i_clk) begin
        if (i_rst) begin
            hit_0_r <= 8'd0;
            hit_1_r <= 8'd0;
            hit_2_r <= 8'd0;
            hit_3_r <= 8'd0;
            hit_4_r <= 8'd0;
            chosen_0_r <= 3'd0;
            chosen_1_r <= 3'd0;
            sum_r <= 3'd0;
            above_r <= 2'd0;
        end else begin
            hit_0_r <= place;
            hit_1_r <= hit_0_r;
            hit_2_r <= hit_1_r;
            hit_3_r <= hit_2_r;
            hit_4_r <= hit_3_r;
            chosen_0_r <= choice_3;
            chosen_1_r <= choice_7;
            if (i_held_half) begin
                chosen_0_r <= other_3;
            end
            if (i_held_half) begin
                chosen_1_r <= other_7;
            end
            if (i_held_first) begin
                chosen_0_r <= 3'd0;
            end
            if (i_held_first) begin
                chosen_1_r <= 3'd0;
            end
            sum_r <= both_and_unused[3:1];
            above_r <= sum_r[2:1];
        end
    end

endmodule

`default_nettype wire

// A running sum of the words of hits, and what it grew by from dump to dump. It begins as the
// design's does, which may have counted anything since the last dump.
module spec_count #(
    parameter BITS = 1,
    parameter DELAY = 1,   // clocks from a word to the sum
    parameter SETTLING = 1 // clocks from a dump until all of a count is there
) (
    input wire i_clk,
    input wire i_rst,
    input wire signed [`WORD_BITS-1:0] word,
    input wire dump,
    input wire [BITS-1:0] base_seen, // of the design, at first
    output reg signed [BITS-1:0] exact,
    output wire is_settled
);
    reg [`WORD_BITS*DELAY-1:0] words;
    wire signed [`WORD_BITS-1:0] added = words[`WORD_BITS*DELAY-1 -: `WORD_BITS];
    reg has_begun;
    initial has_begun = 1'b0;
    reg signed [BITS-1:0] sum_since, total, base_since;
    wire [BITS-1:0] base = has_begun ? base_since : base_seen;
    wire signed [BITS-1:0] sum = has_begun ? sum_since : -base_seen;
    wire [BITS-1:0] growth = total - base;
    always @* assert (growth == sum);
    always @(posedge i_clk) begin
        words <= i_rst ? 0 : {words, word};
        has_begun <= 1'b1;
        sum_since <= i_rst ? 0 : dump ? added : sum + added;
        total <= i_rst ? 0 : total + added;
        base_since <= i_rst ? 0 : dump ? total : base;
        exact <= i_rst ? 0 : dump ? sum : exact;
    end
    generate
        if (SETTLING == 1) begin : at_once
            assign is_settled = 1'b1;
        end else begin : in_segments
            reg [SETTLING:1] since;
            reg settled;
            always @(posedge i_clk) begin
                since <= i_rst ? 0 : {since, dump};
                settled <= i_rst ? 0 : ~dump & (settled | since[SETTLING-1]);
            end
            assign is_settled = settled;
        end
    endgenerate
endmodule

// One hit per rising edge of a detector's level, whatever the border between words, and only
// within a scan. A count is the sum since the last dump of hits that the reference counts up less
// those that it counts down: all that came before a dump, and nothing twice or lost at it. A count
// that does not fit is saturated and flagged, never wrapped. (Dumps, the scan's clocks and the
// reference are arbitrary here, and so is, at first, what a total of one segment grew by since the
// last dump: the clocks that it takes to count so far show nothing.)
module prove_counts (
    `INPUTS,
    input wire run,
    input wire may_dump,
    input wire [`DETECTORS*(`SAMPLES+`PARALLEL-1)-1:0] windows
);
    `DESIGN
    localparam WINDOW = `SAMPLES + `PARALLEL - 1;
    // Levels of a detector whose edges count.
    localparam LEVELS = `ADDED_CELLS ? `CELLS : 1;
    wire [`DETECTORS*`PARALLEL*`COUNT_BITS-1:0] counts;
    wire [`DETECTORS*`PARALLEL-1:0] clamped;
    wire [`DETECTORS*`TOTAL_BITS-1:0] totals;
    wire [`DETECTORS*`PARALLEL*`EXACT_BITS-1:0] bases;
    wire [`DETECTORS*`TOTAL_EXACT_BITS-1:0] total_bases;

    // Segments of a total are settled one after another.
    reg [`SEGMENTS+`BANKS:1] dumped;
    wire dump = may_dump & ~i_rst & (`SEGMENTS == 1 | ~(|dumped[2:1]));
    wire [`SEGMENTS+`BANKS:0] dumps_since = {dumped, dump};
    always @(posedge i_clk) dumped <= i_rst ? 0 : {dumped, dump};
    wire [`SEGMENTS-1:0] dumps = dumps_since[`SEGMENTS-1:0];

    genvar d, q, s;
    generate
        for (d = 0; d < `DETECTORS; d = d + 1) begin : detector
            wire [LEVELS*`SAMPLES-1:0] level;
            if (`ADDED_CELLS) begin : of_cells
                assign level = i_samples[d*`CELLS*`SAMPLES +: `CELLS*`SAMPLES]
                    ^ {`CELLS*`SAMPLES{`INVERTED}};
            end else begin : of_detector
                // As many cells as it takes have a pulse.
                for (s = 0; s < `SAMPLES; s = s + 1) begin : sample
                    reg [6:0] pulses;
                    integer c;
                    always @* begin
                        pulses = 0;
                        for (c = 0; c < `CELLS; c = c + 1)
                            pulses = pulses + (i_samples[(d*`CELLS+c)*`SAMPLES+s] ^ `INVERTED);
                    end
                    assign level[s] = `ODD_CELLS ? pulses[0] : pulses >= `COINCIDENCE;
                end
            end
            // Samples of a pulse after one without.
            wire [LEVELS*`SAMPLES-1:0] hits;
            for (s = 0; s < LEVELS; s = s + 1) begin : edges
                wire [`SAMPLES-1:0] now = level[s*`SAMPLES +: `SAMPLES];
                reg last_level;
                reg [`SAMPLES-1:0] rising;
                always @(posedge i_clk) begin
                    last_level <= i_rst ? 0 : now[`SAMPLES-1];
                    rising <= i_rst ? 0 : now & ~{now, last_level} & {`SAMPLES{run}};
                end
                assign hits[s*`SAMPLES +: `SAMPLES] = rising;
            end
            wire above_total;
            if (`SENDS_TOTAL) begin : all_hits
                reg signed [`WORD_BITS-1:0] word;
                integer l;
                always @* begin
                    word = 0;
                    for (l = 0; l < LEVELS*`SAMPLES; l = l + 1) word = word + hits[l];
                end
                wire [`TOTAL_EXACT_BITS-1:0] exact;
                wire is_settled;
                spec_count #(
                    .BITS(`TOTAL_EXACT_BITS), .DELAY(`ADDER_CLOCKS), .SETTLING(`SETTLING_CLOCKS)
                ) spec (
                    .i_clk(i_clk), .i_rst(i_rst), .word(word), .dump(dump),
                    .base_seen(
                        `SEGMENTS == 1 ? total_bases[d*`TOTAL_EXACT_BITS +: `TOTAL_EXACT_BITS] : 0
                    ),
                    .exact(exact), .is_settled(is_settled)
                );
                assign above_total = |(exact >> `TOTAL_BITS);
                wire [`TOTAL_BITS-1:0] fits = above_total ? {`TOTAL_BITS{1'b1}} : exact;
                always @*
                    if (is_settled) assert (totals[d*`TOTAL_BITS +: `TOTAL_BITS] == fits);
            end else begin : no_total
                assign above_total = 1'b0;
            end
            for (q = 0; q < `PARALLEL; q = q + 1) begin : step
                localparam BANK = q / `BANK_STEPS;
                localparam PLACE = d * `PARALLEL + q;
                reg signed [`WORD_BITS-1:0] word;
                integer l;
                always @* begin
                    word = 0;
                    for (l = 0; l < LEVELS*`SAMPLES; l = l + 1)
                        if (hits[l])
                            word = windows[d*WINDOW+`PARALLEL-1-q+l%`SAMPLES] ? word + 1 : word - 1;
                end
                wire signed [`EXACT_BITS-1:0] exact;
                wire is_settled;
                spec_count #(
                    .BITS(`EXACT_BITS), .DELAY(`ADDER_CLOCKS + BANK), .SETTLING(`SETTLING_CLOCKS)
                ) spec (
                    .i_clk(i_clk), .i_rst(i_rst), .word(word), .dump(dumps_since[BANK]),
                    .base_seen(`SEGMENTS == 1 ? bases[PLACE*`EXACT_BITS +: `EXACT_BITS] : 0),
                    .exact(exact), .is_settled(is_settled)
                );
                wire [`COUNT_BITS-1:0] count = counts[PLACE*`COUNT_BITS +: `COUNT_BITS];
                if (`SATURATES) begin : saturation
                    // A count fits if all bits from its sign up are equal.
                    wire [`EXACT_BITS-`COUNT_BITS:0] high = exact[`EXACT_BITS-1:`COUNT_BITS-1];
                    wire is_beyond = (|high) & ~(&high);
                    wire [`COUNT_BITS-1:0] limit =
                        {exact[`EXACT_BITS-1], {`COUNT_BITS-1{~exact[`EXACT_BITS-1]}}};
                    wire [`COUNT_BITS-1:0] fits = is_beyond ? limit : exact[`COUNT_BITS-1:0];
                    always @* if (is_settled) assert (count == fits);
                    always @*
                        if (is_settled)
                            assert (clamped[PLACE] == (is_beyond | (q == 0 & above_total)));
                end else begin : whole
                    always @* if (is_settled) assert (count == exact);
                end
            end
        end
    endgenerate
    `REACHES(dumped[1])
endmodule

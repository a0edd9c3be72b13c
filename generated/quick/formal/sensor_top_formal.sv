// What sensor_top has to do: a module for each proof of sensor_top.sby
//
// Each has the design, a specification of its own, and assertions. Registers start as one clock
// of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any
// time. Outputs of modules inside are seen, or cut and driven by the proof, by sensor_top.sby.
//
// Made by  goldtof emit quick.toml (goldtof 0.1.0)

`default_nettype none

// The numbers of this design, and its codes.
`define TOP sensor_top
`define SOURCES 1
`define DETECTORS 1
`define CELLS 1
`define COINCIDENCE 1
`define SAMPLES 8
`define DATA_BITS 16
`define COUNT_BITS 15
`define TOTAL_BITS 1
`define TOTAL_EXACT_BITS 1
`define PEAK_STEP_BITS 1
`define INVERTED 1'b0
`define ODD_CELLS 1'b0
`define ADDED_CELLS 1'b0
`define SATURATES 1'b0
`define SENDS_TOTAL 1'b0
`define FINDS_PEAK 1'b0
`define REALIGNS 1'b0
`define PARALLEL 1
`define LAST_STEPS 1
`define RESULTS 1
`define EXACT_BITS 15
`define WORD_BITS 4
`define SIGNED_BITS 16
`define SEGMENTS 1
`define SETTLING_CLOCKS 1
`define BANKS 1
`define BANK_STEPS 4
`define CLOCKS_TO_DUMP 5
`define CLOCKS_TO_COUNTED 6
`define COUNTING_CLOCKS 1
`define SCAN_CLOCKS 10
`define ADDER_CLOCKS 3
`define FIRST_SAMPLE 0
`define KEPT_CHIPS 2
`define FIRST_CHIPS {2'b10}
`define CHIPS 2500
`define GROUPS 248
`define CHIP_COUNT_BITS 12
`define CHIP_COUNT_TAPS 12'h941
`define CHIP_COUNT_FIRST 12'hfff
`define CHIP_COUNT_END 12'h7ee
`define CHIP_COUNT_RESET 12'hffe
`define STEP_COUNT_BITS 8
`define STEP_COUNT_TAPS 8'h1d
`define STEP_COUNT_FIRST 8'hff
`define STEP_COUNT_END 8'h42

module spec_code_of_source #(
    parameter NUMBER = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    generate
        case (NUMBER)
            0: spec_code #(.DEGREE(5), .TAPS_U(5'h9), .FIRST_U(5'h1f), .TAPS_V(5'hf), .FIRST_V(5'h1f)) is (.*);
        endcase
    endgenerate
endmodule

module spec_code_of_reference #(
    parameter NUMBER = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    generate
        case (NUMBER)
            0: spec_code #(.DEGREE(5), .TAPS_U(5'h9), .FIRST_U(5'h1f), .TAPS_V(5'hf), .FIRST_V(5'h1f)) is (.*);
        endcase
    endgenerate
endmodule

module spec_code_of_detector #(
    parameter NUMBER = 0
) (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    generate
        case (NUMBER)
            0: spec_code #(.DEGREE(5), .TAPS_U(5'h9), .FIRST_U(5'h1f), .TAPS_V(5'hf), .FIRST_V(5'h1f)) is (.*);
        endcase
    endgenerate
endmodule

// What a host drives and sees, of a design with registers.
`ifdef SETTINGS_BITS
`define HOST_INPUTS , \
    input wire [11:0] s_axil_awaddr, \
    input wire s_axil_awvalid, \
    input wire [31:0] s_axil_wdata, \
    input wire [3:0] s_axil_wstrb, \
    input wire s_axil_wvalid, \
    input wire s_axil_bready, \
    input wire [11:0] s_axil_araddr, \
    input wire s_axil_arvalid, \
    input wire s_axil_rready
`define HOST_OUTPUTS \
    wire s_axil_awready; \
    wire s_axil_wready; \
    wire [1:0] s_axil_bresp; \
    wire s_axil_bvalid; \
    wire s_axil_arready; \
    wire [31:0] s_axil_rdata; \
    wire [1:0] s_axil_rresp; \
    wire s_axil_rvalid;
`else
`define HOST_INPUTS
`define HOST_OUTPUTS
`endif

// The design and its outputs, of which a proof has those that the design has. A proof has the
// inputs as its own.
`define DESIGN \
    wire [`SOURCES-1:0] o_laser; \
    wire o_epoch; \
    wire [`DATA_BITS-1:0] m_axis_tdata; \
    wire m_axis_tvalid; \
    wire m_axis_tlast; \
    wire o_overrun; \
    wire o_saturated; \
    wire [`DETECTORS*`PEAK_STEP_BITS-1:0] o_peak_step; \
    wire [`DETECTORS*`COUNT_BITS-1:0] o_peak_count; \
    wire o_peak_valid; \
    `HOST_OUTPUTS \
    `TOP dut (.*);

`define INPUTS_BUT_RESET \
    input wire i_clk, \
    input wire [`DETECTORS*`CELLS*`SAMPLES-1:0] i_samples, \
    input wire m_axis_tready \
    `HOST_INPUTS

`define INPUTS \
    input wire i_rst, \
    `INPUTS_BUT_RESET

// That what a proof is about can be: its task `..._cover` shows how.
`ifdef COVER
`define REACHES(condition) always @* assume (!(condition));
`else
`define REACHES(condition)
`endif

// Induction: registers are anything at first, but such that what is to hold does for so many
// clocks; then it does in the next one.
`define HOLDS_BEHIND(count, condition) \
    reg [$clog2(count + 1)-1:0] clocks = 0; \
    reg held; \
    always @(posedge i_clk) begin \
        clocks <= clocks + (clocks != count); \
        held <= (held | clocks == 0) & (condition); \
    end \
    always @* if (clocks == count & held) assert (condition);

// A clock of reset leaves every register at the value that the other proofs start from, whatever
// it held, and no X. The assertions are those of registers.v, one for each register.
module prove_reset (
    `INPUTS_BUT_RESET
);
    wire i_rst = 1'b1;
    `DESIGN
endmodule

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

// After reset every laser shows its source's code, chip by chip, and o_epoch the first chip of the
// reference's. No LFSR reaches zero. (That an LFSR comes back to its first state after 2^n - 1
// chips and not before is a matter of its polynomial, not of the design.)
module prove_codes (
    `INPUTS
);
    `DESIGN
    wire [`SOURCES-1:0] chips;
    wire epoch;
    genvar m;
    generate
        for (m = 0; m < `SOURCES; m = m + 1) begin : source
            spec_code_of_source #(.NUMBER(m)) spec (
                .i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(chips[m]), .epoch()
            );
        end
    endgenerate
    spec_code_of_reference reference (
        .i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(), .epoch(epoch)
    );
    reg [`SOURCES-1:0] laser;
    reg first;
    always @(posedge i_clk) begin
        laser <= i_rst ? 0 : chips;
        first <= i_rst ? 0 : epoch;
    end
    always @* assert (o_laser == laser);
    always @* assert (o_epoch == first);
    // What the controller waits for, where a scan waits for an epoch.
    wire epoch_seen;
    generate
        if (`REALIGNS) begin : awaited
            always @* assert (epoch_seen == epoch);
        end
    endgenerate
    `REACHES(o_epoch & ~i_rst)
endmodule

// A step ends so many chips after it began, and the next begins with the next clock; a scan has so
// many of them (groups, with several at once), and follows the one before, or begins with an epoch
// of the reference. The ends of steps and scans reach the totals and the stream after a fixed
// number of clocks. Chips and steps are counted in the order of LFSRs, as in the design; the states
// in which they end are those after as many steps of the recurrence. When an epoch comes is
// anything here; `codes` shows it.
module prove_scan (
    `INPUTS
);
    `DESIGN
    // Of the design's scan controller; what it does not have is not looked at.
    wire run_seen, step_end_seen, counted_seen, last_seen, epoch_seen, start_seen;
    wire step_ends_seen, counts_seen, last_step_seen;
    wire [`SEGMENTS-1:0] dump_seen;
    wire [`CHIP_COUNT_BITS-1:0] chip_seen;
    wire [`STEP_COUNT_BITS-1:0] step_seen;

    reg running;
    wire ends_step, ends_scan, start;
    generate
        if (`REALIGNS) begin : waits
            assign start = epoch_seen & (~running | ends_scan);
            always @(posedge i_clk) running <= i_rst ? 0 : (start | (running & ~ends_scan));
        end else begin : goes_on
            assign start = start_seen;
            always @(posedge i_clk) running <= i_rst ? 1'b0 : 1'b1;
        end
    endgenerate

    // Chip CHIPS - 3 of a step, counted from 0, is recognised; the last but one follows.
    reg before_last;
    wire chip_holds;
    generate
        if (`CHIPS == 1) begin : one_chip
            assign ends_step = running;
            assign chip_holds = 1'b1;
        end else begin : chips
            reg last_chip;
            always @(posedge i_clk) last_chip <= i_rst ? 0 : before_last;
            assign ends_step = last_chip;
            if (`CHIPS == 2) begin : every_other
                wire first = `REALIGNS ? start | (ends_step & ~ends_scan) : ~before_last;
                always @(posedge i_clk) before_last <= i_rst ? 0 : first;
                assign chip_holds = 1'b1;
            end else begin : counted
                reg [`CHIP_COUNT_BITS-1:0] chip;
                always @(posedge i_clk) begin
                    if (i_rst) chip <= `CHIP_COUNT_RESET;
                    else if (ends_step) chip <= `CHIP_COUNT_FIRST;
                    else if (running | !`REALIGNS)
                        chip <= {^(chip & `CHIP_COUNT_TAPS), chip[`CHIP_COUNT_BITS-1:1]};
                    before_last <= i_rst ? 0 : running & chip == `CHIP_COUNT_END;
                end
                // In a pause the counter stands where the next step begins.
                assign chip_holds = (chip_seen == chip) & (chip != 0)
                    & (!`REALIGNS | running | chip == `CHIP_COUNT_FIRST);
            end
        end
    endgenerate

    // Step GROUPS - 2 of a scan, counted from 0, is the last but one.
    wire step_holds;
    generate
        if (`GROUPS == 1) begin : one_step
            assign ends_scan = ends_step;
            assign step_holds = 1'b1;
        end else begin : steps
            reg [`STEP_COUNT_BITS-1:0] step;
            reg last_step;
            assign ends_scan = ends_step & last_step;
            always @(posedge i_clk) begin
                if (i_rst | ends_scan) step <= `STEP_COUNT_FIRST;
                else if (ends_step)
                    step <= {^(step & `STEP_COUNT_TAPS), step[`STEP_COUNT_BITS-1:1]};
                if (i_rst) last_step <= 0;
                else if (ends_step) last_step <= step == `STEP_COUNT_END;
            end
            assign step_holds = (step_seen == step) & (step != 0) & (last_step_seen == last_step);
        end
    endgenerate

    // What the rest of the design is told, and when.
    reg [`CLOCKS_TO_COUNTED:1] ended;
    reg [`CLOCKS_TO_COUNTED:1] scan_ended;
    always @(posedge i_clk) begin
        ended <= i_rst ? 0 : {ended, ends_step};
        scan_ended <= i_rst ? 0 : {scan_ended, ends_scan};
    end
    wire holds = (run_seen == running)
        & (start_seen == start) & chip_holds & step_holds
        // As `reference` has it.
        & (`CHIPS == 1 | !`REALIGNS | ~(start_seen & step_ends_seen))
        & (`CHIPS == 1 | step_ends_seen == before_last)
        & (`RESULTS == 1 | counts_seen == ended[`CLOCKS_TO_COUNTED-1])
        & (step_end_seen == ends_step)
        & (dump_seen == ended[`CLOCKS_TO_DUMP+`SEGMENTS-1:`CLOCKS_TO_DUMP])
        & (counted_seen == ended[`CLOCKS_TO_COUNTED])
        & (last_seen == scan_ended[`CLOCKS_TO_COUNTED]);
    `HOLDS_BEHIND(`SCAN_CLOCKS, holds)
    `REACHES(clocks == `SCAN_CLOCKS & held & ends_scan)
endmodule

// Each sample's reference is the chip of the detector's code that the delay of its phase step gives
// it: in step k sample l of chip n has chip floor((n S + l - k) / S). The delay is a number here;
// the reference's generator stands still, and chips come again, as it grows. When steps end and
// scans begin is anything that `scan` proves of the scan controller, and more: steps may be short. So
// this holds together with `scan`.
module prove_reference (
    `INPUTS,
    input wire may_end,
    input wire may_start
);
    `DESIGN
    localparam WINDOW = `SAMPLES + `PARALLEL - 1;
    localparam WHOLE = `PARALLEL / `SAMPLES;
    localparam REST = `PARALLEL % `SAMPLES;
    // Chips that the reference goes back by, at most, when the delay grows.
    localparam REPLAYED = (`PARALLEL + `SAMPLES - 1) / `SAMPLES - 1;
    localparam KEPT = `KEPT_CHIPS;
    localparam SAMPLE_BITS = `SAMPLES > 1 ? $clog2(`SAMPLES) : 1;

    // A step ends with the clock behind its last chip but one; two ends are at least a step apart, or
    // the chips that come again and two, whichever is less. A scan begins behind an end or in a
    // pause, and so not where a step has a chip to go.
    localparam APART = `CHIPS - 1 < REPLAYED + 1 ? `CHIPS - 1 : REPLAYED + 1;
    reg [APART+1:1] ended;
    wire before_last = may_end & ~i_rst & ~(|(ended & ((1 << APART) - 1)));
    always @(posedge i_clk) ended <= i_rst ? 0 : {ended, before_last};
    wire ends = `CHIPS > 1 ? ended[1] : before_last;
    wire start = `REALIGNS ? may_start & ~i_rst & ~(`CHIPS > 1 & before_last) : 1'b0;
    wire [`DETECTORS*WINDOW-1:0] windows;

    // Samples of the delay beside whole chips, and the whole chips by which it grows.
    reg [SAMPLE_BITS-1:0] samples;
    wire wraps = REST != 0 & samples >= `SAMPLES - REST;
    wire [7:0] growth = WHOLE + wraps;
    always @(posedge i_clk)
        if (i_rst | start) samples <= `FIRST_SAMPLE;
        else if (ends) samples <= samples + REST;

    genvar d, i;
    generate
        for (d = 0; d < `DETECTORS; d = d + 1) begin : detector
            // The code's chips, the present one in bit 0.
            reg [KEPT-1:0] chips;
            wire next, again, waits;
            wire [`DETECTORS*KEPT-1:0] first_chips = `FIRST_CHIPS;
            spec_code_of_detector #(.NUMBER(d)) spec (
                .i_clk(i_clk), .i_rst(i_rst), .advance(~waits), .load(start), .chip(next), .epoch()
            );
            always @(posedge i_clk)
                if (i_rst | start) chips <= first_chips[d*KEPT +: KEPT];
                else if (ends & growth != 0) chips <= chips >> (growth - 1);
                else chips <= {chips, again};
            if (REPLAYED == 0) begin : waiting
                assign waits = ends & growth != 0;
                assign again = next;
            end else begin : replaying
                // The chips that come again after the reference went back.
                reg [REPLAYED-1:0] saved;
                reg [REPLAYED-1:0] replays;
                assign again = replays[REPLAYED-1] ? saved[REPLAYED-1] : next;
                assign waits = ends | replays[REPLAYED-1];
                always @(posedge i_clk)
                    if (i_rst) begin
                        saved <= 0;
                        replays <= 0;
                    end else begin
                        saved <= ends ? chips << (REPLAYED - (growth - 1)) : saved << 1;
                        replays <= start ? 0
                            : ends ? {REPLAYED{1'b1}} << (REPLAYED - (growth - 1)) : replays << 1;
                    end
            end
            for (i = 0; i < WINDOW; i = i + 1) begin : sample
                // Whole chips between the group's first step and this sample, and the place in
                // the chip; a sample behind the window's first chips lies in the present one.
                localparam BACK =
                    i >= `PARALLEL - 1 ? 0 : (`PARALLEL - 1 - i + `SAMPLES - 1) / `SAMPLES;
                localparam PLACE = i + BACK * `SAMPLES - (`PARALLEL - 1);
                wire chosen;
                if (REST != 0 && PLACE + 1 < `SAMPLES)
                    assign chosen = samples > PLACE ? chips[BACK+1] : chips[BACK];
                else if (REST == 0 && PLACE < `FIRST_SAMPLE)
                    assign chosen = chips[BACK+1];
                else
                    assign chosen = chips[BACK];
                reg expected;
                always @(posedge i_clk) expected <= i_rst ? 0 : chosen;
                always @* assert (windows[d*WINDOW+i] == expected);
            end
        end
    endgenerate
    `REACHES(ends & ~i_rst & windows != 0)
endmodule

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

// The stream carries each group's counts, one per beat, detector 0's steps, then detector 1's, ...,
// each once and in order, with tlast at the scan's last and nowhere else. A group that comes while
// others wait is dropped whole and sets o_overrun, a group with a saturated count, dropped or not,
// o_saturated; both stay until reset. (Counts, and when they come, are arbitrary here.)
module prove_stream (
    `INPUTS,
    input wire may_come,
    input wire may_end,
    input wire [`DETECTORS*`PARALLEL*`COUNT_BITS-1:0] counts,
    input wire [`DETECTORS*`PARALLEL-1:0] clamped,
    input wire [`DETECTORS*`TOTAL_BITS-1:0] totals
);
    `DESIGN
    localparam MOST = `DETECTORS * `PARALLEL;
    localparam LEAST = `DETECTORS * `LAST_STEPS;
    localparam LEFT_BITS = $clog2(MOST + 1);

    // Steps of one chip may end in every clock; others leave one between.
    reg counted;
    reg last;
    wire comes = may_come & (`CHIPS == 1 | ~counted);
    always @(posedge i_clk) begin
        counted <= i_rst ? 0 : comes;
        last <= i_rst ? 0 : comes & may_end;
    end

    // Beats of the present group that are still to be taken.
    reg [LEFT_BITS-1:0] left;
    reg ends_scan;
    wire taken = left != 0 & m_axis_tready;
    wire free = left == 0 | (left == 1 & taken);
    wire accepted = counted & free;
    always @(posedge i_clk) begin
        if (i_rst) left <= 0;
        else if (accepted) left <= last ? LEAST : MOST;
        else left <= left - taken;
        if (i_rst) ends_scan <= 0;
        else if (accepted) ends_scan <= last;
    end
    always @* assert (m_axis_tvalid == (left != 0));
    always @* if (m_axis_tvalid) assert (m_axis_tlast == (ends_scan & left == 1));

    // The group's results, the one on offer first; of a scan's last group, which may have fewer
    // steps, they stand closer.
    wire [MOST*`DATA_BITS-1:0] whole;
    wire [MOST*`DATA_BITS-1:0] short;
    reg [MOST*`DATA_BITS-1:0] beats;
    wire [MOST-1:0] is_in_short;
    genvar place;
    generate
        for (place = 0; place < MOST; place = place + 1) begin : beat
            localparam DETECTOR = place / `PARALLEL;
            localparam STEP = place % `PARALLEL;
            wire [`COUNT_BITS-1:0] count = counts[place*`COUNT_BITS +: `COUNT_BITS];
            wire [`SIGNED_BITS-1:0] signed_count = {
                {`SIGNED_BITS-`COUNT_BITS+1{count[`COUNT_BITS-1]}}, count[`COUNT_BITS-2:0]
            };
            if (`SENDS_TOTAL)
                assign whole[place*`DATA_BITS +: `DATA_BITS] =
                    {totals[DETECTOR*`TOTAL_BITS +: `TOTAL_BITS], signed_count};
            else
                assign whole[place*`DATA_BITS +: `DATA_BITS] = signed_count;
            // The place in a whole group of what has this place in a short one.
            localparam FROM = place < LEAST
                ? place / `LAST_STEPS * `PARALLEL + place % `LAST_STEPS : place;
            assign short[place*`DATA_BITS +: `DATA_BITS] = whole[FROM*`DATA_BITS +: `DATA_BITS];
            assign is_in_short[place] = STEP < `LAST_STEPS;
        end
    endgenerate
    always @(posedge i_clk)
        beats <= i_rst ? 0 : accepted ? (last ? short : whole) : taken ? beats >> `DATA_BITS : beats;
    always @* if (m_axis_tvalid) assert (m_axis_tdata == beats[`DATA_BITS-1:0]);

    // What stays until reset.
    reg lost;
    always @(posedge i_clk) lost <= i_rst ? 0 : (lost | (counted & ~free));
    always @* assert (o_overrun == lost);
    generate
        if (`SATURATES) begin : saturation
            reg saturated;
            wire clamps = |(last ? clamped & is_in_short : clamped);
            always @(posedge i_clk) saturated <= i_rst ? 0 : (saturated | (counted & clamps));
            always @* assert (o_saturated == saturated);
        end
    endgenerate
    `REACHES(m_axis_tvalid & counted & ~free)
endmodule

// In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken
// or reset. Flags stay until reset, the peak's ports until o_peak_valid.
module prove_axis (
    `INPUTS
);
    `DESIGN
    reg began = 1'b0;
    reg reset_before;
    reg waited;
    reg held_last;
    reg overran;
    reg [`DATA_BITS-1:0] held_data;
    always @(posedge i_clk) begin
        began <= 1'b1;
        reset_before <= i_rst;
        waited <= m_axis_tvalid & ~m_axis_tready;
        held_last <= m_axis_tlast;
        held_data <= m_axis_tdata;
        overran <= o_overrun;
    end
    wire stays = began & ~reset_before;
    always @* if (stays & waited) assert (m_axis_tvalid);
    always @* if (stays & waited) assert (m_axis_tlast == held_last);
    always @* if (stays & waited) assert (m_axis_tdata == held_data);
    always @* if (stays & overran) assert (o_overrun);
    always @* if (~stays) assert (o_laser == 0);
    always @* if (~stays) assert (o_epoch == 0);
    always @* if (~stays) assert (m_axis_tdata == 0);
    always @* if (~stays) assert (m_axis_tvalid == 0);
    always @* if (~stays) assert (m_axis_tlast == 0);
    always @* if (~stays) assert (o_overrun == 0);
    generate
        if (`SATURATES) begin : saturation
            reg saturated;
            always @(posedge i_clk) saturated <= o_saturated;
            always @* if (stays & saturated) assert (o_saturated);
            always @* if (~stays) assert (o_saturated == 0);
        end
        if (`FINDS_PEAK) begin : peaks
            reg [`DETECTORS*(`PEAK_STEP_BITS+`COUNT_BITS)-1:0] peak;
            always @(posedge i_clk) peak <= {o_peak_step, o_peak_count};
            always @* if (stays & ~o_peak_valid) assert ({o_peak_step, o_peak_count} == peak);
            always @* if (~stays) assert (o_peak_step == 0);
            always @* if (~stays) assert (o_peak_count == 0);
            always @* if (~stays) assert (o_peak_valid == 0);
        end
    endgenerate
    `REACHES(stays & waited & overran)
endmodule

`default_nettype wire

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

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

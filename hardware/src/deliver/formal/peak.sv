// After a scan's last counts o_peak_valid is high for one clock, and from then on o_peak_count and
// o_peak_step are the scan's largest count and its phase step, the first of equal ones, steady
// until the next scan's. (Counts are arbitrary here; they come no faster than the design's.) This
// is not proven: it is searched for a counterexample through 30 clocks after reset. That the ports
// stay steady is proven, in `axis`.
module prove_peak (
    `INPUTS,
    input wire may_come,
    input wire may_end,
    input wire [`DETECTORS*`PARALLEL*`COUNT_BITS-1:0] any
);
    `DESIGN
    localparam ALL_BITS = `DETECTORS * `PARALLEL * `COUNT_BITS;
    // Clock after `counted` in which the last step's comparison is done, of a whole group and of a
    // scan's last.
    localparam WHOLE = (`PARALLEL - 1) * `PEAK_TURN_CLOCKS + `PEAK_COMPARED_CLOCKS + 1;
    localparam SHORT = (`LAST_STEPS - 1) * `PEAK_TURN_CLOCKS + `PEAK_COMPARED_CLOCKS + 1;
    localparam LONGEST =
        `PEAK_GROUP_CLOCKS > WHOLE + `PEAK_TURN_CLOCKS ? `PEAK_GROUP_CLOCKS : WHOLE + `PEAK_TURN_CLOCKS;

    // Clocks since a group began to come; its counts settle, and then stand still to the next.
    reg [$clog2(LONGEST+4)-1:0] since;
    reg busy;
    reg ends;
    wire comes = may_come & (~busy | since >= `PEAK_GROUP_CLOCKS);
    wire counted = busy & since == `COUNTING_CLOCKS;
    wire last = counted & ends;
    always @(posedge i_clk) begin
        if (i_rst) busy <= 0;
        else if (comes) busy <= 1;
        if (i_rst) since <= 0;
        else if (comes) since <= 1;
        else if (busy & ~&since) since <= since + 1'b1;
        if (i_rst) ends <= 0;
        else if (comes) ends <= may_end;
    end
    reg [ALL_BITS-1:0] held;
    wire [ALL_BITS-1:0] counts = busy & since <= `COUNTING_CLOCKS ? any : held;
    always @(posedge i_clk) held <= i_rst ? 0 : counts;

    // Groups that came 1, 2, ... clocks ago, and whether they end a scan.
    reg [WHOLE:1] came;
    reg [WHOLE:1] ended;
    always @(posedge i_clk) begin
        came <= i_rst ? 0 : {came, counted};
        ended <= i_rst ? 0 : {ended, last};
    end

    // When each of a group's counts has been compared, and its phase step.
    wire [`PARALLEL-1:0] turns;
    wire turn = |turns;
    wire last_turn = ended[SHORT];
    reg first;
    reg [`PEAK_STEP_BITS-1:0] k;
    reg [1:0] done;
    always @(posedge i_clk) begin
        if (i_rst | last_turn) first <= 1;
        else if (turn) first <= 0;
        if (i_rst | last_turn) k <= `FIRST_STEP;
        else if (turn) k <= k == `WRAPPING_STEP ? 0 : k + 1'b1;
        done <= i_rst ? 0 : {done, last_turn};
    end
    always @* assert (o_peak_valid == done[1]);

    // Counts as they are chosen, some clocks later.
    wire [ALL_BITS-1:0] chosen;
    genvar d, q;
    generate
        if (`PEAK_CHOOSING_CLOCKS == 0) begin : at_once
            assign chosen = counts;
        end else begin : later
            reg [`PEAK_CHOOSING_CLOCKS*ALL_BITS-1:0] line;
            always @(posedge i_clk) line <= i_rst ? 0 : {line, counts};
            assign chosen = line[(`PEAK_CHOOSING_CLOCKS-1)*ALL_BITS +: ALL_BITS];
        end
        for (q = 0; q < `PARALLEL; q = q + 1) begin : step
            localparam AT = q * `PEAK_TURN_CLOCKS + `PEAK_COMPARED_CLOCKS + 1;
            assign turns[q] = came[AT] & (q < `LAST_STEPS | ~ended[AT]);
        end
        for (d = 0; d < `DETECTORS; d = d + 1) begin : detector
            reg signed [`COUNT_BITS-1:0] present;
            integer s;
            always @* begin
                present = chosen[d*`PARALLEL*`COUNT_BITS +: `COUNT_BITS];
                for (s = 1; s < `PARALLEL; s = s + 1)
                    if (came[s*`PEAK_TURN_CLOCKS+`PEAK_COMPARED_CLOCKS+1])
                        present = chosen[(d*`PARALLEL+s)*`COUNT_BITS +: `COUNT_BITS];
            end
            reg signed [`COUNT_BITS-1:0] largest;
            reg [`PEAK_STEP_BITS-1:0] best;
            reg [`COUNT_BITS-1:0] peak;
            reg [`PEAK_STEP_BITS-1:0] peak_step;
            wire greater = first | present > largest;
            always @(posedge i_clk) begin
                if (i_rst) largest <= 0;
                else if (turn & greater) largest <= present;
                if (i_rst) best <= 0;
                else if (turn & greater) best <= k;
                if (i_rst) peak <= 0;
                else if (done[0]) peak <= largest;
                if (i_rst) peak_step <= 0;
                else if (done[0]) peak_step <= best;
            end
            always @* assert (o_peak_count[d*`COUNT_BITS +: `COUNT_BITS] == peak);
            always @* assert (o_peak_step[d*`PEAK_STEP_BITS +: `PEAK_STEP_BITS] == peak_step);
        end
    endgenerate
    `REACHES(o_peak_valid)
endmodule

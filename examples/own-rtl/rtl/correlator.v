// Counts rising edges up where the delayed code is 1 and down where it is 0.
//
// Everything is counted in binary: chips of a step, steps of a scan, and the place of the
// word's first sample in the delayed code. With each new step that place is a sample behind.
`include "sensor_defs.vh"

module correlator (
    input  wire                clk,
    input  wire                rst,
    input  wire [`SAMPLES-1:0] samples,
    output reg                 done,
    output reg                 done_last,
    output reg  signed [15:0]  count,
    output reg  [7:0]          step
);
    localparam PLACES = `CODE_CHIPS * `SAMPLES;

    reg         started;
    reg         level;       // last sample of the word before
    reg  [11:0] chip;        // of the step
    reg  [7:0]  place;       // sample 0 of the word, in the delayed code

    wire        step_ends = chip == `STEP_CHIPS - 1;
    wire        scan_ends = step_ends && step == `SCAN_STEPS - 1;
    // A chip further; at the end of a step one sample less.
    wire [8:0]  forward   = place + `SAMPLES - step_ends;

    wire        chip_now, chip_next;
    code_rom rom (.chip(place[7:3]), .now(chip_now), .next(chip_next));

    always @(posedge clk)
        if (rst) begin
            started <= 0;
            level   <= 0;
            chip    <= 0;
            step    <= 0;
            place   <= 0;
        end else begin
            started <= 1;
            level   <= samples[`SAMPLES-1];
            if (started) begin
                chip  <= step_ends ? 0 : chip + 1;
                place <= forward >= PLACES ? forward - PLACES : forward;
                if (step_ends)
                    step <= scan_ends ? 0 : step + 1;
            end
        end

    // Edges of the word, each with its sign.
    reg  [`SAMPLES-1:0] edges;
    reg  [`SAMPLES-1:0] up;
    reg                 word_ends, word_last;
    integer             lane;

    always @(posedge clk)
        if (rst) begin
            edges     <= 0;
            up        <= 0;
            word_ends <= 0;
            word_last <= 0;
        end else begin
            edges     <= started ? samples & ~{samples[`SAMPLES-2:0], level} : 0;
            word_ends <= started && step_ends;
            word_last <= started && scan_ends;
            for (lane = 0; lane < `SAMPLES; lane = lane + 1)
                up[lane] <= place[2:0] + lane >= `SAMPLES ? chip_next : chip_now;
        end

    // Their sum, then as many registers as the FPGA needs.
    reg signed [4:0] sum;

    always @* begin
        sum = 0;
        for (lane = 0; lane < `SAMPLES; lane = lane + 1)
            if (edges[lane])
                sum = up[lane] ? sum + 5'sd1 : sum - 5'sd1;
    end

    reg signed [4:0]           sums [0:`ADDER_STAGES-1];
    reg [`ADDER_STAGES-1:0]    ends, lasts;
    integer                    stage;

    always @(posedge clk)
        for (stage = 0; stage < `ADDER_STAGES; stage = stage + 1)
            if (rst) begin
                sums[stage]  <= 0;
                ends[stage]  <= 0;
                lasts[stage] <= 0;
            end else begin
                sums[stage]  <= stage == 0 ? sum       : sums[stage-1];
                ends[stage]  <= stage == 0 ? word_ends : ends[stage-1];
                lasts[stage] <= stage == 0 ? word_last : lasts[stage-1];
            end

    reg signed [15:0]  total;
    wire signed [15:0] new_total = total + sums[`ADDER_STAGES-1];

    always @(posedge clk)
        if (rst) begin
            total     <= 0;
            count     <= 0;
            done      <= 0;
            done_last <= 0;
        end else begin
            total     <= ends[`ADDER_STAGES-1] ? 16'sd0 : new_total;
            done      <= ends[`ADDER_STAGES-1];
            done_last <= lasts[`ADDER_STAGES-1];
            if (ends[`ADDER_STAGES-1])
                count <= new_total;
        end
endmodule

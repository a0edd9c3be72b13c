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

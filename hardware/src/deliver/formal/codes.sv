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

// What sensor_top has to do: a module for each proof of sensor_top.sby
//
// Each has the design, a specification of its own, and assertions. Registers start as one clock
// of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any
// time. Outputs of modules inside are seen, or cut and driven by the proof, by sensor_top.sby.
//
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module code_of_source_0 (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    reg [10:0] u;
    reg [10:0] v;
    always @* assert (u != 0);
    always @* assert (v != 0);
    assign chip = u[0] ^ v[0];
    assign epoch = u == 11'h7ff;
    always @(posedge i_clk) begin
        if (i_rst | load) u <= 11'h7ff;
        else if (advance) u <= {u[0] ^ u[9], u[10:1]};
        if (i_rst | load) v <= 11'h7ff;
        else if (advance) v <= {v[0] ^ v[3] ^ v[6] ^ v[9], v[10:1]};
    end
endmodule

module code_of_reference (
    input wire i_clk,
    input wire i_rst,
    input wire advance,
    input wire load,
    output wire chip,
    output wire epoch
);
    reg [10:0] u;
    reg [10:0] v;
    always @* assert (u != 0);
    always @* assert (v != 0);
    assign chip = u[0] ^ v[0];
    assign epoch = u == 11'h7ff;
    always @(posedge i_clk) begin
        if (i_rst | load) u <= 11'h7ff;
        else if (advance) u <= {u[0] ^ u[9], u[10:1]};
        if (i_rst | load) v <= 11'h7ff;
        else if (advance) v <= {v[0] ^ v[3] ^ v[6] ^ v[9], v[10:1]};
    end
endmodule

// With i_rst high every register's next value is the one that the other proofs start from, whatever
// the registers hold: one clock of reset leaves nothing of the state before, and no X. (The
// assertions are those of registers.v, one for each register.)
// What a block_memory gives is anything, at any clock.
module prove_reset (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(1'b1),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

endmodule

// After reset every laser shows its source's code, chip by chip, and o_epoch the first chip of
// the reference's. No LFSR reaches zero. (That an LFSR comes back to its first state after
// 2^n - 1 chips and not before is a matter of its polynomial, not of the design.)
// What a block_memory gives is anything, at any clock.
module prove_codes (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(i_rst),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

    wire chips;
    code_of_source_0 spec_code_of_source_0 (.i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(chips), .epoch());
    wire epoch;
    code_of_reference spec_code_of_reference (.i_clk(i_clk), .i_rst(i_rst), .advance(1'b1), .load(1'b0), .chip(), .epoch(epoch));
    reg laser;
    reg first;
    always @(posedge i_clk) begin
        laser <= i_rst ? 0 : chips;
        first <= i_rst ? 0 : epoch;
    end
    always @* assert (o_laser == laser);
    always @* assert (o_epoch == first);
endmodule

// In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken
// or reset. Flags stay until reset, the peak's ports until o_peak_valid.
// What a block_memory gives is anything, at any clock.
module prove_axis (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [63:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    sensor_top dut (
        .i_clk(i_clk),
        .i_rst(i_rst),
        .o_laser(o_laser),
        .o_epoch(o_epoch),
        .i_samples(i_samples),
        .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready),
        .m_axis_tlast(m_axis_tlast),
        .o_overrun(o_overrun)
    );

    reg began = 1'b0;
    reg reset_before;
    reg waited;
    reg held_last;
    reg overran;
    always @(posedge i_clk) begin
        began <= 1'b1;
        reset_before <= i_rst;
        waited <= m_axis_tvalid & ~m_axis_tready;
        held_last <= m_axis_tlast;
        overran <= o_overrun;
    end
    wire stays = began & ~reset_before;
    always @* if (stays & waited) assert (m_axis_tvalid);
    always @* if (stays & waited) assert (m_axis_tlast == held_last);
    always @* if (stays & overran) assert (o_overrun);
    always @* if (~stays) assert (o_laser == 0);
    always @* if (~stays) assert (o_epoch == 0);
    always @* if (~stays) assert (m_axis_tdata == 0);
    always @* if (~stays) assert (m_axis_tvalid == 0);
    always @* if (~stays) assert (m_axis_tlast == 0);
    always @* if (~stays) assert (o_overrun == 0);
    reg [63:0] held_data;
    always @(posedge i_clk) held_data <= m_axis_tdata;
    always @* if (stays & waited) assert (m_axis_tdata == held_data);
endmodule

`default_nettype wire

// What sensor_top has to do: a module for each proof of sensor_top.sby
//
// Each has the design, a specification of its own, and assertions. Registers start as one clock
// of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any
// time. Outputs of modules inside are seen, or cut and driven by the proof, by sensor_top.sby.
//
// Made by  goldtof emit moving.toml (goldtof 0.1.0)

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

module code_of_detector_0 (
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
    assign epoch = u == 11'h4ff;
    always @(posedge i_clk) begin
        if (i_rst | load) u <= 11'h4ff;
        else if (advance) u <= {u[0] ^ u[9], u[10:1]};
        if (i_rst | load) v <= 11'h4ff;
        else if (advance) v <= {v[0] ^ v[3] ^ v[6] ^ v[9], v[10:1]};
    end
endmodule

// With i_rst high every register's next value is the one that the other proofs start from, whatever
// the registers hold: one clock of reset leaves nothing of the state before, and no X. (The
// assertions are those of registers.v, one for each register.)
module prove_reset (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
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
module prove_codes (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    wire epoch_seen;
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
    always @* assert (epoch_seen == epoch);
`ifdef COVER
    always @* assume (~((o_epoch & ~i_rst)));
`endif
endmodule

// A step ends 13100 chips after it began, and the next begins with the next clock; a
// scan has 65 of them (groups, with several at once), and begins with an epoch of the reference.
// The ends of steps and scans reach the totals and the stream after a fixed number of clocks.
// Chips and steps are counted in the order of LFSRs, as in the design; the states in which
// they end are those after as many steps of the recurrence. When an epoch comes is anything
// here; `codes` shows it.
module prove_scan (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    wire run;
    wire step_end;
    wire dump;
    wire counted;
    wire last;
    wire epoch;
    wire start_seen;
    wire [13:0] chip_seen;
    wire [6:0] step_seen;
    wire last_step_seen;
    wire step_ends;
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

    reg running;
    wire ends_step;
    wire ends_scan;
    wire start = epoch & (~running | ends_scan);
    always @(posedge i_clk)
        running <= i_rst ? 0 : (start | (running & ~ends_scan));
    reg before_last;
    reg last_chip;
    assign ends_step = last_chip;
    always @(posedge i_clk)
        last_chip <= i_rst ? 0 : before_last;
    // Chip 13097 of a step, counted from 0.
    reg [13:0] chip;
    always @(posedge i_clk) begin
        if (i_rst) chip <= 14'h3fff;
        else if (ends_step) chip <= 14'h3fff;
        else if (running) chip <= {^(chip & 14'h2a01), chip[13:1]};
        before_last <= i_rst ? 0 : running & chip == 14'h2ce2;
    end
    // Step 63 of a scan, counted from 0, is the last but one.
    reg [6:0] step;
    reg last_step;
    assign ends_scan = ends_step & last_step;
    always @(posedge i_clk) begin
        if (i_rst | ends_scan) step <= 7'h7f;
        else if (ends_step) step <= {^(step & 7'h3), step[6:1]};
        if (i_rst) last_step <= 0;
        else if (ends_step) last_step <= step == 7'h70;
    end
    reg [6:1] ended;
    reg [6:1] scan_ended;
    always @(posedge i_clk) begin
        ended <= i_rst ? 0 : {ended, ends_step};
        scan_ended <= i_rst ? 0 : {scan_ended, ends_scan};
    end

    // What holds at every clock.
    wire [11:0] holds;
    assign holds[0] = start_seen == start;
    assign holds[1] = run == running;
    assign holds[2] = chip_seen == chip;
    assign holds[3] = chip != 0;
    assign holds[4] = step_seen == step;
    assign holds[5] = step != 0;
    assign holds[6] = last_step_seen == last_step;
    assign holds[7] = step_ends == before_last;
    assign holds[8] = step_end == ends_step;
    assign holds[9] = dump == ended[5:5];
    assign holds[10] = counted == ended[6];
    assign holds[11] = last == scan_ended[6];
    // Registers are anything at first, but such that all of it holds for 10 clocks.
    reg [3:0] clocks = 0;
    reg held;
    always @(posedge i_clk) begin
        clocks <= clocks + (clocks != 10);
        held <= (held | clocks == 0) & (&holds);
    end
    always @* if (clocks == 10 & held) assert (&holds);
`ifdef COVER
    always @* assume (~((clocks == 10 & held) & (ends_scan)));
`endif
endmodule

// Each sample's reference is the chip of the detector's code that the delay of its phase step
// gives it: in step k sample l of chip n has chip floor((n S + l - k) / S). The delay is a
// number here; the reference's generator stands still, and chips come again, as it grows.
module prove_reference (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    wire ends;
    wire start;
    wire [7:0] window_0;
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

    // Samples of the delay beside whole chips, and the whole chips by which it grows.
    reg [2:0] samples;
    wire wraps = samples >= 7;
    wire [7:0] growth = 0 + wraps;
    always @(posedge i_clk)
        if (i_rst | start) samples <= 5;
        else if (ends) samples <= samples + 3'd1;

    // Detector 0: its code's chips, the present one in bit 0.
    reg [1:0] chips_0;
    wire next_0;
    wire waits_0;
    code_of_detector_0 spec_code_of_detector_0 (.i_clk(i_clk), .i_rst(i_rst), .advance(~waits_0), .load(start), .chip(next_0), .epoch());
    assign waits_0 = ends & growth != 0;
    wire again_0 = next_0;
    always @(posedge i_clk)
        if (i_rst | start) chips_0 <= 2'b00;
        else if (ends & growth != 0) chips_0 <= chips_0 >> (growth - 1);
        else chips_0 <= {chips_0, again_0};
    reg [7:0] expected_0;
    always @(posedge i_clk) begin
        expected_0[0] <= i_rst ? 0 : (samples > 0 ? chips_0[1] : chips_0[0]);
        expected_0[1] <= i_rst ? 0 : (samples > 1 ? chips_0[1] : chips_0[0]);
        expected_0[2] <= i_rst ? 0 : (samples > 2 ? chips_0[1] : chips_0[0]);
        expected_0[3] <= i_rst ? 0 : (samples > 3 ? chips_0[1] : chips_0[0]);
        expected_0[4] <= i_rst ? 0 : (samples > 4 ? chips_0[1] : chips_0[0]);
        expected_0[5] <= i_rst ? 0 : (samples > 5 ? chips_0[1] : chips_0[0]);
        expected_0[6] <= i_rst ? 0 : (samples > 6 ? chips_0[1] : chips_0[0]);
        expected_0[7] <= i_rst ? 0 : chips_0[0];
    end
    always @* assert (window_0 == expected_0);
`ifdef COVER
    always @* assume (~((ends & ~i_rst)));
`endif
endmodule

// One hit per rising edge of a detector's level, whatever the border between words, and only
// within a scan. A count is the sum since the last dump of hits that the reference counts up less
// those that it counts down: all that came before a dump, and nothing twice or lost at it. A count
// that does not fit is saturated and flagged, never wrapped. (Dumps, the scan's clocks and the
// reference are arbitrary here.)
module prove_counts (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready,
    input wire run,
    input wire may_dump,
    input wire [7:0] window_0
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
    wire m_axis_tvalid;
    wire m_axis_tlast;
    wire o_overrun;
    wire [16:0] count_0_0;
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

    reg [2:1] dumped;
    wire dump = may_dump & ~i_rst;
    always @(posedge i_clk)
        dumped <= i_rst ? 0 : {dumped, dump};
    wire dumps = dump;

    // Detector 0: samples that are high after a low one.
    wire [7:0] level_0 = i_samples;
    reg before_0;
    reg [7:0] hits_0;
    always @(posedge i_clk) begin
        before_0 <= i_rst ? 0 : level_0[7];
        hits_0 <= i_rst ? 0 : level_0 & ~{level_0, before_0} & {8{run}};
    end
    wire signed [5:0] word_0_0 = (hits_0[0] ? (window_0[0] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[1] ? (window_0[1] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[2] ? (window_0[2] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[3] ? (window_0[3] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[4] ? (window_0[4] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[5] ? (window_0[5] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[6] ? (window_0[6] ? 6'sd1 : -6'sd1) : 6'sd0) + (hits_0[7] ? (window_0[7] ? 6'sd1 : -6'sd1) : 6'sd0);
    reg signed [16:0] sum_0_0;
    reg signed [16:0] total_0_0;
    reg signed [16:0] base_0_0;
    reg signed [16:0] exact_0_0;
    wire [16:0] growth_0_0 = total_0_0 - base_0_0;
    always @* assert (growth_0_0 == sum_0_0);
    reg signed [5:0] word_0_0_1;
    reg signed [5:0] word_0_0_2;
    reg signed [5:0] word_0_0_3;
    always @(posedge i_clk) begin
        word_0_0_1 <= i_rst ? 0 : word_0_0;
        word_0_0_2 <= i_rst ? 0 : word_0_0_1;
        word_0_0_3 <= i_rst ? 0 : word_0_0_2;
        sum_0_0 <= i_rst ? 0 : dump ? word_0_0_3 : sum_0_0 + word_0_0_3;
        total_0_0 <= i_rst ? 0 : total_0_0 + word_0_0_3;
        base_0_0 <= i_rst ? 0 : dump ? total_0_0 : base_0_0;
        exact_0_0 <= i_rst ? 0 : dump ? sum_0_0 : exact_0_0;
    end
    always @* assert (count_0_0 == exact_0_0);
`ifdef COVER
    always @* assume (~((dumped[1])));
`endif
endmodule

// The stream carries each group's counts, one per beat, detector 0's steps, then detector 1's, ...,
// each once and in order, with tlast at the scan's last and nowhere else. A group that comes while
// others wait is dropped whole and sets o_overrun, a group with a saturated count, dropped or not,
// o_saturated; both stay until reset. (Counts, and when they come, are arbitrary here.)
module prove_stream (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready,
    input wire [16:0] count_0_0,
    input wire may_come,
    input wire may_end
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
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

    reg counted;
    reg last;
    wire counts = may_come & ~counted;
    always @(posedge i_clk) begin
        counted <= i_rst ? 0 : counts;
        last <= i_rst ? 0 : counts & may_end;
    end
    // Beats of the present group that are still to be taken.
    reg left;
    reg ends_scan;
    wire taken = left != 0 & m_axis_tready;
    wire free = left == 0 | (left == 1 & taken);
    wire accepted = counted & free;
    always @(posedge i_clk) begin
        if (i_rst) left <= 0;
        else if (accepted) left <= 1'h1;
        else left <= left - taken;
        if (i_rst) ends_scan <= 0;
        else if (accepted) ends_scan <= last;
    end
    always @* assert (m_axis_tvalid == (left != 0));
    always @* if (m_axis_tvalid) assert (m_axis_tlast == (ends_scan & left == 1));
    // The group's results, the one on offer first.
    reg [23:0] beat_0;
    always @(posedge i_clk) begin
        beat_0 <= i_rst ? 0 : accepted ? ({{7{count_0_0[16]}}, count_0_0}) : taken ? 0 : beat_0;
    end
    always @* if (m_axis_tvalid) assert (m_axis_tdata == beat_0);
    reg lost;
    always @(posedge i_clk)
        lost <= i_rst ? 0 : (lost | (counted & ~free));
    always @* assert (o_overrun == lost);
`ifdef COVER
    always @* assume (~((m_axis_tvalid & counted & ~free)));
`endif
endmodule

// In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken
// or reset. Flags stay until reset, the peak's ports until o_peak_valid.
module prove_axis (
    input wire i_clk,
    input wire i_rst,
    input wire [7:0] i_samples,
    input wire m_axis_tready
);
    wire o_laser;
    wire o_epoch;
    wire [23:0] m_axis_tdata;
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
    reg [23:0] held_data;
    always @(posedge i_clk) held_data <= m_axis_tdata;
    always @* if (stays & waited) assert (m_axis_tdata == held_data);
`ifdef COVER
    always @* assume (~((stays & waited & overran)));
`endif
endmodule

`default_nettype wire

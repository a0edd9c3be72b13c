// Modules of sensor_top of which a proof drives the outputs, or leaves them free: their ports and no more
// Made by  goldtof emit multipath.toml (goldtof 0.1.0)

`default_nettype none

`ifdef PROVE_REFERENCE
module scan_controller (
    input  wire i_clk, i_rst,

    output wire o_run,           // the present chip belongs to a scan
    output wire o_pre_last_chip, // it is the last but one of a phase step
    output wire o_last_chip,     // it is the last of a phase step
    output wire o_dump,          // the total has just taken in a step's last hits
    output wire o_counted,       // the step's count is there
    output wire o_scan_counted   // the count of the scan's last step is there
);
    wire nothing = 1'b0;
endmodule
`endif

`ifdef PROVE_COUNTS
module scan_controller (
    input  wire i_clk, i_rst,

    output wire o_run,           // the present chip belongs to a scan
    output wire o_pre_last_chip, // it is the last but one of a phase step
    output wire o_last_chip,     // it is the last of a phase step
    output wire o_dump,          // the total has just taken in a step's last hits
    output wire o_counted,       // the step's count is there
    output wire o_scan_counted   // the count of the scan's last step is there
);
    wire nothing = 1'b0;
endmodule
module phase_stepper (
    input  wire       i_clk, i_rst,

    input  wire       i_chip,          // next chip of the reference
    input  wire       i_pre_last_chip, // the present chip is the last but one of a phase step
    input  wire       i_last_chip,     // last chip of a phase step

    output wire       o_advance,       // the reference generator goes on to its next chip
    output wire [7:0] o_window         // reference of each sample, bit 0 earliest
);
    wire nothing = 1'b0;
endmodule
`endif

`ifdef PROVE_STREAM
module scan_controller (
    input  wire i_clk, i_rst,

    output wire o_run,           // the present chip belongs to a scan
    output wire o_pre_last_chip, // it is the last but one of a phase step
    output wire o_last_chip,     // it is the last of a phase step
    output wire o_dump,          // the total has just taken in a step's last hits
    output wire o_counted,       // the step's count is there
    output wire o_scan_counted   // the count of the scan's last step is there
);
    wire nothing = 1'b0;
endmodule
module detector_channel (
    input  wire        i_clk, i_rst,

    input  wire [7:0]  i_samples,       // level of the SPAD, bit 0 earliest
    input  wire        i_run,           // the present chip belongs to a scan
    input  wire        i_pre_last_chip, // the present chip is the last but one of a phase step
    input  wire        i_last_chip,     // last chip of a phase step
    input  wire        i_dump,          // the total has just taken in a step's last hits

    output wire [16:0] o_count          // count of a phase step, signed
);
    wire nothing = 1'b0;
endmodule
`endif

`default_nettype wire

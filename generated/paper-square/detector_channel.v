// detector_channel: one detector's hits, correlated with its reference
//
// The reference runs as the code of the detector's source and is delayed by the phase step; a
// hit counts up or down as the reference says (eq. 11).
//
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module detector_channel (
    input  wire        i_clk, i_rst,

    input  wire [7:0]  i_samples,       // level of the SPAD, bit 0 earliest
    input  wire        i_run,           // the present chip belongs to a scan
    input  wire        i_pre_last_chip, // the present chip is the last but one of a phase step
    input  wire        i_last_chip,     // last chip of a phase step
    input  wire        i_dump,          // the total has just taken in a step's last hits

    output wire [16:0] o_count          // count of a phase step, signed
);

    wire       reference_chip, reference_epoch_unused, stepper_advance;
    wire [7:0] stepper_window;
    wire [3:0] edges_hits, edges_early;

    square_generator reference (
        .i_clk (i_clk), .i_rst (i_rst), .i_advance (stepper_advance),
        .o_chip  (reference_chip),
        .o_epoch (reference_epoch_unused)
    );

    phase_stepper stepper (
        .i_clk (i_clk), .i_rst (i_rst), .i_chip (reference_chip),
        .i_pre_last_chip (i_pre_last_chip), .i_last_chip (i_last_chip),
        .o_advance (stepper_advance), .o_window (stepper_window)
    );

    edge_detector edges (
        .i_clk (i_clk), .i_rst (i_rst), .i_samples (i_samples), .i_run (i_run),
        .o_hits (edges_hits), .o_early (edges_early)
    );

    updown_correlator correlator (
        .i_clk (i_clk), .i_rst (i_rst), .i_hits (edges_hits), .i_early (edges_early),
        .i_reference (stepper_window),
        .i_dump      (i_dump),
        .o_count     (o_count)
    );

endmodule

`default_nettype wire

// sensor_top: DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in
//
// One clock cycle is one chip of 8 samples. The sample word of a chip is expected on i_samples
// one cycle after o_laser shows the chip. In reset all 6 outputs are 0.
//
// Scan     248 phase steps from step 0, 2500 chips each
// Counts   15 bits, signed; no stimulus can overflow them
// Latency  m_axis_tvalid 6 clocks after the one at which a step's last word is on i_samples
// Rate     one chip per clock
// Made by  goldtof emit quick.toml (goldtof 0.1.0)

`default_nettype none

module sensor_top (
    // Clock and reset
    input  wire        i_clk,         // one cycle per chip
    input  wire        i_rst,         // synchronous, active high

    // Lasers
    output reg         o_laser,       // chip of each source, bit m for source m
    output reg         o_epoch,       // o_laser shows the first chip of the reference's code

    // Detector
    input  wire [7:0]  i_samples,     // SPAD level, bit 0 earliest

    // Results, AXI4-Stream
    output wire [15:0] m_axis_tdata,  // count of a phase step, signed
    output wire        m_axis_tvalid, // a result waits
    input  wire        m_axis_tready, // the receiver takes it
    output wire        m_axis_tlast,  // it is the scan's last

    // Flags, high until reset
    output wire        o_overrun      // a result was lost since reset
);

    wire        chips;                  // next chip of each source
    wire        transmit_chip;          // present chip
    wire        transmit_epoch;         // the present chip is the one that reset gives
    wire        reference_chip;         // present chip
    wire        reference_epoch_unused; // the present chip is the one that reset gives
    wire        controller_run;         // the present clock belongs to a scan
    wire        controller_step_ends;   // the next clock is the last of a phase step
    wire        controller_step_end;    // last clock of a phase step
    wire        controller_dump;        // the total has just taken in a step's last hits, segment by segment
    wire        controller_counted;     // the step's count is there
    wire        controller_last;        // it is the scan's last
    wire        stepper_advance;        // the reference generator goes on to its next chip
    wire [7:0]  stepper_reference;      // reference of each sample, bit 0 earliest
    wire [3:0]  edges_hits;             // pairs of samples with a high one after a low one
    wire [3:0]  edges_early;            // the hit is the earlier sample of its pair
    wire [14:0] correlator_count;       // count of the last step, signed

    assign chips = transmit_chip;

    gold_generator transmit (
        .i_clk     (i_clk),
        .i_rst     (i_rst),
        .i_advance (1'b1),
        .o_chip    (transmit_chip),
        .o_epoch   (transmit_epoch)
    );

    gold_generator reference (
        .i_clk     (i_clk),
        .i_rst     (i_rst),
        .i_advance (stepper_advance),
        .o_chip    (reference_chip),
        .o_epoch   (reference_epoch_unused)
    );

    scan_controller controller (
        .i_clk       (i_clk),
        .i_rst       (i_rst),
        .o_run       (controller_run),
        .o_step_ends (controller_step_ends),
        .o_step_end  (controller_step_end),
        .o_dump      (controller_dump),
        .o_counted   (controller_counted),
        .o_last      (controller_last)
    );

    phase_stepper stepper (
        .i_clk       (i_clk),
        .i_rst       (i_rst),
        .i_chip      (reference_chip),
        .i_step_ends (controller_step_ends),
        .i_step_end  (controller_step_end),
        .o_advance   (stepper_advance),
        .o_reference (stepper_reference)
    );

    edge_detector edges (
        .i_clk     (i_clk),
        .i_rst     (i_rst),
        .i_samples (i_samples),
        .i_run     (controller_run),
        .o_hits    (edges_hits),
        .o_early   (edges_early)
    );

    updown_correlator correlator (
        .i_clk       (i_clk),
        .i_rst       (i_rst),
        .i_hits      (edges_hits),
        .i_early     (edges_early),
        .i_reference (stepper_reference),
        .i_dump      (controller_dump),
        .o_count     (correlator_count)
    );

    result_stream results (
        .i_clk     (i_clk),
        .i_rst     (i_rst),
        .i_count   (correlator_count),
        .i_counted (controller_counted),
        .i_last    (controller_last),
        .i_ready   (m_axis_tready),
        .o_data    (m_axis_tdata),
        .o_valid   (m_axis_tvalid),
        .o_last    (m_axis_tlast),
        .o_overrun (o_overrun)
    );

    always @(posedge i_clk) begin
        if (i_rst) begin
            o_laser <= 1'b0;
            o_epoch <= 1'b0;
        end else begin
            o_laser <= chips;
            o_epoch <= transmit_epoch;
        end
    end

endmodule

`default_nettype wire

// sensor_top: DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in
//
// One clock cycle is one chip of 8 samples. The sample word of a chip is expected on i_samples
// one cycle after o_laser shows the chip. In reset all 6 outputs are 0.
//
// Registers have no values at power-up: before the first scan i_rst has to be high at one
// rising edge of i_clk at least. Without that the outputs mean nothing.
//
// Scan     72 phase steps from step 0, 254000 chips each
// Counts   21 bits, signed; no stimulus can overflow them
// Latency  m_axis_tvalid 6 clocks after the one at which a step's last word is on i_samples
// Rate     one chip per clock
// Totals   20 bits, unsigned, in m_axis_tdata[47:24]
// Made by  goldtof emit image-glass.toml (goldtof 0.1.0)

`default_nettype none

module sensor_top (
    input  wire        i_clk,         // one cycle per chip
    input  wire        i_rst,         // synchronous, active high; pulse it after power-up

    // Lasers
    output reg         o_laser,       // chip of each source, bit m for source m
    output reg         o_epoch,       // o_laser shows the first chip of the reference's code

    // Detector
    input  wire [7:0]  i_samples,     // SPAD level, bit 0 earliest

    // Results, AXI4-Stream
    output wire [47:0] m_axis_tdata,  // from bit 24 its hits, below its signed count
    output wire        m_axis_tvalid, // a result waits
    input  wire        m_axis_tready, // the receiver takes it
    output wire        m_axis_tlast,  // it is the scan's last

    // Flags, high until reset
    output wire        o_overrun      // a result was lost since reset
);

    wire        transmit_chip, transmit_epoch, controller_run, controller_pre_last_chip;
    wire        controller_last_chip, controller_start, controller_dump, controller_counted;
    wire        controller_scan_counted;
    wire [20:0] channel_count;
    wire [19:0] channel_total;

    gold_generator #(
        .U_LOAD(7'h7f),
        .U_LAST(7'h7e),
        .V_LOAD(7'h7f)
    ) transmit (
        .i_clk (i_clk), .i_rst (i_rst),
        .i_advance (1'b1),
        .i_load    (1'b0),
        .o_chip (transmit_chip), .o_epoch (transmit_epoch)
    );

    scan_controller controller (
        .i_clk (i_clk), .i_rst (i_rst), .i_epoch (transmit_epoch),
        .o_run (controller_run), .o_pre_last_chip (controller_pre_last_chip),
        .o_last_chip (controller_last_chip), .o_start (controller_start),
        .o_dump (controller_dump), .o_counted (controller_counted),
        .o_scan_counted (controller_scan_counted)
    );

    detector_channel channel (
        .i_clk (i_clk), .i_rst (i_rst), .i_samples (i_samples), .i_run (controller_run),
        .i_pre_last_chip (controller_pre_last_chip), .i_last_chip (controller_last_chip),
        .i_start (controller_start), .i_dump (controller_dump),
        .o_count (channel_count), .o_total (channel_total)
    );

    result_stream results (
        .i_clk (i_clk), .i_rst (i_rst), .i_count (channel_count), .i_total (channel_total),
        .i_counted (controller_counted),
        .i_last    (controller_scan_counted),
        .i_ready   (m_axis_tready),
        .o_data    (m_axis_tdata),
        .o_valid   (m_axis_tvalid),
        .o_last    (m_axis_tlast),
        .o_overrun (o_overrun)
    );

    always @(posedge i_clk)
        if (i_rst) begin
            {o_laser, o_epoch} <= 0;
        end else begin
            o_laser <= transmit_chip;
            o_epoch <= transmit_epoch;
        end

endmodule

`default_nettype wire

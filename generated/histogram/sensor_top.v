// sensor_top: DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in, histograms out
//
// One clock cycle is one chip of 8 samples. The sample word of a chip is expected on i_samples
// one cycle after o_laser shows the chip. In reset all outputs are 0.
//
// Every rising edge of a detector's level counts in the bin of its sample of the code period: a
// row for each chip, from the one that o_epoch marks, a bin for each sample. The up/down count
// of phase step k is the sum of all bins, those negative whose chip of the reference, delayed
// by k samples, is 0.
//
// Registers have no values at power-up: before the first frame i_rst has to be high at one
// rising edge of i_clk at least. Without that the outputs mean nothing.
//
// Frame    7 code periods, 2047 rows of 8 bins
// Bins     3 bits, unsigned; no stimulus can overflow them
// Memory   98256 bits: one histogram counts while the other is read
// Latency  m_axis_tvalid 5 clocks after the one at which a frame's last word is on i_samples
// Rate     one chip per clock, and at most one row
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

module sensor_top (
    input  wire        i_clk,         // one cycle per chip
    input  wire        i_rst,         // synchronous, active high; pulse it after power-up

    // Lasers
    output reg         o_laser,       // chip of each source, bit m for source m
    output reg         o_epoch,       // o_laser shows the first chip of the reference's code

    // Detector
    input  wire [7:0]  i_samples,     // SPAD level, bit 0 earliest

    // Rows of the histograms, AXI4-Stream
    output reg  [63:0] m_axis_tdata,  // bins of a row, 8 bits each, bit 0 earliest
    output wire        m_axis_tvalid, // a row waits
    input  wire        m_axis_tready, // the receiver takes it
    output wire        m_axis_tlast,  // it is the frame's last

    // Flags, high until reset
    output wire        o_overrun      // a frame was lost since reset
);

    wire        transmit_chip, transmit_epoch, control_run, control_half, control_come_half;
    wire        control_held_first, control_held_half, control_added_first;
    wire        control_write_half, control_go, control_shows;
    wire [10:0] control_row, control_write_row, control_read_row;
    wire [63:0] channel_bins;

    gold_generator transmit (
        .i_clk (i_clk), .i_rst (i_rst),
        .i_advance (1'b1),
        .o_chip (transmit_chip), .o_epoch (transmit_epoch)
    );

    histogram_control control (
        .i_clk (i_clk), .i_rst (i_rst),
        .i_ready   (m_axis_tready),
        .o_run (control_run), .o_row (control_row), .o_half (control_half),
        .o_come_half (control_come_half), .o_held_first (control_held_first),
        .o_held_half (control_held_half), .o_added_first (control_added_first),
        .o_write_row (control_write_row), .o_write_half (control_write_half),
        .o_read_row (control_read_row), .o_go (control_go), .o_shows (control_shows),
        .o_valid   (m_axis_tvalid),
        .o_last    (m_axis_tlast),
        .o_overrun (o_overrun)
    );

    histogram_channel channel (
        .i_clk (i_clk), .i_rst (i_rst), .i_samples (i_samples), .i_run (control_run),
        .i_row (control_row), .i_half (control_half), .i_read_row (control_read_row),
        .i_go (control_go), .i_come_half (control_come_half),
        .i_held_first (control_held_first), .i_held_half (control_held_half),
        .i_added_first (control_added_first), .i_write_row (control_write_row),
        .i_write_half (control_write_half),
        .o_bins (channel_bins)
    );

    always @(posedge i_clk)
        if (i_rst) begin
            {o_laser, o_epoch, m_axis_tdata} <= 0;
        end else begin
            o_laser <= transmit_chip;
            o_epoch <= transmit_epoch;
            if (control_shows) m_axis_tdata <= channel_bins;
        end

endmodule

`default_nettype wire

// ice40_board: example of a top for one laser, one detector and S = 2 on Lattice iCE40
//
// The board gives the chip clock, for a chip of 8 ns 125 MHz.

`include "sensor_top.vh" // of the emitted folder: the widths of sensor_top's ports

`default_nettype none

module ice40_board (
    input  wire                                          i_clk,
    input  wire                                          i_rst,        // asynchronous, active high; may stay low for ever
    input  wire                                          i_spad,
    output wire                                          o_laser,

    // Results, on o_clk: to the user's logic
    output wire                                          o_clk,
    output wire [`SENSOR_TOP_M_AXIS_TDATA_BITS-1:0]      m_axis_tdata,
    output wire                                          m_axis_tvalid,
    input  wire                                          m_axis_tready,
    output wire                                          m_axis_tlast,
    output wire                                          o_epoch,
    output wire                                          o_overrun
);

    wire       clk;
    wire       chip;
    wire [1:0] samples;
    reg  [1:0] reset_r = 2'b11; // high at power-up: the core needs a reset before its first scan

    assign clk   = i_clk;
    assign o_clk = clk;

    // What else was emitted does not fit these pins: stop here, with a name that says so.
    generate
        if (`SENSOR_TOP_I_SAMPLES_BITS != 2 || `SENSOR_TOP_O_LASER_BITS != 1) begin : gen_fit
            ice40_board_needs_a_scene_of_2_samples_per_chip_one_laser_and_one_detector stop ();
        end
    endgenerate

    // Reset begins at once and ends with the clock.
    always @(posedge clk or posedge i_rst) begin
        if (i_rst) begin
            reset_r <= 2'b11;
        end else begin
            reset_r <= {reset_r[0], 1'b0};
        end
    end

    ice40_sampler sampler (
        .i_clk     (clk),
        .i_pin     (i_spad),
        .o_samples (samples)
    );

    ice40_laser laser (
        .i_clk  (clk),
        .i_chip (chip),
        .o_pin  (o_laser)
    );

    sensor_top sensor (
        .i_clk         (clk),
        .i_rst         (reset_r[1]),
        .o_laser       (chip),
        .o_epoch       (o_epoch),
        .i_samples     (samples),
        .m_axis_tdata  (m_axis_tdata),
        .m_axis_tvalid (m_axis_tvalid),
        .m_axis_tready (m_axis_tready),
        .m_axis_tlast  (m_axis_tlast),
        .o_overrun     (o_overrun)
    );

endmodule

`default_nettype wire

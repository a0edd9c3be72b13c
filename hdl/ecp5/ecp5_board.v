// ecp5_board: example of a top for one laser, one detector and S = 4 on Lattice ECP5
//
// The board gives an edge clock of twice the chip rate, for a chip of 8 ns 250 MHz.

`include "sensor_top.vh" // of the emitted folder: the widths of sensor_top's ports

`default_nettype none

module ecp5_board (
    input  wire                                          i_edge_clk,
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

    wire       edge_clk;
    wire       clk;
    wire       chip;
    wire [3:0] samples;
    reg  [1:0] reset_r = 2'b11; // high at power-up: the core needs a reset before its first scan

    assign o_clk = clk;

    ECLKSYNCB edge_clock (
        .ECLKI (i_edge_clk),
        .STOP  (1'b0),
        .ECLKO (edge_clk)
    );

    CLKDIVF #(
        .DIV ("2.0")
    ) chip_clock (
        .CLKI    (edge_clk),
        .RST     (1'b0),
        .ALIGNWD (1'b0),
        .CDIVX   (clk)
    );

    // What else was emitted does not fit these pins: stop here, with a name that says so.
    generate
        if (`SENSOR_TOP_I_SAMPLES_BITS != 4 || `SENSOR_TOP_O_LASER_BITS != 1) begin : gen_fit
            ecp5_board_needs_a_scene_of_4_samples_per_chip_one_laser_and_one_detector stop ();
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

    ecp5_sampler sampler (
        .i_edge_clk (edge_clk),
        .i_clk      (clk),
        .i_rst      (reset_r[1]),
        .i_pin      (i_spad),
        .o_samples  (samples)
    );

    ecp5_laser laser (
        .i_clk  (clk),
        .i_rst  (reset_r[1]),
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

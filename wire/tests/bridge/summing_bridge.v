// summing_bridge: result_accumulator before uart_bridge, as board_top has them
//
// Parameters as of uart_bridge, of the results of one scan, and those of the sums.

`default_nettype none

module summing_bridge #(
    parameter         TDATA_BITS     = 24,
    parameter         COUNT_BITS     = 18,
    parameter         MORE_FIRST_BIT = 0,
    parameter         MORE_BITS      = 0,
    parameter         SCANS          = 2,
    parameter         SCANS_BITS     = 1,
    parameter         RESULTS        = 16,
    parameter         RESULTS_BITS   = 4,
    parameter         CLOCKS_PER_BIT = 16,
    parameter         ADDRESS_BITS   = 10,
    parameter         FRAME_RESULTS  = 255,
    parameter [255:0] IDENTITY       = 256'd0
) (
    input  wire                  i_clk,
    input  wire                  i_rst,
    input  wire                  i_uart_clk,
    input  wire                  i_rx,
    output wire                  o_tx,
    input  wire [TDATA_BITS-1:0] s_axis_tdata,
    input  wire                  s_axis_tvalid,
    output wire                  s_axis_tready,
    input  wire                  s_axis_tlast,
    input  wire                  i_overrun,
    input  wire                  i_saturated
);

    localparam SUM_COUNT_BITS = COUNT_BITS + SCANS_BITS;
    localparam SUM_MORE_BITS  = MORE_BITS > 0 ? MORE_BITS + SCANS_BITS : 0;
    localparam SUM_BITS       = SUM_COUNT_BITS + SUM_MORE_BITS;

    wire [SUM_BITS-1:0] tdata;
    wire                tvalid;
    wire                tready;
    wire                tlast;
    wire                hold_unused;
    wire [9:0]          place_unused;

    result_accumulator #(
        .TDATA_BITS     (TDATA_BITS),
        .COUNT_BITS     (COUNT_BITS),
        .MORE_FIRST_BIT (MORE_FIRST_BIT),
        .MORE_BITS      (MORE_BITS),
        .SCANS          (SCANS),
        .SCANS_BITS     (SCANS_BITS),
        .RESULTS        (RESULTS),
        .RESULTS_BITS   (RESULTS_BITS),
        .SUM_BITS       (SUM_BITS)
    ) sums (
        .i_clk         (i_clk),
        .i_rst         (i_rst),
        .s_axis_tdata  (s_axis_tdata),
        .s_axis_tvalid (s_axis_tvalid),
        .s_axis_tready (s_axis_tready),
        .s_axis_tlast  (s_axis_tlast),
        .m_axis_tdata  (tdata),
        .m_axis_tvalid (tvalid),
        .m_axis_tready (tready),
        .m_axis_tlast  (tlast)
    );

    uart_bridge #(
        .TDATA_BITS     (SUM_BITS),
        .COUNT_BITS     (SUM_COUNT_BITS),
        .COUNTS         (1),
        .COUNT_STRIDE   (SUM_BITS),
        .MORE_FIRST_BIT (SUM_COUNT_BITS),
        .MORE_BITS      (SUM_MORE_BITS),
        .BACK_PRESSURE  (0),
        .CLOCKS_PER_BIT (CLOCKS_PER_BIT),
        .ADDRESS_BITS   (ADDRESS_BITS),
        .FRAME_RESULTS  (FRAME_RESULTS),
        .IDENTITY       (IDENTITY)
    ) bridge (
        .i_clk         (i_clk),
        .i_rst         (i_rst),
        .i_uart_clk    (i_uart_clk),
        .i_rx          (i_rx),
        .o_tx          (o_tx),
        .s_axis_tdata  (tdata),
        .s_axis_tvalid (tvalid),
        .s_axis_tready (tready),
        .s_axis_tlast  (tlast),
        .i_overrun     (i_overrun),
        .i_saturated   (i_saturated),
        .o_hold        (hold_unused),
        .o_place       (place_unused),
        .i_held        (1'b0),
        .i_word        (32'd0)
    );

endmodule

`default_nettype wire

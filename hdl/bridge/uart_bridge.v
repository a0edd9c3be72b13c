// uart_bridge: results of sensor_top to a serial line; answers with its identity when it is asked
//
// Ports and parameters are described in README.md, the bytes on the line in docs/wire.md.

`default_nettype none

module uart_bridge #(
    parameter         TDATA_BITS     = 24,
    parameter         COUNT_BITS     = 18,
    parameter         COUNTS         = 1,
    parameter         COUNT_STRIDE   = 24,
    parameter         MORE_FIRST_BIT = 0,
    parameter         MORE_BITS      = 0,
    parameter         BACK_PRESSURE  = 0,
    parameter         CLOCKS_PER_BIT = 16,
    parameter         ADDRESS_BITS   = 10,
    parameter         SAMPLE_COUNTS  = 0,
    parameter [255:0] IDENTITY       = 256'd0,
    parameter         TEXT_BLOCKS    = 0,
    // One block at least, as a vector has a bit.
    parameter [256*(TEXT_BLOCKS > 0 ? TEXT_BLOCKS : 1)-1:0] TEXT = 256'd0
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
    input  wire                  i_saturated,

    // sample_counter; without it 0
    output wire                  o_hold,
    output wire [9:0]            o_place,
    input  wire                  i_held,
    input  wire [31:0]           i_word
);

    wire        request;
    wire        rst_unused;
    wire        uart_rst_unused;
    wire        transfer_unused;
    wire        write_unused;
    wire [11:0] address_unused;
    wire [31:0] data_unused;
    wire        answered_unused;

    bridge_core #(
        .TDATA_BITS     (TDATA_BITS),
        .COUNT_BITS     (COUNT_BITS),
        .COUNTS         (COUNTS),
        .COUNT_STRIDE   (COUNT_STRIDE),
        .MORE_FIRST_BIT (MORE_FIRST_BIT),
        .MORE_BITS      (MORE_BITS),
        .BACK_PRESSURE  (BACK_PRESSURE),
        .CLOCKS_PER_BIT (CLOCKS_PER_BIT),
        .ADDRESS_BITS   (ADDRESS_BITS),
        .SAMPLE_COUNTS  (SAMPLE_COUNTS),
        .IDENTITY       (IDENTITY),
        .TEXT_BLOCKS    (TEXT_BLOCKS),
        .TEXT           (TEXT)
    ) core (
        .i_clk         (i_clk),
        .i_rst         (i_rst),
        .o_rst         (rst_unused),
        .i_uart_clk    (i_uart_clk),
        .o_uart_rst    (uart_rst_unused),
        .i_rx          (i_rx),
        .o_tx          (o_tx),
        .s_axis_tdata  (s_axis_tdata),
        .s_axis_tvalid (s_axis_tvalid),
        .s_axis_tready (s_axis_tready),
        .s_axis_tlast  (s_axis_tlast),
        .i_overrun     (i_overrun),
        .i_saturated   (i_saturated),
        .o_hold        (o_hold),
        .o_place       (o_place),
        .i_held        (i_held),
        .i_word        (i_word),
        .o_request     (request),
        .o_transfer    (transfer_unused),
        .o_write       (write_unused),
        .o_address     (address_unused),
        .o_data        (data_unused),
        .i_answer      (request),
        .i_identify    (1'b1), // whatever it is that was asked
        .i_status      (2'd0),
        .i_data        (32'd0),
        .o_answered    (answered_unused)
    );

endmodule

`default_nettype wire

// uart_bridge_axil: results of sensor_top to a serial line; the host reads and writes registers by it
//
// Ports and parameters are described in README.md, the bytes on the line in docs/wire.md.

`default_nettype none

module uart_bridge_axil #(
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
    input  wire [31:0]           i_word,

    output wire [11:0]           m_axil_awaddr,
    output wire                  m_axil_awvalid,
    input  wire                  m_axil_awready,
    output wire [31:0]           m_axil_wdata,
    output wire [3:0]            m_axil_wstrb,
    output wire                  m_axil_wvalid,
    input  wire                  m_axil_wready,
    input  wire [1:0]            m_axil_bresp,
    input  wire                  m_axil_bvalid,
    output wire                  m_axil_bready,
    output wire [11:0]           m_axil_araddr,
    output wire                  m_axil_arvalid,
    input  wire                  m_axil_arready,
    input  wire [31:0]           m_axil_rdata,
    input  wire [1:0]            m_axil_rresp,
    input  wire                  m_axil_rvalid,
    output wire                  m_axil_rready
);

    wire        rst;
    wire        uart_rst;
    wire        request;
    wire        is_transfer;
    wire        writes;
    wire [11:0] address;
    wire [31:0] data_written;
    wire        done;
    wire        done_seen;
    wire [31:0] data_read;
    wire [1:0]  status;
    wire        answered;
    reg         asked_r;
    reg         toggle_r;

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
        .o_rst         (rst),
        .i_uart_clk    (i_uart_clk),
        .o_uart_rst    (uart_rst),
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
        .o_transfer    (is_transfer),
        .o_write       (writes),
        .o_address     (address),
        .o_data        (data_written),
        .i_answer      (request && (!is_transfer || (asked_r && done_seen == toggle_r))),
        .i_identify    (!is_transfer),
        .i_status      (status),
        .i_data        (data_read),
        .o_answered    (answered)
    );

    always @(posedge i_uart_clk) begin
        if (uart_rst) begin
            asked_r  <= 1'b0;
            toggle_r <= 1'b0;
        end else if (answered) begin
            asked_r <= 1'b0;
        end else if (request && is_transfer && !asked_r) begin
            asked_r  <= 1'b1;
            toggle_r <= !toggle_r;
        end
    end

    bridge_sync #(
        .BITS (1)
    ) done_sync (
        .i_clk   (i_uart_clk),
        .i_async (done),
        .o_sync  (done_seen)
    );

    axil_master master (
        .i_clk          (i_clk),
        .i_rst          (i_rst || rst), // nothing is offered to a slave that is out of reset already
        .i_toggle       (toggle_r),
        .i_write        (writes),
        .i_address      (address),
        .i_data         (data_written),
        .o_toggle       (done),
        .o_data         (data_read),
        .o_status       (status),
        .m_axil_awaddr  (m_axil_awaddr),
        .m_axil_awvalid (m_axil_awvalid),
        .m_axil_awready (m_axil_awready),
        .m_axil_wdata   (m_axil_wdata),
        .m_axil_wstrb   (m_axil_wstrb),
        .m_axil_wvalid  (m_axil_wvalid),
        .m_axil_wready  (m_axil_wready),
        .m_axil_bresp   (m_axil_bresp),
        .m_axil_bvalid  (m_axil_bvalid),
        .m_axil_bready  (m_axil_bready),
        .m_axil_araddr  (m_axil_araddr),
        .m_axil_arvalid (m_axil_arvalid),
        .m_axil_arready (m_axil_arready),
        .m_axil_rdata   (m_axil_rdata),
        .m_axil_rresp   (m_axil_rresp),
        .m_axil_rvalid  (m_axil_rvalid),
        .m_axil_rready  (m_axil_rready)
    );

endmodule

`default_nettype wire

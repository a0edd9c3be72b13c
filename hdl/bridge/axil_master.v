// axil_master: one AXI4-Lite transfer at a time, asked for by another clock domain
//
// i_toggle changes for each transfer, whose address, data and direction stand until o_toggle is like it;
// then o_data and o_status stand until the next one. Addresses, data and valid are registers; what is
// offered stands until it is taken.

`default_nettype none

module axil_master (
    input  wire        i_clk,
    input  wire        i_rst,

    // Other clock domain
    input  wire        i_toggle,
    input  wire        i_write,
    input  wire [11:0] i_address,
    input  wire [31:0] i_data,
    output wire        o_toggle,
    output wire [31:0] o_data,        // read
    output wire [1:0]  o_status,      // AXI's response: 0 OKAY, 2 SLVERR, 3 DECERR

    output wire [11:0] m_axil_awaddr,
    output wire        m_axil_awvalid,
    input  wire        m_axil_awready,
    output wire [31:0] m_axil_wdata,
    output wire [3:0]  m_axil_wstrb,
    output wire        m_axil_wvalid,
    input  wire        m_axil_wready,
    input  wire [1:0]  m_axil_bresp,
    input  wire        m_axil_bvalid,
    output wire        m_axil_bready,
    output wire [11:0] m_axil_araddr,
    output wire        m_axil_arvalid,
    input  wire        m_axil_arready,
    input  wire [31:0] m_axil_rdata,
    input  wire [1:0]  m_axil_rresp,
    input  wire        m_axil_rvalid,
    output wire        m_axil_rready
);

    wire        toggle_seen;
    reg         done_r;     // like toggle_seen: nothing is asked for
    reg         busy_r;
    reg         awvalid_r;
    reg         wvalid_r;
    reg         bready_r;
    reg         arvalid_r;
    reg         rready_r;
    reg  [11:0] address_r;
    reg  [31:0] wdata_r;
    reg  [31:0] rdata_r;
    reg  [1:0]  status_r;

    wire begins = toggle_seen != done_r && !busy_r;

    assign o_toggle       = done_r;
    assign o_data         = rdata_r;
    assign o_status       = status_r;
    assign m_axil_awaddr  = address_r;
    assign m_axil_awvalid = awvalid_r;
    assign m_axil_wdata   = wdata_r;
    assign m_axil_wstrb   = 4'b1111;
    assign m_axil_wvalid  = wvalid_r;
    assign m_axil_bready  = bready_r;
    assign m_axil_araddr  = address_r;
    assign m_axil_arvalid = arvalid_r;
    assign m_axil_rready  = rready_r;

    bridge_sync #(
        .BITS (1)
    ) toggle_sync (
        .i_clk   (i_clk),
        .i_async (i_toggle),
        .o_sync  (toggle_seen)
    );

    always @(posedge i_clk) begin
        if (m_axil_awready) begin
            awvalid_r <= 1'b0;
        end
        if (m_axil_wready) begin
            wvalid_r <= 1'b0;
        end
        if (m_axil_arready) begin
            arvalid_r <= 1'b0;
        end
        if (begins) begin
            busy_r    <= 1'b1;
            address_r <= i_address;
            wdata_r   <= i_data;
            awvalid_r <= i_write;
            wvalid_r  <= i_write;
            bready_r  <= i_write;
            arvalid_r <= !i_write;
            rready_r  <= !i_write;
        end
        if (bready_r && m_axil_bvalid) begin
            busy_r   <= 1'b0;
            done_r   <= !done_r;
            bready_r <= 1'b0;
            status_r <= m_axil_bresp;
        end
        if (rready_r && m_axil_rvalid) begin
            busy_r   <= 1'b0;
            done_r   <= !done_r;
            rready_r <= 1'b0;
            rdata_r  <= m_axil_rdata;
            status_r <= m_axil_rresp;
        end
        if (i_rst) begin
            done_r    <= 1'b0;
            busy_r    <= 1'b0;
            awvalid_r <= 1'b0;
            wvalid_r  <= 1'b0;
            bready_r  <= 1'b0;
            arvalid_r <= 1'b0;
            rready_r  <= 1'b0;
        end
    end

endmodule

`default_nettype wire

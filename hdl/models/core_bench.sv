// sensor_top for the bench: a core whose outputs bench.cpp chooses at every clock
//
// CORE_LASERS, CORE_SAMPLES (of all detectors) and CORE_TDATA_BITS are widths; CORE_HAS_SATURATED,
// CORE_HAS_PEAK and CORE_HAS_REGISTERS say which ports the scene's core has.

`default_nettype none

module sensor_top (
    input  wire                       i_clk,
    input  wire                       i_rst,
    output reg  [`CORE_LASERS-1:0]    o_laser,
    output wire                       o_epoch,
    input  wire [`CORE_SAMPLES-1:0]   i_samples,
    output reg  [`CORE_TDATA_BITS-1:0] m_axis_tdata,
    output reg                        m_axis_tvalid,
    input  wire                       m_axis_tready,
    output reg                        m_axis_tlast,
`ifdef CORE_HAS_SATURATED
    output reg                        o_saturated,
`endif
`ifdef CORE_HAS_PEAK
    output wire                       o_peak_step,
    output wire                       o_peak_count,
    output wire                       o_peak_valid,
`endif
`ifdef CORE_HAS_REGISTERS
    input  wire [11:0]                s_axil_awaddr,
    input  wire                       s_axil_awvalid,
    output reg                        s_axil_awready,
    input  wire [31:0]                s_axil_wdata,
    input  wire [3:0]                 s_axil_wstrb,
    input  wire                       s_axil_wvalid,
    output reg                        s_axil_wready,
    output reg  [1:0]                 s_axil_bresp,
    output reg                        s_axil_bvalid,
    input  wire                       s_axil_bready,
    input  wire [11:0]                s_axil_araddr,
    input  wire                       s_axil_arvalid,
    output reg                        s_axil_arready,
    output reg  [31:0]                s_axil_rdata,
    output reg  [1:0]                 s_axil_rresp,
    output reg                        s_axil_rvalid,
    input  wire                       s_axil_rready,
`endif
    output reg                        o_overrun
);

    // Inputs as they are before the edge; outputs behind it.
    import "DPI-C" function void core_edge(
        input bit reset, input bit [`CORE_SAMPLES-1:0] samples, input bit tready,
        output bit [31:0] lasers, output bit [`CORE_TDATA_BITS-1:0] tdata, output bit tvalid, output bit tlast,
        output bit overrun, output bit saturated);

    bit [31:0]                 lasers;
    bit [`CORE_TDATA_BITS-1:0] tdata;
    bit                        tvalid, tlast, overrun, saturated;

    assign o_epoch = 1'b0;

    always @(posedge i_clk) begin
        core_edge(i_rst, i_samples, m_axis_tready, lasers, tdata, tvalid, tlast, overrun, saturated);
        o_laser       <= lasers[`CORE_LASERS-1:0];
        m_axis_tdata  <= tdata;
        m_axis_tvalid <= tvalid;
        m_axis_tlast  <= tlast;
        o_overrun     <= overrun;
`ifdef CORE_HAS_SATURATED
        o_saturated   <= saturated;
`endif
    end

`ifdef CORE_HAS_PEAK
    assign {o_peak_step, o_peak_count, o_peak_valid} = 3'd0;
`endif

`ifdef CORE_HAS_REGISTERS
    import "DPI-C" function void slave_edge(
        input bit reset,
        input bit awvalid, input bit [31:0] awaddr, input bit wvalid, input bit [31:0] wdata, input bit [31:0] wstrb,
        input bit bready, input bit arvalid, input bit [31:0] araddr, input bit rready,
        output bit awready, output bit wready, output bit [31:0] bresp, output bit bvalid,
        output bit arready, output bit [31:0] rdata, output bit [31:0] rresp, output bit rvalid);

    bit [31:0] bresp, rdata, rresp;
    bit        awready, wready, bvalid, arready, rvalid;

    always @(posedge i_clk) begin
        slave_edge(i_rst, s_axil_awvalid, 32'(s_axil_awaddr), s_axil_wvalid, s_axil_wdata, 32'(s_axil_wstrb),
            s_axil_bready, s_axil_arvalid, 32'(s_axil_araddr), s_axil_rready,
            awready, wready, bresp, bvalid, arready, rdata, rresp, rvalid);
        s_axil_awready <= awready;
        s_axil_wready  <= wready;
        s_axil_bresp   <= bresp[1:0];
        s_axil_bvalid  <= bvalid;
        s_axil_arready <= arready;
        s_axil_rdata   <= rdata;
        s_axil_rresp   <= rresp[1:0];
        s_axil_rvalid  <= rvalid;
    end
`endif

endmodule

`default_nettype wire

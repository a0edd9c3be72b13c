// Keeps the ports of a sensor, clock by clock, for goldtof.cocotb.Scoreboard, which reads
// them a batch at a time: so nothing in Python happens at each clock.
//
// Clock 0 is the first rising edge of i_clk. A clock has the inputs that stand before its
// edge and the outputs after it, which are read at the edge of the next clock. Widths are
// those of the manifest; of a port that the sensor does not have, 1, and 0 at it. With GOLDTOF_REGISTERS
// defined it has the ports of a sensor's registers, too.

`default_nettype none

module goldtof_recorder #(
    parameter SAMPLES    = 8,     // of all detectors together
    parameter LASERS     = 1,
    parameter TDATA      = 16,
    parameter PEAK_STEP  = 1,
    parameter PEAK_COUNT = 1,
    parameter BATCH      = 256    // clocks
) (
    input wire                  i_clk,
    input wire                  i_rst,
    input wire [SAMPLES-1:0]    i_samples,
    input wire                  m_axis_tready,
    input wire [LASERS-1:0]     o_laser,
    input wire                  o_epoch,
    input wire [TDATA-1:0]      m_axis_tdata,
    input wire                  m_axis_tvalid,
    input wire                  m_axis_tlast,
    input wire                  o_overrun,
    input wire                  o_saturated,
    input wire [PEAK_STEP-1:0]  o_peak_step,
    input wire [PEAK_COUNT-1:0] o_peak_count,
    input wire                  o_peak_valid
`ifdef GOLDTOF_REGISTERS
    ,
    input wire [11:0]           s_axil_awaddr,
    input wire                  s_axil_awvalid,
    input wire                  s_axil_awready,
    input wire [31:0]           s_axil_wdata,
    input wire [3:0]            s_axil_wstrb,
    input wire                  s_axil_wvalid,
    input wire                  s_axil_wready,
    input wire [1:0]            s_axil_bresp,
    input wire                  s_axil_bvalid,
    input wire                  s_axil_bready,
    input wire [11:0]           s_axil_araddr,
    input wire                  s_axil_arvalid,
    input wire                  s_axil_arready,
    input wire [31:0]           s_axil_rdata,
    input wire [1:0]            s_axil_rresp,
    input wire                  s_axil_rvalid,
    input wire                  s_axil_rready
`endif
);
`ifdef GOLDTOF_REGISTERS
    localparam HOST  = 65; // bits that a host drives
    localparam BITS  = SAMPLES + LASERS + TDATA + PEAK_STEP + PEAK_COUNT + 8 + HOST + 41;
`else
    localparam BITS  = SAMPLES + LASERS + TDATA + PEAK_STEP + PEAK_COUNT + 8;
`endif
    localparam WORDS = (BITS + 63) / 64;

    reg               held_rst;
    reg [SAMPLES-1:0] held_samples;
    reg               held_tready;
`ifdef GOLDTOF_REGISTERS
    reg [HOST-1:0]    held_host;
`endif
    reg               is_first = 1;

    integer                  clocks /* verilator public_flat_rd */ = 0;  // in the batch so far
    reg [BATCH*WORDS*64-1:0] batch /* verilator public_flat_rd */;
    reg                      is_new /* verilator public_flat_rd */ = 0;  // changes when it is whole

    // What is read here is what stood before the edge. The batch is read when is_new
    // changes, before the next clock writes into it.
    always @(posedge i_clk) begin
        if (!is_first) begin
            batch[clocks*WORDS*64 +: WORDS*64] = {
                {(WORDS*64 - BITS){1'b0}},
`ifdef GOLDTOF_REGISTERS
                s_axil_rvalid, s_axil_rresp, s_axil_rdata, s_axil_arready, s_axil_bvalid, s_axil_bresp,
                s_axil_wready, s_axil_awready, held_host,
`endif
                o_peak_valid, o_peak_count, o_peak_step, o_saturated, o_overrun, m_axis_tlast,
                held_tready, m_axis_tvalid, m_axis_tdata, held_samples, o_epoch, o_laser,
                held_rst};
            clocks = clocks + 1;
        end
        if (clocks == BATCH) begin
            clocks = 0;
            is_new = !is_new;
        end
        is_first     <= 0;
        held_rst     <= i_rst;
        held_samples <= i_samples;
        held_tready  <= m_axis_tready;
`ifdef GOLDTOF_REGISTERS
        held_host    <= {s_axil_rready, s_axil_arvalid, s_axil_araddr, s_axil_bready, s_axil_wvalid,
                         s_axil_wstrb, s_axil_wdata, s_axil_awvalid, s_axil_awaddr};
`endif
    end
endmodule

`default_nettype wire

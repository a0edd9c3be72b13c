// What a host drives and sees, of a design with registers.
`ifdef SETTINGS_BITS
`define HOST_INPUTS , \
    input wire [11:0] s_axil_awaddr, \
    input wire s_axil_awvalid, \
    input wire [31:0] s_axil_wdata, \
    input wire [3:0] s_axil_wstrb, \
    input wire s_axil_wvalid, \
    input wire s_axil_bready, \
    input wire [11:0] s_axil_araddr, \
    input wire s_axil_arvalid, \
    input wire s_axil_rready
`define HOST_OUTPUTS \
    wire s_axil_awready; \
    wire s_axil_wready; \
    wire [1:0] s_axil_bresp; \
    wire s_axil_bvalid; \
    wire s_axil_arready; \
    wire [31:0] s_axil_rdata; \
    wire [1:0] s_axil_rresp; \
    wire s_axil_rvalid;
`else
`define HOST_INPUTS
`define HOST_OUTPUTS
`endif

// The design and its outputs, of which a proof has those that the design has. A proof has the
// inputs as its own.
`define DESIGN \
    wire [`SOURCES-1:0] o_laser; \
    wire o_epoch; \
    wire [`DATA_BITS-1:0] m_axis_tdata; \
    wire m_axis_tvalid; \
    wire m_axis_tlast; \
    wire o_overrun; \
    wire o_saturated; \
    wire [`DETECTORS*`PEAK_STEP_BITS-1:0] o_peak_step; \
    wire [`DETECTORS*`COUNT_BITS-1:0] o_peak_count; \
    wire o_peak_valid; \
    `HOST_OUTPUTS \
    `TOP dut (.*);

`define INPUTS_BUT_RESET \
    input wire i_clk, \
    input wire [`DETECTORS*`CELLS*`SAMPLES-1:0] i_samples, \
    input wire m_axis_tready \
    `HOST_INPUTS

`define INPUTS \
    input wire i_rst, \
    `INPUTS_BUT_RESET

// That what a proof is about can be: its task `..._cover` shows how.
`ifdef COVER
`define REACHES(condition) always @* assume (!(condition));
`else
`define REACHES(condition)
`endif

// Induction: registers are anything at first, but such that what is to hold does for so many
// clocks; then it does in the next one.
`define HOLDS_BEHIND(count, condition) \
    reg [$clog2(count + 1)-1:0] clocks = 0; \
    reg held; \
    always @(posedge i_clk) begin \
        clocks <= clocks + (clocks != count); \
        held <= (held | clocks == 0) & (condition); \
    end \
    always @* if (clocks == count & held) assert (condition);

// A clock of reset leaves every register at the value that the other proofs start from, whatever
// it held, and no X. The assertions are those of registers.v, one for each register.
module prove_reset (
    `INPUTS_BUT_RESET
);
    wire i_rst = 1'b1;
    `DESIGN
endmodule

// The top of the example for cocotb: a design, and the recorder beside it.

`timescale 1ns / 1ps

`ifndef DESIGN
`define DESIGN sensor_top
`endif

module testbench (
    input  wire        i_clk,
    input  wire        i_rst,
    input  wire [7:0]  i_samples,
    input  wire        m_axis_tready,
    output wire        o_laser,
    output wire        o_epoch,
    output wire [15:0] m_axis_tdata,
    output wire        m_axis_tvalid,
    output wire        m_axis_tlast,
    output wire        o_overrun
);
    `DESIGN sensor (
        .i_clk(i_clk), .i_rst(i_rst), .o_laser(o_laser), .o_epoch(o_epoch),
        .i_samples(i_samples), .m_axis_tdata(m_axis_tdata), .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready), .m_axis_tlast(m_axis_tlast), .o_overrun(o_overrun));

`ifndef WITHOUT_RECORDER          // to measure what it costs
    goldtof_recorder #(.SAMPLES(8), .TDATA(16)) recorder (
        .i_clk(i_clk), .i_rst(i_rst), .i_samples(i_samples), .m_axis_tready(m_axis_tready),
        .o_laser(o_laser), .o_epoch(o_epoch), .m_axis_tdata(m_axis_tdata),
        .m_axis_tvalid(m_axis_tvalid), .m_axis_tlast(m_axis_tlast), .o_overrun(o_overrun),
        .o_saturated(1'b0), .o_peak_step(1'b0), .o_peak_count(1'b0), .o_peak_valid(1'b0));
`endif
endmodule

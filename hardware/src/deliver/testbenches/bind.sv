// Binds goldtof's scoreboard, which compares every output port with the reference model at every
// clock, and the rules of an AXI4-Stream to a design: the emitted one, or your own by
// +define+GOLDTOF_DESIGN=NAME. Compile it behind the design, with the folder of
// goldtof_scoreboard.svh among the include folders, and link libgoldtof_c.so.
// +define+GOLDTOF_SCENE='"PATH"' says where the scene is; +define+GOLDTOF_LATENCY=-2 holds the
// design to the latency that it shows.
// Made by  @MADE_BY@

@DEFINES@`include "goldtof_scoreboard.svh"

`ifndef GOLDTOF_DESIGN
`define GOLDTOF_DESIGN @TOP@
`endif
`ifndef GOLDTOF_SCENE
`define GOLDTOF_SCENE "bind/scene.toml"
`endif
`ifndef GOLDTOF_LATENCY
`define GOLDTOF_LATENCY -1
`endif

bind `GOLDTOF_DESIGN goldtof_scoreboard #(
    .SCENE(`GOLDTOF_SCENE),@SET@ .RESULT_LATENCY(`GOLDTOF_LATENCY), @WIDTHS@
) goldtof_bound_scoreboard (
    @CONNECTED@);

bind `GOLDTOF_DESIGN @RULES@ #(.TDATA(@DATA_BITS@)) goldtof_bound_rules (
    .i_clk(i_clk), .i_rst(i_rst), .m_axis_tready(m_axis_tready), .m_axis_tdata(m_axis_tdata),
    .m_axis_tvalid(m_axis_tvalid), .m_axis_tlast(m_axis_tlast));

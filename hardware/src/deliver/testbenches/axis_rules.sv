// What any AXI4-Stream master keeps to, and the other outputs of a sensor: for simulators with
// concurrent assertions.
// @MADE_BY@

`default_nettype none

module @PREFIX@axis_rules #(
    parameter int TDATA = 16
) (
    input wire             i_clk,
    input wire             i_rst,
    input wire             m_axis_tready,
    input wire [TDATA-1:0] m_axis_tdata,
    input wire             m_axis_tvalid,
    input wire             m_axis_tlast
);
    // Before the first reset outputs mean nothing.
    logic has_reset = 1'b0;
    always_ff @(posedge i_clk) has_reset <= has_reset | i_rst;
    wire is_off = i_rst | !has_reset;

    // An offer stands until it is taken (AMBA 4 AXI4-Stream, 2.2.1).
    offer_stands: assert property (@(posedge i_clk) disable iff (is_off)
        m_axis_tvalid && !m_axis_tready |=> m_axis_tvalid)
        else $error("m_axis_tvalid fell before m_axis_tready was high");
    payload_stands: assert property (@(posedge i_clk) disable iff (is_off)
        m_axis_tvalid && !m_axis_tready |=> $stable(m_axis_tdata) && $stable(m_axis_tlast))
        else $error("m_axis_tdata or m_axis_tlast changed before it was taken");
    valid_is_known: assert property (@(posedge i_clk) disable iff (is_off)
        !$isunknown(m_axis_tvalid))
        else $error("m_axis_tvalid is unknown");
    payload_is_known: assert property (@(posedge i_clk) disable iff (is_off)
        m_axis_tvalid |-> !$isunknown({m_axis_tdata, m_axis_tlast}))
        else $error("m_axis_tdata or m_axis_tlast is unknown");
endmodule

`default_nettype wire

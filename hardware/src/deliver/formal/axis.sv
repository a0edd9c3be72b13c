// In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken
// or reset. Flags stay until reset, the peak's ports until o_peak_valid.
module prove_axis (
    `INPUTS
);
    `DESIGN
    reg began = 1'b0;
    reg reset_before;
    reg waited;
    reg held_last;
    reg overran;
    reg [`DATA_BITS-1:0] held_data;
    always @(posedge i_clk) begin
        began <= 1'b1;
        reset_before <= i_rst;
        waited <= m_axis_tvalid & ~m_axis_tready;
        held_last <= m_axis_tlast;
        held_data <= m_axis_tdata;
        overran <= o_overrun;
    end
    wire stays = began & ~reset_before;
    always @* if (stays & waited) assert (m_axis_tvalid);
    always @* if (stays & waited) assert (m_axis_tlast == held_last);
    always @* if (stays & waited) assert (m_axis_tdata == held_data);
    always @* if (stays & overran) assert (o_overrun);
    always @* if (~stays) assert (o_laser == 0);
    always @* if (~stays) assert (o_epoch == 0);
    always @* if (~stays) assert (m_axis_tdata == 0);
    always @* if (~stays) assert (m_axis_tvalid == 0);
    always @* if (~stays) assert (m_axis_tlast == 0);
    always @* if (~stays) assert (o_overrun == 0);
    generate
        if (`SATURATES) begin : saturation
            reg saturated;
            always @(posedge i_clk) saturated <= o_saturated;
            always @* if (stays & saturated) assert (o_saturated);
            always @* if (~stays) assert (o_saturated == 0);
        end
        if (`FINDS_PEAK) begin : peaks
            reg [`DETECTORS*(`PEAK_STEP_BITS+`COUNT_BITS)-1:0] peak;
            always @(posedge i_clk) peak <= {o_peak_step, o_peak_count};
            always @* if (stays & ~o_peak_valid) assert ({o_peak_step, o_peak_count} == peak);
            always @* if (~stays) assert (o_peak_step == 0);
            always @* if (~stays) assert (o_peak_count == 0);
            always @* if (~stays) assert (o_peak_valid == 0);
        end
    endgenerate
    `REACHES(stays & waited & overran)
endmodule

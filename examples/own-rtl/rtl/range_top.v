// A ranging sensor written by hand: the ports of goldtof's sensor_top, and one more.
`include "sensor_defs.vh"

module range_top (
    input  wire                i_clk,
    input  wire                i_rst,
    output reg                 o_laser,
    output reg                 o_epoch,
    input  wire [`SAMPLES-1:0] i_samples,
    output wire [15:0]         m_axis_tdata,
    output wire                m_axis_tvalid,
    input  wire                m_axis_tready,
    output wire                m_axis_tlast,
    output wire                o_overrun,
    output wire [7:0]          o_step          // for a display
);
    reg  [4:0] chip;
    wire       code;

    code_rom rom (.chip(chip), .now(code), .next());

    always @(posedge i_clk)
        if (i_rst) begin
            chip    <= 0;
            o_laser <= 0;
            o_epoch <= 0;
        end else begin
            chip    <= (chip == `CODE_CHIPS - 1) ? 0 : chip + 1;
            o_laser <= code;
            o_epoch <= chip == 0;
        end

    wire               done, done_last;
    wire signed [15:0] count;

    correlator counts (
        .clk(i_clk), .rst(i_rst), .samples(i_samples),
        .done(done), .done_last(done_last), .count(count), .step(o_step)
    );

    stream_port port (
        .clk(i_clk), .rst(i_rst),
        .put(done), .put_last(done_last), .put_count(count),
        .tdata(m_axis_tdata), .tvalid(m_axis_tvalid), .tlast(m_axis_tlast),
        .tready(m_axis_tready), .lost(o_overrun)
    );
endmodule

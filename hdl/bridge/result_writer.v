// result_writer: results from the core's stream into the FIFO; those that do not fit are counted
//
// Once a result did not fit, all are dropped until the FIFO is less than half full, so that what is
// lost is lost in one piece. The first result after that carries a mark; its index in the scan and how
// many have been lost stand beside the FIFO until the reader has taken them.
//
// With BACK_PRESSURE nothing is dropped: the source waits.

`default_nettype none

module result_writer #(
    parameter BITS          = 18, // of a result
    parameter BACK_PRESSURE = 0
) (
    input  wire            i_clk,
    input  wire            i_rst,

    // Results
    input  wire [BITS-1:0] s_axis_tdata,
    input  wire            s_axis_tvalid,
    output wire            s_axis_tready,
    input  wire            s_axis_tlast,

    // FIFO
    output wire            o_write,
    output wire [BITS+1:0] o_word,        // {results were lost before this one, last of its scan, result}
    input  wire            i_almost_full,
    input  wire            i_half_full,

    // Loss: stands from before the marked word can be seen until i_gap_taken changes
    input  wire            i_gap_taken,   // from the reader, in this clock domain
    output wire [23:0]     o_gap_index,   // of the marked result in its scan
    output wire [23:0]     o_gap_lost     // since reset, modulo 2^24
);

    reg             ready_r;
    reg             valid_r;
    reg             last_r;
    reg  [BITS-1:0] data_r;
    reg  [23:0]     index_r;
    reg             dropping_r;
    reg             may_resume_r;
    reg  [23:0]     lost_r;
    reg             write_r;
    reg  [BITS+1:0] word_r;
    reg             gap_r;        // changes with each marked word
    reg  [23:0]     gap_index_r;
    reg  [23:0]     gap_lost_r;

    wire full   = BACK_PRESSURE == 0 && i_almost_full;
    wire resume = dropping_r && may_resume_r;
    wire drop   = dropping_r ? !may_resume_r : full;

    assign s_axis_tready = ready_r;
    assign o_write       = write_r;
    assign o_word        = word_r;
    assign o_gap_index   = gap_index_r;
    assign o_gap_lost    = gap_lost_r;

    always @(posedge i_clk) begin
        // Only a register between the core and what decides.
        ready_r <= !i_rst && (BACK_PRESSURE == 0 || !i_almost_full);
        valid_r <= s_axis_tvalid && ready_r;
        last_r  <= s_axis_tlast;
        data_r  <= s_axis_tdata;

        may_resume_r <= !i_half_full && i_gap_taken == gap_r;
        write_r      <= valid_r && !drop;
        word_r       <= {resume, last_r, data_r};
        if (valid_r) begin
            index_r    <= last_r ? 24'd0 : index_r + 24'd1;
            dropping_r <= drop;
            if (drop) begin
                lost_r <= lost_r + 24'd1;
            end
            if (resume) begin
                gap_r       <= !gap_r;
                gap_index_r <= index_r;
                gap_lost_r  <= lost_r;
            end
        end

        if (i_rst) begin
            valid_r    <= 1'b0;
            write_r    <= 1'b0;
            index_r    <= 24'd0;
            dropping_r <= 1'b0;
            lost_r     <= 24'd0;
            gap_r      <= 1'b0;
        end
    end

endmodule

`default_nettype wire

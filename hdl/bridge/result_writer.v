// result_writer: results from the core's stream into the FIFO; those that do not fit are counted
//
// Once a result did not fit, the rest of its scan is dropped, and further scans until one begins with the
// FIFO less than half full: what is lost is lost in one piece, and a result's place in its scan never
// depends on what was lost before. The first result after that carries a mark; how many were lost stands
// beside the FIFO until the reader has taken it.
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
    output wire [15:0]     o_lost         // since reset, modulo 2^16
);

    reg             ready_r;
    reg             valid_r;
    reg             last_r;
    reg  [BITS-1:0] data_r;
    reg             first_r;      // the result is the first of its scan
    reg             dropping_r;
    reg             may_resume_r;
    reg  [15:0]     lost_r;
    reg             write_r;
    reg  [BITS+1:0] word_r;
    reg             gap_r;        // changes with each marked word
    reg  [15:0]     gap_lost_r;

    wire full   = BACK_PRESSURE == 0 && i_almost_full;
    wire resume = dropping_r && first_r && may_resume_r;
    wire drop   = dropping_r ? !(first_r && may_resume_r) : full;

    assign s_axis_tready = ready_r;
    assign o_write       = write_r;
    assign o_word        = word_r;
    assign o_lost        = gap_lost_r;

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
            first_r    <= last_r;
            dropping_r <= drop;
        end
        if (valid_r && drop) begin
            lost_r <= lost_r + 16'd1;
        end
        if (valid_r && resume) begin
            gap_r      <= !gap_r;
            gap_lost_r <= lost_r;
        end

        if (i_rst) begin
            valid_r    <= 1'b0;
            write_r    <= 1'b0;
            first_r    <= 1'b1;
            dropping_r <= 1'b0;
            lost_r     <= 16'd0;
            gap_r      <= 1'b0;
            gap_lost_r <= 16'd0;
        end
    end

endmodule

`default_nettype wire

// result_stream: counts of the phase steps as AXI4-Stream
//
// The sensor cannot stall: results that come while others still wait are lost, and o_overrun
// stays high until reset.
//
// A detector's steps have seen the same light: their total count is kept once, and goes out
// with each of them.
//
// Latency  1 clock from i_counted to o_valid
// Made by  goldtof emit image-glass.toml (goldtof 0.1.0)

`default_nettype none

module result_stream (
    input  wire        i_clk, i_rst,

    input  wire [20:0] i_count,   // count of the step, signed
    input  wire [19:0] i_total,   // total count of the group's steps
    input  wire        i_counted, // new counts are there
    input  wire        i_last,    // they are the scan's last
    input  wire        i_ready,   // the receiver takes the result

    output wire [47:0] o_data,    // from bit 24 its total, below its signed count
    output reg         o_valid,   // a result waits
    output reg         o_last,    // the result is the scan's last
    output reg         o_overrun  // a result was lost since reset
);

    reg  [20:0] count_r; // the result
    reg  [19:0] total_r; // the result's total count

    wire        blocked = o_valid & ~i_ready;
    wire        load = i_counted & ~blocked;
    wire [23:0] signed_count = {{3{count_r[20]}}, count_r}; // the count, signed, in whole bytes

    assign o_data = {4'd0, total_r, signed_count};

    always @(posedge i_clk)
        if (i_rst) begin
            {count_r, total_r, o_valid, o_last, o_overrun} <= 0;
        end else begin
            if (load) begin
                count_r <= i_count;
                total_r <= i_total;
                o_last <= i_last;
            end
            o_valid <= i_counted | blocked;
            if (i_counted & blocked) o_overrun <= 1'b1;
        end

endmodule

`default_nettype wire

// result_stream: counts of the phase steps as AXI4-Stream
//
// The sensor cannot stall: results that come while others still wait are lost, and o_overrun
// stays high until reset.
//
// Latency  1 clock from i_counted to o_valid
// Made by  goldtof emit image.toml (goldtof 0.1.0)

`default_nettype none

module result_stream (
    input  wire        i_clk, i_rst,

    input  wire [18:0] i_count,   // count of the step, signed
    input  wire        i_counted, // new counts are there
    input  wire        i_last,    // they are the scan's last
    input  wire        i_ready,   // the receiver takes the result

    output wire [23:0] o_data,    // count of the step, signed
    output reg         o_valid,   // a result waits
    output reg         o_last,    // the result is the scan's last
    output reg         o_overrun  // a result was lost since reset
);

    reg  [18:0] count_r; // the result

    wire blocked = o_valid & ~i_ready;
    wire load = i_counted & ~blocked;

    assign o_data = {{5{count_r[18]}}, count_r};

    always @(posedge i_clk)
        if (i_rst) begin
            {count_r, o_valid, o_last, o_overrun} <= 0;
        end else begin
            if (load) begin
                count_r <= i_count;
                o_last <= i_last;
            end
            o_valid <= i_counted | blocked;
            if (i_counted & blocked) o_overrun <= 1'b1;
        end

endmodule

`default_nettype wire

// result_stream: counts of the phase steps as AXI4-Stream
//
// The base is the total at the last dump. The sensor cannot stall: a result that comes while
// another still waits is lost, and o_overrun stays high until reset.
//
// Latency  1 clock from i_dump to o_valid
// Rate     one result per clock
// Made by  goldtof emit multipath.toml (goldtof 0.1.0)

`default_nettype none

module result_stream (
    // Clock and reset
    input  wire        i_clk,     // one total per cycle
    input  wire        i_rst,     // synchronous, active high

    // Inputs
    input  wire [16:0] i_total,   // sum over all hits, modulo its width
    input  wire        i_dump,    // i_total has just taken in a step's last hits
    input  wire        i_last,    // the step is the scan's last
    input  wire        i_ready,   // the receiver takes the result

    // Outputs
    output wire [23:0] o_data,    // count of the step, signed
    output reg         o_valid,   // a result waits
    output reg         o_last,    // the result is the scan's last
    output reg         o_overrun  // a result was lost since reset
);

    reg  [16:0] base_r;     // total at the last dump
    reg  [16:0] count_r;    // count of the step, signed
    wire        blocked;    // another result still waits
    wire        new_result; // a result arrives

    assign blocked = o_valid & ~i_ready;
    assign new_result = i_dump;
    assign o_data = {{7{count_r[16]}}, count_r};

    always @(posedge i_clk) begin
        if (i_rst) begin
            base_r <= 17'd0;
            count_r <= 17'd0;
            o_valid <= 1'b0;
            o_last <= 1'b0;
            o_overrun <= 1'b0;
        end else begin
            if (i_dump) begin
                base_r <= i_total;
            end
            if (new_result & ~blocked) begin
                count_r <= i_total - base_r;
                o_last <= i_last;
            end
            o_valid <= new_result | blocked;
            if (new_result & blocked) begin
                o_overrun <= 1'b1;
            end
        end
    end

endmodule

`default_nettype wire

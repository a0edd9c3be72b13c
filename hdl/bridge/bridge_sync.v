// bridge_sync: bits of another clock domain through two flip-flops
//
// Several bits come through together only if at most one of them changes at a time.

`default_nettype none

module bridge_sync #(
    parameter BITS = 1
) (
    input  wire            i_clk,
    input  wire [BITS-1:0] i_async,
    output wire [BITS-1:0] o_sync
);

    reg [BITS-1:0] meta_r;
    reg [BITS-1:0] sync_r;

    assign o_sync = sync_r;

    always @(posedge i_clk) begin
        meta_r <= i_async;
        sync_r <= meta_r;
    end

endmodule

`default_nettype wire

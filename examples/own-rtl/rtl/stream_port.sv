// One result for an AXI4-Stream receiver. A result that finds the one before it not taken
// is lost, and says so until reset.
module stream_port (
    input  logic               clk,
    input  logic               rst,
    input  logic               put,
    input  logic               put_last,
    input  logic signed [15:0] put_count,
    output logic        [15:0] tdata,
    output logic               tvalid,
    output logic               tlast,
    input  logic               tready,
    output logic               lost
);
    logic is_free;
    assign is_free = !tvalid || tready;

    always_ff @(posedge clk) begin
        if (rst) begin
            tvalid <= '0;
            tdata  <= '0;
            tlast  <= '0;
            lost   <= '0;
        end else begin
            if (is_free) begin
                tvalid <= put;
                // Without tvalid these may be anything.
                tdata  <= put_count;
                tlast  <= put_last;
            end
            if (put && !is_free)
                lost <= '1;
        end
    end
endmodule

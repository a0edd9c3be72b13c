// accumulator: a running total and its growth per phase step
//
// The total is never cleared: a step's count is the difference of two totals, which keeps
// multiplexers out of the carry chain, and wrapping does no harm to a difference.
//
// Latency  1 clock to the total, 1 more to o_count
// Made by  goldtof emit image.toml (goldtof 0.1.0)

`default_nettype none

module accumulator (
    input  wire        i_clk, i_rst,

    input  wire [3:0]  i_addend, // what to add, signed
    input  wire        i_dump,   // the total holds the last addend of a phase step

    output reg  [18:0] o_count   // growth within the last phase step
);

    reg  [18:0] total_r; // sum of all addends, modulo its width
    reg  [18:0] base_r;  // total at the last dump

    wire [18:0] difference = total_r - base_r;

    always @(posedge i_clk)
        if (i_rst) begin
            {total_r, base_r, o_count} <= 0;
        end else begin
            total_r <= total_r + {{15{i_addend[3]}}, i_addend};
            if (i_dump) begin
                base_r <= total_r;
                o_count <= difference;
            end
        end

endmodule

`default_nettype wire

// chip_history: the reference's last chips, delayed by holding its generator
//
// Latency  1 clock from i_chip to o_chips
// Rate     one chip per clock
// Made by  goldtof emit moving.toml (goldtof 0.1.0)

`default_nettype none

module chip_history (
    // Clock and reset
    input  wire       i_clk,     // one chip per cycle
    input  wire       i_rst,     // synchronous, active high

    // Inputs
    input  wire       i_chip,    // next chip of the reference
    input  wire       i_wrap,    // last clock of a step after which the delay grows by a chip more
    input  wire       i_start,   // a scan begins with the next clock

    // Outputs
    output wire       o_advance, // the reference generator goes on to its next chip
    output reg  [1:0] o_chips    // reference chips, the present one in bit 0
);

    // Reference chips after reset and at a scan's start
    localparam [1:0] CHIPS_LOAD = 2'd0;

    assign o_advance = ~i_wrap;

    always @(posedge i_clk) begin
        if (i_rst) begin
            o_chips <= CHIPS_LOAD;
        end else begin
            if (~i_wrap) begin
                o_chips <= {o_chips[0], i_chip};
            end
            if (i_start) begin
                o_chips <= CHIPS_LOAD;
            end
        end
    end

endmodule

`default_nettype wire

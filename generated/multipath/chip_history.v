// chip_history: the reference's last chips, delayed by holding its generator
//
// Latency  1 clock from i_chip to o_chips
// Made by  goldtof emit multipath.toml (goldtof 0.1.0)

`default_nettype none

module chip_history (
    input  wire       i_clk, i_rst,

    input  wire       i_chip,    // next chip of the reference
    input  wire       i_wrap,    // last chip of a step; the next delays by a chip more

    output wire       o_advance, // the reference generator goes on to its next chip
    output reg  [1:0] o_chips    // reference chips, the present one in bit 0
);

    localparam [1:0] CHIPS_LOAD = 2'h0; // after reset and at a scan's start

    assign o_advance = ~i_wrap;

    always @(posedge i_clk)
        if (i_rst) o_chips <= CHIPS_LOAD;
        else if (~i_wrap) o_chips <= {o_chips[0], i_chip};

endmodule

`default_nettype wire

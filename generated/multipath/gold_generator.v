// gold_generator: Gold code, the XOR of two linear-feedback shift registers
//
// Bit 0 of a register is its present chip, bit i the chip i clocks later; the feedback enters
// at the top. The epoch needs u only, because both registers have the same period, and is
// recognised one chip early, so that it comes from a register.
//
// Period   2047 chips
// Latency  0 clocks from register to o_chip
// Made by  goldtof emit multipath.toml (goldtof 0.1.0)

`default_nettype none

module gold_generator (
    input  wire i_clk, i_rst,

    input  wire i_advance, // go on to the next chip

    output wire o_chip,    // present chip
    output reg  o_epoch    // the present chip is the one that reset gives
);

    // u: an LFSR of the polynomial 11,2,0 (exponents)
    localparam [10:0] U_TAPS = 11'h201;
    localparam [10:0] U_LOAD = 11'h7ff; // the first 11 chips, the earliest in bit 0
    localparam [10:0] U_LAST = 11'h7fe; // 2046 shifts on, one chip before the first comes again

    // v: an LFSR of the polynomial 11,8,5,2,0 (exponents)
    localparam [10:0] V_TAPS = 11'h249;
    localparam [10:0] V_LOAD = 11'h7ff; // the first 11 chips, the earliest in bit 0

    reg  [10:0] u_r, v_r;

    assign o_chip = u_r[0] ^ v_r[0];

    always @(posedge i_clk)
        if (i_rst) begin
            u_r <= U_LOAD;
            o_epoch <= 1'b1;
            v_r <= V_LOAD;
        end else if (i_advance) begin
            o_epoch <= u_r == U_LAST;
            u_r <= {^(u_r & U_TAPS), u_r[10:1]};
            v_r <= {^(v_r & V_TAPS), v_r[10:1]};
        end

`ifndef SYNTHESIS
    lfsr_check #(
        .WIDTH(11), .TAPS(U_TAPS), .SHIFTS(64'd2046),
        .FIRST(U_LOAD), .LAST(U_LAST)
    ) u_last_check ();
`endif

endmodule

`default_nettype wire

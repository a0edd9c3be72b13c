// gold_generator: Gold code, the XOR of two linear-feedback shift registers
//
// Bit 0 of a register is its present chip, bit i the chip i clocks later; the feedback enters
// at the top. The epoch needs u only, because both registers have the same period, and is
// recognised one chip early, so that it comes from a register.
//
// Period   127 chips
// Latency  0 clocks from register to o_chip
// Made by  goldtof emit image-glass.toml (goldtof 0.1.0)

`default_nettype none

module gold_generator #(
    // u: an LFSR of the polynomial 7,1,0 (exponents); the first 7 chips, the earliest in bit 0
    parameter [6:0] U_LOAD = 7'h7f,
    // u: an LFSR of the polynomial 7,1,0 (exponents); 126 shifts on, one chip before the first
    // comes again
    parameter [6:0] U_LAST = 7'h7e,
    // v: an LFSR of the polynomial 7,5,3,1,0 (exponents); the first 7 chips, the earliest in
    // bit 0
    parameter [6:0] V_LOAD = 7'h7f
) (
    input  wire i_clk, i_rst,

    input  wire i_advance, // go on to the next chip
    input  wire i_load,    // start again as after reset; wins over i_advance

    output wire o_chip,    // present chip
    output reg  o_epoch    // the present chip is the one that reset gives
);

    // u: an LFSR of the polynomial 7,1,0 (exponents)
    localparam [6:0] U_TAPS = 7'h41;

    // v: an LFSR of the polynomial 7,5,3,1,0 (exponents)
    localparam [6:0] V_TAPS = 7'h55;

    reg  [6:0] u_r, v_r;

    assign o_chip = u_r[0] ^ v_r[0];

    always @(posedge i_clk)
        if (i_rst) begin
            u_r <= U_LOAD;
            o_epoch <= 1'b1;
            v_r <= V_LOAD;
        end else begin
            if (i_advance) begin
                o_epoch <= u_r == U_LAST;
                u_r <= {^(u_r & U_TAPS), u_r[6:1]};
                v_r <= {^(v_r & V_TAPS), v_r[6:1]};
            end
            if (i_load) begin
                o_epoch <= 1'b1;
                u_r <= U_LOAD;
                v_r <= V_LOAD;
            end
        end

`ifndef SYNTHESIS
    lfsr_check #(
        .WIDTH(7), .TAPS(U_TAPS), .SHIFTS(64'd126),
        .FIRST(U_LOAD), .LAST(U_LAST)
    ) u_last_check ();
`endif

endmodule

`default_nettype wire

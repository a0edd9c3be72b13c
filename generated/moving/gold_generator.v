// gold_generator: Gold code, the XOR of two linear-feedback shift registers
//
// Bit 0 of a register is its present chip, bit i the chip i clocks later; the feedback enters
// at the top. The epoch needs u only, because both registers have the same period, and is
// recognised one chip early, so that it comes from a register.
//
// Polynomials  u 11,2,0 (exponents); v 11,8,5,2,0 (exponents)
// Period       2047 chips
// Latency      0 clocks from register to o_chip
// Rate         one chip per clock with i_advance high
// Made by      goldtof emit moving.toml (goldtof 0.1.0)

`default_nettype none

module gold_generator #(
    // First 11 chips of u, the earliest in bit 0
    parameter [10:0] U_LOAD = 11'h7ff,
    // LFSR u one chip before that
    parameter [10:0] U_LAST = 11'h7fe,
    // First 11 chips of v, the earliest in bit 0
    parameter [10:0] V_LOAD = 11'h7ff
) (
    // Clock and reset
    input  wire  i_clk,     // one chip per cycle at most
    input  wire  i_rst,     // synchronous, active high

    // Inputs
    input  wire  i_advance, // go on to the next chip
    input  wire  i_load,    // start again as after reset; wins over i_advance

    // Outputs
    output wire  o_chip,    // present chip
    output reg   o_epoch    // the present chip is the one that reset gives
);

    // Taps of u: bit n - e for every exponent e > 0 of degree n
    localparam [10:0] U_TAPS = 11'h201;

    // Taps of v: bit n - e for every exponent e > 0 of degree n
    localparam [10:0] V_TAPS = 11'h249;

    reg  [10:0] u_r; // LFSR u
    reg  [10:0] v_r; // LFSR v

    assign o_chip = u_r[0] ^ v_r[0];

    always @(posedge i_clk) begin
        if (i_rst) begin
            u_r <= U_LOAD;
            o_epoch <= 1'b1;
            v_r <= V_LOAD;
        end else begin
            if (i_advance) begin
                o_epoch <= u_r == U_LAST;
                u_r <= {^(u_r & U_TAPS), u_r[10:1]};
                v_r <= {^(v_r & V_TAPS), v_r[10:1]};
            end
            if (i_load) begin
                o_epoch <= 1'b1;
                u_r <= U_LOAD;
                v_r <= V_LOAD;
            end
        end
    end

endmodule

`default_nettype wire

// crc32: CRC-32 of a frame, a bit per clock, least significant bit of each byte first
//
// The CRC of IEEE 802.3 (reveng: CRC-32/ISO-HDLC; polynomial 0x04C11DB7, reflected, starts with ones,
// sent complemented). It is the remainder of a long division, of which the register keeps the last 32
// digits of the quotient, not the remainder: the next digit is the frame's next bit, less what the last
// digits make of the divisor at that place. So one parity takes the place of an XOR at each of the
// divisor's 14 places. The CRC's bits are those that make the digits 0.
//
// With i_bits bits are taken in; without, o_bit is the next bit of the CRC as it is on the line.

`default_nettype none

module crc32 (
    input  wire i_clk,
    input  wire i_clear, // as before a frame, whatever i_shift says
    input  wire i_shift,
    input  wire i_bits,  // a bit of the frame, or one of its CRC
    input  wire i_bit,
    output wire o_bit
);

    // Of the polynomial; the newest digit is in bit 0.
    localparam [31:0] DIVISOR = 32'hEDB88320;
    // Digits before which a remainder of 32 ones is left.
    localparam [31:0] FIRST   = 32'h47830999;

    reg  [31:0] digits_r;
    wire        due = ^(digits_r & DIVISOR);

    assign o_bit = ~due;

    always @(posedge i_clk) begin
        if (i_clear) begin
            digits_r <= FIRST;
        end else if (i_shift) begin
            digits_r <= {digits_r[30:0], i_bits && (i_bit ^ due)};
        end
    end

endmodule

`default_nettype wire

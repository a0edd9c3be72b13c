// crc32: CRC-32 of a frame, a bit per clock, least significant bit of each byte first
//
// The CRC of IEEE 802.3 (reveng: CRC-32/ISO-HDLC; polynomial 0x04C11DB7, reflected, starts with ones,
// sent complemented). With i_bits the register takes bits in; without, it gives them out:
// o_bit is the next bit of the CRC as it is on the line.

`default_nettype none

module crc32 (
    input  wire i_clk,
    input  wire i_clear, // all ones, whatever i_shift says
    input  wire i_shift,
    input  wire i_bits,  // a bit of the frame, or one of its CRC
    input  wire i_bit,
    output wire o_bit
);

    reg  [31:0] crc_r;
    wire        feedback = i_bits && (crc_r[0] ^ i_bit);

    assign o_bit = ~crc_r[0];

    always @(posedge i_clk) begin
        if (i_clear) begin
            crc_r <= 32'hFFFFFFFF;
        end else if (i_shift) begin
            crc_r <= {1'b0, crc_r[31:1]} ^ (32'hEDB88320 & {32{feedback}});
        end
    end

endmodule

`default_nettype wire

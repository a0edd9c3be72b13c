// scene_text: the text of the scene, which a host reads in blocks of 32 bytes
//
// A memory of bytes that is never written, on the line's clock.

`default_nettype none

module scene_text #(
    parameter                  BLOCKS       = 1,     // of 32 bytes, 1 .. 127
    parameter                  ADDRESS_BITS = 5,     // of 32 * BLOCKS - 1
    parameter [256*BLOCKS-1:0] TEXT         = 256'd0 // the first byte in bits 7..0; zeros behind its end
) (
    input  wire                    i_clk,
    input  wire [ADDRESS_BITS-1:0] i_address, // of a byte
    output reg  [7:0]              o_byte     // a clock later
);

    reg [7:0] bytes [0:(1<<ADDRESS_BITS)-1];

    integer k;

    initial begin
        for (k = 0; k < (1 << ADDRESS_BITS); k = k + 1) begin
            bytes[k] = 8'd0;
        end
        for (k = 0; k < 32 * BLOCKS; k = k + 1) begin
            bytes[k] = TEXT[8*k +: 8];
        end
    end

    always @(posedge i_clk) begin
        o_byte <= bytes[i_address];
    end

endmodule

`default_nettype wire

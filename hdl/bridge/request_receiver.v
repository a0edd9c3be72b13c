// request_receiver: requests of the host, from the bits of the line
//
// A request is 13 bytes (docs/wire.md): 0x5A, kind, tag, address (2), data (4), CRC-32 (4), least
// significant byte first. One that is torn is dropped: by its CRC, by a byte without a stop bit, or by
// silence. While a request is being answered the line is not listened to, and its bits go out again from
// the first on, for the answer that repeats them.

`default_nettype none

module request_receiver (
    input  wire        i_clk,
    input  wire        i_rst,

    // From uart_receiver
    input  wire        i_valid,
    input  wire        i_bit,
    input  wire        i_byte,
    input  wire        i_broken,
    input  wire        i_silence,

    output wire        o_request,  // until i_answered
    output wire        o_transfer, // it reads or writes a register
    output wire        o_write,    // it writes
    output wire        o_text,     // it asks for the scene's text
    output wire        o_counts,   // or for hits by sample
    output wire [11:0] o_address,  // this and o_data: until the first i_repeat
    output wire [31:0] o_data,
    output wire        o_bit,      // of the request, the first one of its kind first
    input  wire        i_repeat,   // o_bit goes on
    input  wire        i_answered
);

    localparam [7:0] SYNC       = 8'h5A;
    localparam [7:0] KIND_READ  = 8'h52; // R
    localparam [7:0] KIND_WRITE = 8'h57; // W
    localparam [7:0] KIND_TEXT  = 8'h54; // T
    localparam [7:0] KIND_HITS  = 8'h48; // H

    reg         request_r;
    reg         transfer_r;
    reg         write_r;
    reg         text_r;
    reg         counts_r;
    reg  [3:0]  byte_r;  // of the request; 0: its first is awaited
    reg  [63:0] bits_r;  // the last 64 before the CRC
    reg         wrong_r; // a bit of the CRC is

    wire begins = byte_r == 4'd0;
    wire is_crc = byte_r[3] && byte_r[2:0] != 3'd0;
    wire ends   = byte_r[3] && byte_r[2];
    wire crc_bit;

    assign o_request  = request_r;
    assign o_transfer = transfer_r;
    assign o_write    = write_r;
    assign o_text     = text_r;
    assign o_counts   = counts_r;
    assign o_address  = bits_r[27:16];
    assign o_data     = bits_r[63:32];
    assign o_bit      = bits_r[0];

    crc32 crc (
        .i_clk   (i_clk),
        .i_clear (begins),
        .i_shift (i_valid),
        .i_bits  (!is_crc),
        .i_bit   (i_bit),
        .o_bit   (crc_bit)
    );

    always @(posedge i_clk) begin
        if (request_r ? i_repeat : i_valid && !is_crc) begin
            bits_r <= {i_bit, bits_r[63:1]};
        end
        if (begins) begin
            wrong_r <= 1'b0;
        end else if (i_valid && is_crc && i_bit != crc_bit) begin
            wrong_r <= 1'b1;
        end
        if (i_rst || i_silence || i_broken || request_r) begin
            byte_r <= 4'd0;
        end else if (i_byte && !(begins && bits_r[63:56] != SYNC)) begin
            byte_r <= ends ? 4'd0 : byte_r + 4'd1;
        end
        // The kind is gone when the request is repeated.
        if (!request_r) begin
            write_r    <= bits_r[7:0] == KIND_WRITE;
            text_r     <= bits_r[7:0] == KIND_TEXT;
            counts_r   <= bits_r[7:0] == KIND_HITS;
            transfer_r <= bits_r[7:0] == KIND_WRITE || bits_r[7:0] == KIND_READ;
        end
        if (i_rst || i_answered) begin
            request_r <= 1'b0;
        end else if (i_byte && ends && !wrong_r) begin
            request_r <= 1'b1;
        end
    end

endmodule

`default_nettype wire

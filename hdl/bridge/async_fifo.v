// async_fifo: words from one clock domain to another, with a look ahead
//
// The reader has two places: `ahead` looks at words that are kept, and `read` gives them back. So it can
// count what it will send before it sends it. Both only go forward, `read` up to `ahead`.
// Each domain knows the other's place by a Gray code, of which one bit changes at a time, through two
// flip-flops. Both resets have to overlap.
//
// Write  i_write may not be high while 2^ADDRESS_BITS words are in. o_almost_full rises 3 clocks after a
//        write that leaves fewer than 8 places, so a writer that stops within 5 clocks loses nothing.
// Read   o_word is the word at the chosen place, 2 clocks after the place was chosen or went on.
//        o_available tells in the same clock as the place whether the word `ahead` is there.

`default_nettype none

module async_fifo #(
    parameter ADDRESS_BITS = 10,
    parameter BITS         = 20
) (
    // Writer
    input  wire            i_clk,
    input  wire            i_rst,
    input  wire            i_write,
    input  wire [BITS-1:0] i_word,
    output wire            o_almost_full,
    output wire            o_half_full,   // half of the places or more are taken

    // Reader
    input  wire            i_read_clk,
    input  wire            i_read_rst,
    input  wire            i_look,        // o_word is `ahead`, not `read`
    input  wire            i_ahead,       // `ahead` goes on by a word
    input  wire            i_read,        // `read` goes on by a word
    output wire            o_available,   // the word at `ahead` is there
    output wire            o_met,         // `read` has come up to `ahead`
    output wire [BITS-1:0] o_word
);

    // Places have a bit more than addresses: how often they went round.
    localparam TOP = ADDRESS_BITS;

    generate
        if (ADDRESS_BITS < 5) begin : gen_too_shallow
            async_fifo_needs_ADDRESS_BITS_of_5_or_more stop ();
        end
    endgenerate

    // Writer

    reg  [TOP:0] write_r;
    reg  [TOP:0] write_gray_r;    // a clock behind: the word is in the memory
    wire [TOP:0] read_gray_seen;
    reg  [TOP:0] read_seen_r;
    reg  [TOP:0] used_r;
    reg          almost_full_r;
    reg          half_full_r;
    integer      k;

    assign o_almost_full = almost_full_r;
    assign o_half_full   = half_full_r;

    bridge_sync #(
        .BITS (TOP + 1)
    ) read_sync (
        .i_clk   (i_clk),
        .i_async (read_gray_r),
        .o_sync  (read_gray_seen)
    );

    always @(posedge i_clk) begin
        write_gray_r <= write_r ^ (write_r >> 1);
        for (k = 0; k <= TOP; k = k + 1) begin
            read_seen_r[k] <= ^(read_gray_seen >> k);
        end
        used_r        <= write_r - read_seen_r;
        almost_full_r <= used_r[TOP] || &used_r[TOP-1:3];
        half_full_r   <= used_r[TOP] || used_r[TOP-1];
        if (i_write) begin
            write_r <= write_r + 1'b1;
        end
        if (i_rst) begin
            write_r      <= {(TOP + 1){1'b0}};
            write_gray_r <= {(TOP + 1){1'b0}};
        end
    end

    // Reader

    reg  [TOP:0] ahead_r;
    reg  [TOP:0] read_r;
    reg  [TOP:0] read_gray_r;
    wire [TOP:0] write_gray_seen;

    assign o_available = (ahead_r ^ (ahead_r >> 1)) != write_gray_seen;
    assign o_met       = read_r == ahead_r;

    bridge_sync #(
        .BITS (TOP + 1)
    ) write_sync (
        .i_clk   (i_read_clk),
        .i_async (write_gray_r),
        .o_sync  (write_gray_seen)
    );

    always @(posedge i_read_clk) begin
        read_gray_r <= read_r ^ (read_r >> 1);
        if (i_ahead) begin
            ahead_r <= ahead_r + 1'b1;
        end
        if (i_read) begin
            read_r <= read_r + 1'b1;
        end
        if (i_read_rst) begin
            ahead_r     <= {(TOP + 1){1'b0}};
            read_r      <= {(TOP + 1){1'b0}};
            read_gray_r <= {(TOP + 1){1'b0}};
        end
    end

    bridge_memory #(
        .ADDRESS_BITS (ADDRESS_BITS),
        .BITS         (BITS)
    ) memory (
        .i_write_clk     (i_clk),
        .i_write         (i_write),
        .i_write_address (write_r[TOP-1:0]),
        .i_data          (i_word),
        .i_read_clk      (i_read_clk),
        .i_address       (i_look ? ahead_r[TOP-1:0] : read_r[TOP-1:0]),
        .o_word          (o_word)
    );

endmodule

`default_nettype wire

// async_fifo: words from one clock domain to another, with a look ahead
//
// The reader has two places: `ahead` looks at words that are kept, and `read` gives them back. So it can
// count what it will send before it sends it. Both only go forward, `read` up to `ahead`.
//
// Each domain knows the other's place by a messenger that goes round for ever: one bit through two
// flip-flops each way. Who has it writes down the own place and what the other one has written down, which
// stands as long as the messenger is on its way. What is known is up to a round old (some four clocks of
// each domain) and errs to the safe side. Gray codes would be told sooner, at 30 LUT4 more. Both resets
// have to overlap.
//
// Write  i_write may not be high while 2^ADDRESS_BITS words are in. o_almost_full rises 3 clocks after a
//        write that leaves 8 places, so a writer that stops within 5 clocks loses nothing.
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

    reg          there_r;       // the messenger, as the writer sends it back
    reg          back_r;        // as the reader sends it
    reg  [TOP:0] write_r;
    reg  [TOP:0] write_told_r;
    reg  [TOP:0] read_known_r;  // by the writer
    reg  [TOP:0] used_r;
    reg          almost_full_r;
    reg          half_full_r;
    reg  [TOP:0] ahead_r;
    reg  [TOP:0] read_r;
    reg  [TOP:0] read_told_r;
    reg  [TOP:0] write_known_r; // by the reader
    wire         there_seen;
    wire         back_seen;

    // Writer

    wire writer_has_it = back_seen != there_r;

    assign o_almost_full = almost_full_r;
    assign o_half_full   = half_full_r;

    bridge_sync #(
        .BITS (1)
    ) back_sync (
        .i_clk   (i_clk),
        .i_async (back_r),
        .o_sync  (back_seen)
    );

    always @(posedge i_clk) begin
        used_r        <= write_r - read_known_r;
        almost_full_r <= used_r[TOP] || &used_r[TOP-1:3];
        half_full_r   <= used_r[TOP] || used_r[TOP-1];
        if (i_write) begin
            write_r <= write_r + 1'b1;
        end
        if (writer_has_it) begin
            there_r      <= back_seen;
            write_told_r <= write_r;
            read_known_r <= read_told_r;
        end
        if (i_rst) begin
            there_r      <= 1'b0;
            write_r      <= {(TOP + 1){1'b0}};
            write_told_r <= {(TOP + 1){1'b0}};
            read_known_r <= {(TOP + 1){1'b0}};
        end
    end

    // Reader

    wire reader_has_it = there_seen == back_r;

    // Places are at most 2^ADDRESS_BITS apart, so the sign of a difference tells whether there is one: a carry
    // chain in place of two comparisons.
    wire [TOP:0] from_written = ahead_r - write_known_r;
    wire [TOP:0] from_ahead   = read_r - ahead_r;

    wire         unused       = &{1'b0, from_written, from_ahead};

    assign o_available = from_written[TOP];
    assign o_met       = !from_ahead[TOP];

    bridge_sync #(
        .BITS (1)
    ) there_sync (
        .i_clk   (i_read_clk),
        .i_async (there_r),
        .o_sync  (there_seen)
    );

    always @(posedge i_read_clk) begin
        if (i_ahead) begin
            ahead_r <= ahead_r + 1'b1;
        end
        if (i_read) begin
            read_r <= read_r + 1'b1;
        end
        if (reader_has_it) begin
            back_r        <= !back_r;
            read_told_r   <= read_r;
            write_known_r <= write_told_r;
        end
        if (i_read_rst) begin
            back_r        <= 1'b0;
            ahead_r       <= {(TOP + 1){1'b0}};
            read_r        <= {(TOP + 1){1'b0}};
            read_told_r   <= {(TOP + 1){1'b0}};
            write_known_r <= {(TOP + 1){1'b0}};
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

// bridge_core: what both bridges are made of: results to the line, requests from it
//
// A request that has come stands at o_request and the others until i_answer has been sent and o_answered
// was high. Ports and parameters are described in README.md.

`default_nettype none

module bridge_core #(
    parameter         TDATA_BITS     = 24,
    parameter         COUNT_BITS     = 18,
    parameter         COUNTS         = 1,
    parameter         COUNT_STRIDE   = 24,
    parameter         MORE_FIRST_BIT = 0,
    parameter         MORE_BITS      = 0,
    parameter         BACK_PRESSURE  = 0,
    parameter         CLOCKS_PER_BIT = 16,
    parameter         ADDRESS_BITS   = 10,
    parameter         SAMPLE_COUNTS  = 0,
    parameter [255:0] IDENTITY       = 256'd0,
    parameter         TEXT_BLOCKS    = 0,
    // One block at least, as a vector has a bit.
    parameter [256*(TEXT_BLOCKS > 0 ? TEXT_BLOCKS : 1)-1:0] TEXT = 256'd0
) (
    input  wire                  i_clk,
    input  wire                  i_rst,
    output wire                  o_rst,      // a clock behind i_rst, until the other side was in reset, too

    input  wire                  i_uart_clk,
    output wire                  o_uart_rst,
    input  wire                  i_rx,
    output wire                  o_tx,

    // Results and flags of the core
    input  wire [TDATA_BITS-1:0] s_axis_tdata,
    input  wire                  s_axis_tvalid,
    output wire                  s_axis_tready,
    input  wire                  s_axis_tlast,
    input  wire                  i_overrun,
    input  wire                  i_saturated,

    // Counts by sample, on i_uart_clk; i_held and i_word come from another clock
    output wire                  o_hold,
    output wire [9:0]            o_place,    // of a word, while held
    input  wire                  i_held,
    input  wire [31:0]           i_word,

    // Requests and answers, on i_uart_clk
    output wire                  o_request,
    output wire                  o_transfer, // it reads or writes a register
    output wire                  o_write,
    output wire [11:0]           o_address,
    output wire [31:0]           o_data,
    input  wire                  i_answer,
    input  wire                  i_identify, // the answer is the identity, else status and data
    input  wire [1:0]            i_status,
    input  wire [31:0]           i_data,
    output wire                  o_answered
);

    localparam BITS = COUNTS * COUNT_BITS + MORE_BITS;

    // Bits of a number from 0 to `last`.
    function integer bits_of;
        input integer last;
        integer       rest;
        begin
            bits_of = 1;
            for (rest = last; rest > 1; rest = rest / 2) begin
                bits_of = bits_of + 1;
            end
        end
    endfunction

    localparam TIMER_BITS = bits_of(CLOCKS_PER_BIT - 1);
    localparam PLACE_BITS = bits_of(BITS - 1);

    generate
        if (TEXT_BLOCKS < 0 || TEXT_BLOCKS > 127) begin : gen_blocks
            uart_bridge_needs_TEXT_BLOCKS_of_0_to_127 stop ();
        end
        if (SAMPLE_COUNTS != 0 && SAMPLE_COUNTS != 1) begin : gen_samples
            uart_bridge_needs_SAMPLE_COUNTS_of_0_or_1 stop ();
        end
        if (COUNTS < 1 || COUNT_BITS < 1 || (COUNTS > 1 && COUNT_STRIDE < COUNT_BITS) ||
            (COUNTS - 1) * COUNT_STRIDE + COUNT_BITS > TDATA_BITS || MORE_BITS < 0 ||
            (MORE_BITS > 0 && MORE_FIRST_BIT + MORE_BITS > TDATA_BITS)) begin : gen_fields
            uart_bridge_needs_counts_and_MORE_BITS_within_TDATA_BITS stop ();
        end
        if (BITS < 2 || BITS > 511) begin : gen_width
            uart_bridge_needs_results_of_2_to_511_bits stop ();
        end
        if (BACK_PRESSURE != 0 && BACK_PRESSURE != 1) begin : gen_pressure
            uart_bridge_needs_BACK_PRESSURE_of_0_or_1 stop ();
        end
        if (CLOCKS_PER_BIT < 4 || CLOCKS_PER_BIT > 65535) begin : gen_rate
            uart_bridge_needs_CLOCKS_PER_BIT_of_4_to_65535 stop ();
        end
        // A frame of 255 results is at most half of the FIFO.
        if (ADDRESS_BITS < 9 || ADDRESS_BITS > 14) begin : gen_depth
            uart_bridge_needs_ADDRESS_BITS_of_9_to_14 stop ();
        end
    endgenerate

    wire            rst;
    wire            uart_rst;
    wire [BITS-1:0] result;
    wire            write;
    wire [BITS+1:0] written;
    wire            almost_full;
    wire            half_full;
    wire            gap_taken;
    wire            gap_taken_seen;
    wire [15:0]     lost;
    wire            look;
    wire            ahead;
    wire            read;
    wire            available;
    wire            met;
    wire [BITS+1:0] word;
    wire            overrun;
    wire            saturated;
    wire            active;
    wire            bit_out;
    wire            take;
    wire [2:0]      place;
    wire            between;
    wire            bit_valid;
    wire            bit_in;
    wire            byte_ended;
    wire            broken;
    wire            silence;
    wire            request_bit;
    wire            repeat_bit;
    wire            text_asked;
    wire            counts_asked;
    wire            told;       // bytes of one of both, in place of the identity
    wire            told_ready;
    wire [4:0]      told_place;
    wire [7:0]      told_byte;
    wire [7:0]      text_byte;
    reg  [6:0]      block_r;    // the request goes round while it is repeated

    assign o_rst      = rst;
    assign o_uart_rst = uart_rst;

    bridge_reset resets (
        .i_clk      (i_clk),
        .i_rst      (i_rst),
        .o_rst      (rst),
        .i_uart_clk (i_uart_clk),
        .o_uart_rst (uart_rst)
    );

    // Results without the padding of s_axis_tdata.
    genvar k;
    generate
        for (k = 0; k < COUNTS; k = k + 1) begin : gen_count
            assign result[k*COUNT_BITS +: COUNT_BITS] = s_axis_tdata[k*COUNT_STRIDE +: COUNT_BITS];
        end
        if (MORE_BITS > 0) begin : gen_more
            assign result[BITS-1 -: MORE_BITS] = s_axis_tdata[MORE_FIRST_BIT +: MORE_BITS];
        end
    endgenerate

    result_writer #(
        .BITS          (BITS),
        .BACK_PRESSURE (BACK_PRESSURE)
    ) writer (
        .i_clk         (i_clk),
        .i_rst         (rst),
        .s_axis_tdata  (result),
        .s_axis_tvalid (s_axis_tvalid),
        .s_axis_tready (s_axis_tready),
        .s_axis_tlast  (s_axis_tlast),
        .o_write       (write),
        .o_word        (written),
        .i_almost_full (almost_full),
        .i_half_full   (half_full),
        .i_gap_taken   (gap_taken_seen),
        .o_lost        (lost)
    );

    bridge_sync #(
        .BITS (1)
    ) gap_sync (
        .i_clk   (i_clk),
        .i_async (gap_taken),
        .o_sync  (gap_taken_seen)
    );

    async_fifo #(
        .ADDRESS_BITS (ADDRESS_BITS),
        .BITS         (BITS + 2)
    ) fifo (
        .i_clk         (i_clk),
        .i_rst         (rst),
        .i_write       (write),
        .i_word        (written),
        .o_almost_full (almost_full),
        .o_half_full   (half_full),
        .i_read_clk    (i_uart_clk),
        .i_read_rst    (uart_rst),
        .i_look        (look),
        .i_ahead       (ahead),
        .i_read        (read),
        .o_available   (available),
        .o_met         (met),
        .o_word        (word)
    );

    bridge_sync #(
        .BITS (2)
    ) flag_sync (
        .i_clk   (i_uart_clk),
        .i_async ({i_saturated, i_overrun}),
        .o_sync  ({saturated, overrun})
    );

    always @(posedge i_uart_clk) begin
        if (!active) begin
            block_r <= o_address[11:5];
        end
    end

    assign o_place = {block_r, told_place[4:2]};
    generate
        if (TEXT_BLOCKS > 0) begin : gen_text
            localparam TEXT_BITS = bits_of(32 * TEXT_BLOCKS - 1);

            wire [11:0] address     = {block_r, told_place};
            wire        unused_text = &{1'b0, address};

            scene_text #(
                .BLOCKS       (TEXT_BLOCKS),
                .ADDRESS_BITS (TEXT_BITS),
                .TEXT         (TEXT)
            ) text (
                .i_clk     (i_uart_clk),
                .i_address (address[TEXT_BITS-1:0]),
                .o_byte    (text_byte)
            );
        end else begin : gen_no_text
            wire unused_text = &{1'b0, told_place, TEXT};

            assign text_byte = 8'd0;
        end
        if (SAMPLE_COUNTS != 0) begin : gen_counts
            wire held;

            bridge_sync #(
                .BITS (1)
            ) held_sync (
                .i_clk   (i_uart_clk),
                .i_async (i_held),
                .o_sync  (held)
            );

            assign o_hold     = o_request && counts_asked;
            assign told       = counts_asked || (text_asked && TEXT_BLOCKS > 0);
            assign told_ready = !counts_asked || held;
            assign told_byte  = counts_asked ? i_word[{told_place[1:0], 3'd0} +: 8] : text_byte;
        end else begin : gen_no_counts
            wire unused_counts = &{1'b0, counts_asked, i_held, i_word};

            assign o_hold     = 1'b0;
            assign told       = text_asked && TEXT_BLOCKS > 0;
            assign told_ready = 1'b1;
            assign told_byte  = text_byte;
        end
    endgenerate

    framer #(
        .BITS       (BITS),
        .PLACE_BITS (PLACE_BITS),
        .IDENTITY   (IDENTITY)
    ) frames (
        .i_clk       (i_uart_clk),
        .i_rst       (uart_rst),
        .i_overrun   (overrun),
        .i_saturated (saturated),
        .o_look      (look),
        .o_ahead     (ahead),
        .o_read      (read),
        .i_available (available),
        .i_met       (met),
        .i_word      (word),
        .i_lost      (lost),
        .o_gap_taken (gap_taken),
        .i_answer    (i_answer && told_ready),
        .i_identify  (i_identify),
        .i_told      (told),
        .o_place     (told_place),
        .i_byte      (told_byte),
        .i_status    (i_status),
        .i_data      (i_data),
        .i_request   (request_bit),
        .o_repeat    (repeat_bit),
        .o_answered  (o_answered),
        .o_active    (active),
        .o_bit       (bit_out),
        .i_take      (take),
        .i_place     (place),
        .i_between   (between)
    );

    uart_transmitter #(
        .CLOCKS_PER_BIT (CLOCKS_PER_BIT),
        .TIMER_BITS     (TIMER_BITS)
    ) transmitter (
        .i_clk     (i_uart_clk),
        .i_rst     (uart_rst),
        .i_active  (active),
        .i_bit     (bit_out),
        .o_take    (take),
        .o_place   (place),
        .o_between (between),
        .o_tx      (o_tx)
    );

    uart_receiver #(
        .CLOCKS_PER_BIT (CLOCKS_PER_BIT),
        .TIMER_BITS     (TIMER_BITS)
    ) receiver (
        .i_clk     (i_uart_clk),
        .i_rst     (uart_rst),
        .i_rx      (i_rx),
        .o_valid   (bit_valid),
        .o_bit     (bit_in),
        .o_byte    (byte_ended),
        .o_broken  (broken),
        .o_silence (silence)
    );

    request_receiver requests (
        .i_clk      (i_uart_clk),
        .i_rst      (uart_rst),
        .i_valid    (bit_valid),
        .i_bit      (bit_in),
        .i_byte     (byte_ended),
        .i_broken   (broken),
        .i_silence  (silence),
        .o_request  (o_request),
        .o_transfer (o_transfer),
        .o_write    (o_write),
        .o_text     (text_asked),
        .o_counts   (counts_asked),
        .o_address  (o_address),
        .o_data     (o_data),
        .o_bit      (request_bit),
        .i_repeat   (repeat_bit),
        .i_answered (o_answered)
    );

    // The padding above the fields.
    wire unused = &{1'b0, s_axis_tdata};

endmodule

`default_nettype wire

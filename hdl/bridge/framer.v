// framer: frames of results, and answers to requests, as bits for the line
//
// All frames have the same header; the bytes are in docs/wire.md. Whatever is sent is chosen bit by bit by
// the section, the number of its byte, and the place in the byte.
//
// A frame of results holds those that came while the one before was on the line, 255 at most:
// few under little load, so that none waits, many under a high one, so that the line carries results and
// not headers. It ends with a scan, and before a result before which some were lost. Results are counted
// while the CRC of the frame before is sent, so that the line does not wait for that.

`default_nettype none

module framer #(
    parameter         BITS       = 18, // of a result
    parameter         PLACE_BITS = 5,  // of BITS - 1
    parameter [255:0] IDENTITY   = 256'd0
) (
    input  wire            i_clk,
    input  wire            i_rst,
    input  wire            i_overrun,   // flags of the core, in this clock domain
    input  wire            i_saturated,

    // FIFO
    output wire            o_look,
    output wire            o_ahead,
    output wire            o_read,
    input  wire            i_available,
    input  wire            i_met,
    input  wire [BITS+1:0] i_word,

    // Loss, in the core's clock domain; stands while a marked word is in the FIFO
    input  wire [15:0]     i_lost,
    output wire            o_gap_taken, // changes when it has been taken

    // Answers
    input  wire            i_answer,    // there is one
    input  wire            i_identify,  // it is the identity, else status and data
    input  wire            i_told,      // or, in its place, other bytes
    output wire [4:0]      o_place,     // which byte
    input  wire [7:0]      i_byte,      // before its first bit is taken
    input  wire [1:0]      i_status,
    input  wire [31:0]     i_data,
    input  wire            i_request,   // bit of the request, which an answer repeats
    output wire            o_repeat,    // the next one
    output wire            o_answered,

    // uart_transmitter
    output wire            o_active,
    output wire            o_bit,
    input  wire            i_take,
    input  wire [2:0]      i_place,
    input  wire            i_between
);

    localparam [7:0] SYNC          = 8'hA5;
    localparam [7:0] KIND_RESULTS  = 8'h43; // C
    localparam [7:0] KIND_ANSWER   = 8'h41; // A
    localparam [7:0] KIND_IDENTITY = 8'h49; // I

    localparam [1:0] REST = 2'd0; // nothing is sent; results are counted, as in CRC
    localparam [1:0] HEAD = 2'd1; // header; of an answer all but its CRC
    localparam [1:0] DATA = 2'd2; // results, and zeros up to a whole byte
    localparam [1:0] CRC  = 2'd3;

    localparam [31:0] LAST_PLACE = BITS - 1;
    localparam [7:0]  MOST       = 8'd255; // results of a frame

    reg  [1:0]            section_r;
    reg                   answers_r;   // the frame is an answer
    reg  [5:0]            byte_r;      // of the section
    reg  [PLACE_BITS-1:0] place_r;     // of the next bit in its result
    reg  [1:0]            wait_r;      // clocks for the word of the place `ahead`
    reg  [7:0]            count_r;     // results of the frame
    reg                   last_r;      // the last of them is a scan's last
    reg                   gap_r;       // some were lost before the first of them
    reg                   gap_taken_r;
    reg  [15:0]           lost_r;      // before them, since reset
    reg  [7:0]            sequence_r;  // of the frame; goes round while it is sent
    reg  [23:0]           index_r;     // of the first result in its scan; likewise
    reg                   carry_r;

    wire rests   = section_r == REST;
    wire head    = section_r == HEAD;
    wire data    = section_r == DATA;
    wire crc_now = section_r == CRC;

    // Results of the next frame

    wire first  = count_r == 8'd0;
    wire is_gap = i_word[BITS+1];
    wire counts = rests || crc_now;
    wire looks  = counts && wait_r[1];
    wire takes  = i_available && !last_r && count_r != MOST && (first || !is_gap);
    wire begins = looks && !takes && !first;

    assign o_look      = counts;
    assign o_ahead     = looks && takes;
    assign o_gap_taken = gap_taken_r;

    // Bits of the frame. Two numbers go round while they are sent, and come back with what they are next:
    // the sequence number with 1 more, the index with the results of the frame more. So they need neither
    // a multiplexer nor a wide adder.

    wire [4:0]   place       = {byte_r[1:0], i_place};
    wire         word_0      = byte_r[5:2] == 4'd0;
    wire         word_1      = byte_r[5:2] == 4'd1;
    wire         is_sequence = head && word_0 && byte_r[1:0] == 2'd2;
    wire         is_index    = head && word_1 && byte_r[1:0] != 2'd0 && !answers_r;
    wire         round       = is_sequence ? sequence_r[0] : index_r[0] && !gap_r;
    wire         addend      = is_index && byte_r[1:0] == 2'd1 && count_r[i_place];
    wire         sum         = round ^ addend ^ carry_r;

    wire [7:0]   kind        = !answers_r ? KIND_RESULTS : i_identify ? KIND_IDENTITY : KIND_ANSWER;
    wire [7:0]   flags       = answers_r ? {2'd0, i_identify ? 2'd0 : i_status, 1'd0, i_saturated, i_overrun, 1'd0} :
        {4'd0, gap_r, i_saturated, i_overrun, last_r};
    wire [31:0]  bits_0      = {flags, {8{round}}, kind, SYNC};
    wire         bit_1       = answers_r ? i_request : byte_r[1:0] == 2'd0 ? count_r[i_place] : round;
    // From byte 8 on.
    wire [255:0] identity    = {IDENTITY[191:0], IDENTITY[255:192]};
    wire         told        = i_told ? i_byte[i_place] : identity[{byte_r[4:2], place}];
    wire         bit_2       = !answers_r ? lost_r[place[3:0]] : i_identify ? told : i_data[place];
    wire         head_bit    = word_0 ? bits_0[place] : word_1 ? bit_1 : bit_2;

    // Past the last result the place of the word is another one's.
    wire [(1<<PLACE_BITS)-1:0] result;
    wire            data_bit    = !i_met && result[place_r];
    wire            last_place  = place_r == LAST_PLACE[PLACE_BITS-1:0];
    wire            crc_bit;

    assign result[BITS-1:0] = i_word[BITS-1:0];
    generate
        if (BITS < (1 << PLACE_BITS)) begin : gen_rest
            assign result[(1<<PLACE_BITS)-1:BITS] = {((1<<PLACE_BITS)-BITS){1'b0}};
        end
    endgenerate

    wire [5:0] head_bytes = !answers_r ? 6'd10 : i_identify ? 6'd40 : 6'd12;
    // Of the section; in REST it means nothing.
    wire       ends       = i_between && (head ? byte_r == head_bytes : data ? i_met : byte_r[2]);
    wire       data_ends  = data && i_between && i_met;

    assign o_place    = {byte_r[4:3] - 2'd1, byte_r[2:0]}; // from byte 8 on
    assign o_active   = !rests;
    assign o_bit      = crc_now ? crc_bit : head ? head_bit : data_bit;
    assign o_read     = i_take && data && last_place && !i_met;
    assign o_repeat   = i_take && head && word_1 && answers_r;
    assign o_answered = crc_now && ends && answers_r;

    crc32 crc (
        .i_clk   (i_clk),
        .i_clear (rests || (head && byte_r == 6'd0)), // not of the first byte
        .i_shift (i_take),
        .i_bits  (!crc_now),
        .i_bit   (o_bit),
        .o_bit   (crc_bit)
    );

    // Each register has one condition that clears it: its reset input takes that for nothing.
    always @(posedge i_clk) begin
        if (i_rst || !counts || looks) begin
            wait_r <= 2'd0;
        end else begin
            wait_r <= wait_r + 2'd1;
        end

        if (i_rst || data_ends) begin
            count_r <= 8'd0;
            last_r  <= 1'b0;
            gap_r   <= 1'b0;
        end else if (o_ahead) begin
            count_r <= count_r + 8'd1;
            last_r  <= i_word[BITS];
            gap_r   <= gap_r || is_gap;
        end
        if (i_rst) begin
            gap_taken_r <= 1'b0;
            lost_r      <= 16'd0;
        end else if (o_ahead && is_gap) begin
            gap_taken_r <= !gap_taken_r;
            lost_r      <= i_lost;
        end

        if (!data) begin
            place_r <= {PLACE_BITS{1'b0}};
        end else if (i_take) begin
            place_r <= last_place ? {PLACE_BITS{1'b0}} : place_r + 1'b1;
        end
        if (i_rst || ends) begin
            byte_r <= 6'd0;
        end else if (i_take && i_place == 3'd7) begin
            byte_r <= byte_r + 6'd1;
        end

        if (i_take) begin
            carry_r <= is_sequence || is_index ? (round && addend) || (carry_r && (round || addend)) : word_0;
        end
        if (i_rst) begin
            sequence_r <= 8'd0;
        end else if (i_take && is_sequence) begin
            sequence_r <= {sum, sequence_r[7:1]};
        end
        if (i_rst) begin
            index_r <= 24'd0;
        end else if (i_take && is_index) begin
            index_r <= {sum && !last_r, index_r[23:1]};
        end

        if (rests) begin
            answers_r <= i_answer;
        end
        if (i_rst) begin
            section_r <= REST;
        end else if (rests) begin
            section_r <= i_answer || begins ? HEAD : REST;
        end else if (ends) begin
            section_r <= head && !answers_r ? DATA : crc_now ? REST : CRC;
        end
    end

endmodule

`default_nettype wire

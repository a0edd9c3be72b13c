// framer: frames of results, and answers to requests, as bits for the line
//
// The bytes of each frame are in docs/wire.md. All bits of a frame come from one place, chosen by the
// section and a counter; nothing is kept twice.
//
// A frame of results holds those that came while the one before was on the line, FRAME_RESULTS at most:
// few under little load, so that none waits, many under a high one, so that the line carries results and
// not headers. It ends with a scan, and before a result before which some were lost. Results are counted
// while the CRC of the frame before is sent, so that the line does not wait for that.

`default_nettype none

module framer #(
    parameter         BITS          = 18, // of a result
    parameter         FRAME_RESULTS = 255,
    parameter [255:0] IDENTITY      = 256'd0
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
    input  wire [23:0]     i_gap_index,
    input  wire [23:0]     i_gap_lost,
    output wire            o_gap_taken, // changes when it has been taken

    // Answers
    input  wire            i_answer,    // there is one
    input  wire            i_identify,  // it is the identity, else status and data
    input  wire [7:0]      i_tag,
    input  wire [1:0]      i_status,
    input  wire [31:0]     i_data,
    output wire            o_answered,

    // uart_transmitter
    output wire            o_active,
    output wire            o_bit,
    input  wire            i_take,
    input  wire            i_between
);

    localparam [7:0] SYNC         = 8'hA5;
    localparam [7:0] KIND_RESULTS = 8'h43; // C
    localparam [7:0] KIND_ANSWER  = 8'h41; // A
    localparam [7:0] KIND_IDENTITY = 8'h49; // I

    localparam [1:0] REST = 2'd0; // nothing is sent; results are counted, as in CRC
    localparam [1:0] HEAD = 2'd1; // header, or a whole answer
    localparam [1:0] DATA = 2'd2; // results, and zeros up to a whole byte
    localparam [1:0] CRC  = 2'd3;

    localparam [8:0] RESULTS_HEAD_BITS  = 9'd88;
    localparam [8:0] ANSWER_HEAD_BITS   = 9'd80;
    localparam [8:0] IDENTITY_HEAD_BITS = 9'd296;
    localparam [8:0] CRC_BITS           = 9'd32;
    localparam [31:0] LAST_BIT          = BITS - 1;
    localparam [31:0] MOST              = FRAME_RESULTS;

    reg  [1:0]  section_r;
    reg         answers_r;  // the frame is an answer
    reg  [8:0]  bit_r;      // of the section, or of the result
    reg  [7:0]  sequence_r;
    reg  [1:0]  wait_r;     // clocks for the word of the place `ahead`
    reg  [7:0]  count_r;    // results of the frame
    reg         last_r;     // the last of them is a scan's last
    reg  [23:0] index_r;    // of the first of them in its scan
    reg  [23:0] lost_r;     // before it, since reset
    reg         gap_taken_r;

    // Results of the next frame

    wire counts  = section_r == REST || section_r == CRC;
    wire looks   = counts && wait_r == 2'd2;
    wire is_gap  = i_word[BITS+1];
    wire first   = count_r == 8'd0;
    wire takes   = i_available && !last_r && count_r != MOST[7:0] && (first || !is_gap);
    wire rests   = section_r == REST;
    wire begins  = rests && looks && !takes && !first;

    assign o_look      = counts;
    assign o_ahead     = looks && takes;
    assign o_gap_taken = gap_taken_r;

    // Bits of the frame

    wire         head     = section_r == HEAD;
    wire         data     = section_r == DATA;
    wire         crc_now  = section_r == CRC;
    wire [7:0]   kind     = !answers_r ? KIND_RESULTS : i_identify ? KIND_IDENTITY : KIND_ANSWER;
    wire [31:0]  common   = {5'd0, i_saturated, i_overrun, last_r && !answers_r, sequence_r, kind, SYNC};
    wire [55:0]  results  = {lost_r, index_r, count_r};
    wire [47:0]  answer   = {i_data, 6'd0, i_status, i_tag};
    wire [263:0] identity = {IDENTITY, i_tag};
    wire [8:0]   body_bit = bit_r - 9'd32;
    wire         is_common = bit_r < 9'd32;
    wire         crc_bit;
    wire         head_bit = is_common ? common[bit_r[4:0]] :
        !answers_r ? results[body_bit[5:0]] :
        i_identify ? identity[body_bit] : answer[body_bit[5:0]];
    wire [BITS+1:0] word_unused = i_word >> bit_r;
    wire         data_bit = !i_met && word_unused[0];
    wire [8:0]   head_bits = !answers_r ? RESULTS_HEAD_BITS :
        i_identify ? IDENTITY_HEAD_BITS : ANSWER_HEAD_BITS;
    wire         head_ends = head && i_between && bit_r == head_bits;
    wire         data_ends = data && i_between && i_met;
    wire         crc_ends  = crc_now && i_between && bit_r == CRC_BITS;
    wire         is_last_bit = data && bit_r == LAST_BIT[8:0];

    assign o_active   = !rests;
    assign o_bit      = crc_now ? crc_bit : head ? head_bit : data_bit;
    assign o_read     = i_take && is_last_bit && !i_met;
    assign o_answered = crc_ends && answers_r;

    crc32 crc (
        .i_clk   (i_clk),
        .i_clear (rests || (head && bit_r < 9'd8)), // not of the first byte
        .i_shift (i_take),
        .i_bits  (!crc_now),
        .i_bit   (o_bit),
        .o_bit   (crc_bit)
    );

    always @(posedge i_clk) begin
        wait_r <= counts && !looks ? wait_r + 2'd1 : 2'd0;
        if (o_ahead) begin
            count_r <= count_r + 8'd1;
            last_r  <= i_word[BITS];
            if (is_gap) begin
                index_r     <= i_gap_index;
                lost_r      <= i_gap_lost;
                gap_taken_r <= !gap_taken_r;
            end
        end

        if (i_take) begin
            bit_r <= is_last_bit ? 9'd0 : bit_r + 9'd1;
        end
        case (section_r)
            REST: begin
                bit_r <= 9'd0;
                if (i_answer || begins) begin
                    answers_r <= i_answer;
                    section_r <= HEAD;
                end
            end
            HEAD: begin
                if (head_ends) begin
                    bit_r     <= 9'd0;
                    section_r <= answers_r ? CRC : DATA;
                end
            end
            DATA: begin
                if (data_ends) begin
                    bit_r     <= 9'd0;
                    section_r <= CRC;
                    // The next frame's first result, unless some are lost before it.
                    index_r   <= last_r ? 24'd0 : index_r + {16'd0, count_r};
                    count_r   <= 8'd0;
                    last_r    <= 1'b0;
                end
            end
            default: begin
                if (crc_ends) begin
                    section_r  <= REST;
                    sequence_r <= sequence_r + 8'd1;
                end
            end
        endcase

        if (i_rst) begin
            section_r   <= REST;
            sequence_r  <= 8'd0;
            count_r     <= 8'd0;
            last_r      <= 1'b0;
            index_r     <= 24'd0;
            lost_r      <= 24'd0;
            gap_taken_r <= 1'b0;
        end
    end

endmodule

`default_nettype wire

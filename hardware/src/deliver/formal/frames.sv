// The words of a histogram's frames: row, code period, and what reaches the memories with and
// behind a word.
module spec_frame_words #(
    parameter ROW_BITS = 1
) (
    input wire i_clk,
    input wire i_rst,
    output wire first,
    output wire ends_frame,
    output reg [6*ROW_BITS-1:0] rows_before,
    output wire holds
);
    localparam PERIOD_BITS = `PERIODS > 2 ? $clog2(`PERIODS) : 1;
    // Of the design's control.
    wire run_seen, first_seen, ahead_is_last_seen, row_is_last_seen, period_is_last_seen;
    wire come_first_seen, held_first_seen, added_first_seen;
    wire [ROW_BITS-1:0] row_seen, ahead_seen;
    wire [6*ROW_BITS-1:0] rows_seen;
    wire [PERIOD_BITS-1:0] period_seen;
    wire [5:1] firsts_seen;

    // Row of the present word, and code period of its frame, counted from 0.
    reg running;
    reg began;
    reg [ROW_BITS-1:0] row;
    wire ends_period = began & row == `ROWS - 1;
    always @(posedge i_clk) begin
        running <= i_rst ? 1'b0 : 1'b1;
        began <= i_rst ? 1'b0 : running;
        row <= i_rst | ends_period ? 0 : row + began;
    end
    wire period_holds;
    generate
        if (`PERIODS == 1) begin : single
            assign first = 1'b1;
            assign ends_frame = ends_period;
            assign period_holds = 1'b1;
        end else begin : several
            reg [PERIOD_BITS-1:0] period;
            reg last_before;
            assign first = period == 0;
            assign ends_frame = ends_period & period == `PERIODS - 1;
            always @(posedge i_clk) begin
                period <= i_rst | ends_frame ? 0 : period + ends_period;
                last_before <= i_rst ? 1'b0 : period == `PERIODS - 1;
            end
            // The design counts up to all ones, from where these are as many code periods.
            wire [PERIOD_BITS-1:0] period_in_design = period - `PERIODS;
            assign period_holds = (period <= `PERIODS - 1)
                & (began | period == 0)
                & (period_seen == period_in_design)
                & (period_is_last_seen == last_before)
                & (row == 0 | last_before == (period == `PERIODS - 1));
        end
    endgenerate

    // The same of the words before it.
    reg [5:1] firsts;
    always @(posedge i_clk) begin
        rows_before <= i_rst ? 0 : {rows_before, row};
        firsts <= i_rst ? 5'h1f : {firsts, first};
    end
    assign holds = (run_seen == running)
        & (row_seen == row)
        & (row <= `ROWS - 1)
        & (running | ~began)
        & (began | row == 0)
        // The counter is a clock ahead.
        & (ahead_seen == (~began | ends_period ? 0 : row + 1))
        & (ahead_is_last_seen == (ahead_seen == `ROWS - 1))
        & (row_is_last_seen == (row == `ROWS - 1))
        & (first_seen == first) & period_holds
        & (rows_seen == rows_before)
        & (firsts_seen == firsts)
        & (`TAKES_TURNS | come_first_seen == firsts[2])
        & (held_first_seen == firsts[3])
        & (added_first_seen == firsts[5]);
endmodule

// Words count from the second clock after reset on: a row each, so many rows a code period, so many
// code periods a frame, one behind the other without a pause. Row and first code period reach the
// memories after a fixed number of clocks.
module prove_scan (
    `INPUTS
);
    `DESIGN
    wire holds;
    spec_frame_words #(.ROW_BITS(`ROW_BITS)) words (
        .i_clk(i_clk), .i_rst(i_rst), .first(), .ends_frame(), .rows_before(), .holds(holds)
    );
    `HOLDS_BEHIND(1, holds)
    `REACHES(clocks == 1 & held)
endmodule

// Two memories: a frame that ends when all rows of the one before have been taken, or with the
// clock that takes the last, is read whole: each row once, in order, detector 0's, then detector
// 1's, ..., tlast at the last and nowhere else. Any other is lost, whole. Memories change places
// with each frame that is read, and with no other. o_overrun rises if and only if a frame is lost,
// and stays.
//
// One memory: behind a whole frame its rows come one a clock, in order, tlast at the last and
// nowhere else. One that comes while another waits that is not taken is lost. o_overrun rises if
// and only if a row is lost, and stays until reset.
module prove_stream (
    `INPUTS
);
    `DESIGN
    localparam ALL = `ROWS * `DETECTORS;
    // Clocks from the end of a frame to its first row; and from a word that comes of a single
    // memory until its row may be taken.
    localparam TO_ROW = 4;
    localparam TO_COME = 3;
    localparam BITS = $clog2(ALL + TO_ROW + 2);

    wire first, ends_frame, words_hold, stream_holds;
    wire [6*`ROW_BITS-1:0] rows_before;
    spec_frame_words #(.ROW_BITS(`ROW_BITS)) words (
        .i_clk(i_clk), .i_rst(i_rst), .first(first), .ends_frame(ends_frame),
        .rows_before(rows_before), .holds(words_hold)
    );

    // Of the design's control.
    wire half_seen, come_half_seen, held_half_seen, write_half_seen, room_seen, reads_seen;
    wire read_is_last_seen, go_seen, shows_seen, follows_seen;
    wire [6:1] halves_seen;
    wire [`ROW_BITS-1:0] read_row_seen;
    wire [`DETECTORS-1:0] detector_seen;
    wire [2:0] out_seen, last_out_seen;
    wire [3*`DETECTORS-1:0] detector_out_seen;
    wire [TO_COME:1] wholes_seen;
    wire [TO_COME-1:0] lasts_seen;

    reg lost;
    wire loses;
    always @(posedge i_clk) lost <= i_rst ? 1'b0 : lost | loses;
    genvar d, s;
    generate
        if (`TAKES_TURNS) begin : two_memories
            // Rows of the frame that is read that are still to be taken, and clocks until the first
            // stands.
            reg [BITS-1:0] left;
            reg [2:0] pause;
            reg half;
            reg [6:1] halves;
            wire stands = left != 0 & pause == 0;
            wire taken = stands & m_axis_tready;
            wire free = left == 0 | (left == 1 & taken);
            wire is_read = ends_frame & free;
            assign loses = ends_frame & ~free;
            always @(posedge i_clk) begin
                left <= i_rst ? 0 : is_read ? ALL : left - taken;
                pause <= i_rst ? 0 : is_read ? TO_ROW : pause - (pause != 0);
                half <= i_rst ? 1'b0 : half ^ is_read;
                halves <= i_rst ? 0 : {halves, half};
            end
            // The row of the frame that is asked for, counted through all detectors.
            wire [BITS-1:0] asked = ALL - left + TO_ROW - pause;
            wire asks = left != 0 & asked < ALL;
            // Rows on their way out of the memories.
            wire [2:0] flies;
            wire [2:0] out_holds;
            wire [`DETECTORS-1:0] asked_holds;
            for (d = 0; d < `DETECTORS; d = d + 1) begin : asked_of
                wire other = ~asks | asked < d * `ROWS | asked >= (d + 1) * `ROWS;
                assign asked_holds[d] = (other | read_row_seen == asked - d * `ROWS)
                    & (other | read_is_last_seen == (asked == (d + 1) * `ROWS - 1))
                    & (`DETECTORS == 1 | other | detector_seen == 1 << d);
            end
            for (s = 0; s < 3; s = s + 1) begin : stage
                assign flies[s] =
                    left != 0 & pause <= TO_ROW - 1 - s & asked - (s + 1) < ALL;
                wire [`DETECTORS-1:0] detector_holds;
                for (d = 0; d < `DETECTORS; d = d + 1) begin : out_of
                    assign detector_holds[d] = `DETECTORS == 1 | ~flies[s]
                        | asked < d * `ROWS + s + 1 | asked >= (d + 1) * `ROWS + s + 1
                        | detector_out_seen[s*`DETECTORS +: `DETECTORS] == 1 << d;
                end
                assign out_holds[s] = (out_seen[s] == flies[s])
                    & (last_out_seen[s] == (flies[s] & asked - (s + 1) == ALL - 1))
                    & (&detector_holds);
            end
            assign stream_holds = (m_axis_tvalid == stands)
                & (~stands | m_axis_tlast == (left == 1))
                & (left <= ALL & (pause == 0 | left == ALL))
                & (pause <= TO_ROW)
                & (half_seen == half)
                & (halves_seen == halves)
                & (come_half_seen == halves[2])
                & (held_half_seen == halves[3])
                & (write_half_seen == halves[6])
                & (room_seen == ~stands)
                & (reads_seen == asks)
                & (asks | (read_row_seen == 0 & ~read_is_last_seen))
                & (`DETECTORS == 1 | asks | detector_seen == 1)
                & (&asked_holds) & (&out_holds)
                & (go_seen == (~stands | m_axis_tready))
                & (shows_seen == (go_seen & flies[2]));
        end else begin : one_memory
            // A whole frame is in the memory; its rows come some clocks behind the words that find
            // them.
            reg follows;
            reg [TO_COME:1] wholes;
            reg stands;
            reg is_last;
            wire comes = wholes[TO_COME];
            wire free = ~stands | m_axis_tready;
            assign loses = comes & ~free;
            wire [TO_COME:1] lasts;
            for (s = 1; s <= TO_COME; s = s + 1) begin : row
                assign lasts[s] = rows_before[(s-1)*`ROW_BITS +: `ROW_BITS] == `ROWS - 1;
            end
            always @(posedge i_clk) begin
                follows <= i_rst ? 1'b0 : follows | ends_frame;
                wholes <= i_rst ? 0 : {wholes, follows & first};
                stands <= i_rst ? 1'b0 : comes | ~free;
                is_last <= i_rst ? 1'b0 : comes & free ? lasts[TO_COME] : is_last;
            end
            assign stream_holds = (m_axis_tvalid == stands)
                & (m_axis_tlast == is_last)
                & (shows_seen == (comes & free))
                & (room_seen == ~stands)
                & (follows_seen == follows)
                & (wholes_seen == wholes)
                & (lasts_seen == lasts);
        end
    endgenerate
    wire holds = words_hold & stream_holds & (o_overrun == lost);
    `HOLDS_BEHIND(1, holds)
    `REACHES(clocks == 1 & held & loses)
endmodule

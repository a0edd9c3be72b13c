// result_accumulator: sums of so many scans, between sensor_top and a bridge whose line is slower than the core
//
// The sums of one scan after another stand in a memory, a word for each result; the last scan's leave, in
// the scan's order and with its tlast. So the stream behind it is that of a scan again, with wider counts,
// once in SCANS scans. A sum has the bits that SCANS counts need: it never overflows.
//
// A scan without RESULTS results, as after a reset that cut it, is left out, and the sum begins anew with
// the next one.
//
// Requires  m_axis_tready does not fall once it has risen, until the next reset (a bridge without
//           BACK_PRESSURE)
// Latency   4 clocks from a scan's last result at s_axis to its sum at m_axis

`default_nettype none

module result_accumulator #(
    parameter TDATA_BITS     = 24,
    parameter COUNT_BITS     = 18, // signed, from bit 0 on
    parameter MORE_FIRST_BIT = 0,
    parameter MORE_BITS      = 0,  // unsigned; 0: there are none
    parameter SCANS          = 2,
    parameter SCANS_BITS     = 1,  // of SCANS - 1: what a sum has more than a count
    parameter RESULTS        = 16, // of a scan
    parameter RESULTS_BITS   = 4,  // of RESULTS - 1
    // What a sum has: COUNT_BITS and MORE_BITS, each with SCANS_BITS more.
    parameter SUM_BITS       = 19
) (
    input  wire                  i_clk,
    input  wire                  i_rst,

    // Results of sensor_top
    input  wire [TDATA_BITS-1:0] s_axis_tdata,
    input  wire                  s_axis_tvalid,
    output wire                  s_axis_tready,
    input  wire                  s_axis_tlast,

    // Sums: the signed one from bit 0 on, the other one right above it
    output wire [SUM_BITS-1:0]   m_axis_tdata,
    output wire                  m_axis_tvalid,
    input  wire                  m_axis_tready,
    output wire                  m_axis_tlast
);

    localparam        SIGNED_BITS = COUNT_BITS + SCANS_BITS;
    localparam        HIGH_BITS   = MORE_BITS + SCANS_BITS;
    localparam [31:0] LAST_RESULT = RESULTS - 1;
    localparam [31:0] LAST_SCAN   = SCANS - 1;

    generate
        if (COUNT_BITS < 1 || COUNT_BITS > TDATA_BITS || MORE_BITS < 0 ||
            (MORE_BITS > 0 && MORE_FIRST_BIT + MORE_BITS > TDATA_BITS)) begin : gen_fields
            result_accumulator_needs_counts_and_MORE_BITS_within_TDATA_BITS stop ();
        end
        if (SUM_BITS != SIGNED_BITS + (MORE_BITS > 0 ? HIGH_BITS : 0)) begin : gen_sum
            result_accumulator_needs_SUM_BITS_of_the_fields_with_SCANS_BITS_more_each stop ();
        end
        if (SCANS < 2 || SCANS_BITS < 1 || SCANS_BITS > 16 || SCANS > (1 << SCANS_BITS)) begin : gen_scans
            result_accumulator_needs_SCANS_of_2_to_65536_and_their_bits stop ();
        end
        // A word is written four clocks after it was read.
        if (RESULTS < 4 || RESULTS_BITS > 14 || RESULTS > (1 << RESULTS_BITS)) begin : gen_results
            result_accumulator_needs_RESULTS_of_4_to_16384_and_their_bits stop ();
        end
    endgenerate

    // A result, its place and its scan: the place is read while they wait.
    reg                     valid_r;
    reg                     last_r;
    reg  [TDATA_BITS-1:0]   data_r;
    reg  [RESULTS_BITS-1:0] place_r;  // of the result in data_r
    reg  [SCANS_BITS-1:0]   scan_r;   // of the sum
    reg                     read_valid_r;
    reg                     read_last_r;
    reg  [TDATA_BITS-1:0]   read_data_r;
    reg  [RESULTS_BITS-1:0] read_place_r;
    reg                     read_first_r;  // of the scans
    reg                     read_leaves_r; // the sum is whole
    reg                     word_valid_r;
    reg                     word_last_r;
    reg  [TDATA_BITS-1:0]   word_data_r;
    reg  [RESULTS_BITS-1:0] word_place_r;
    reg                     word_first_r;
    reg                     word_leaves_r;
    reg                     sum_valid_r;
    reg                     sum_last_r;
    reg                     sum_leaves_r;
    reg  [RESULTS_BITS-1:0] sum_place_r;
    reg  [SUM_BITS-1:0]     sum_r;
    wire [SUM_BITS-1:0]     word;
    wire [SUM_BITS-1:0]     sum;

    wire is_last_place = place_r == LAST_RESULT[RESULTS_BITS-1:0];
    wire is_last_scan  = scan_r == LAST_SCAN[SCANS_BITS-1:0];

    assign s_axis_tready = m_axis_tready;
    assign m_axis_tdata  = sum_r;
    assign m_axis_tvalid = sum_leaves_r;
    assign m_axis_tlast  = sum_last_r;

    // The first scan's counts are the sum; its words are of any value.
    wire [SIGNED_BITS-1:0] count   = {{SCANS_BITS{word_data_r[COUNT_BITS-1]}}, word_data_r[COUNT_BITS-1:0]};
    wire [SIGNED_BITS-1:0] counted = word[SIGNED_BITS-1:0] & {SIGNED_BITS{!word_first_r}};

    assign sum[SIGNED_BITS-1:0] = counted + count;
    generate
        if (MORE_BITS > 0) begin : gen_more
            wire [HIGH_BITS-1:0] more  = {{SCANS_BITS{1'b0}}, word_data_r[MORE_FIRST_BIT +: MORE_BITS]};
            wire [HIGH_BITS-1:0] mores = word[SUM_BITS-1 -: HIGH_BITS] & {HIGH_BITS{!word_first_r}};

            assign sum[SUM_BITS-1 -: HIGH_BITS] = mores + more;
        end
    endgenerate

    bridge_memory #(
        .ADDRESS_BITS (RESULTS_BITS),
        .BITS         (SUM_BITS)
    ) memory (
        .i_write_clk     (i_clk),
        .i_write         (sum_valid_r),
        .i_write_address (sum_place_r),
        .i_data          (sum_r),
        .i_read_clk      (i_clk),
        .i_address       (place_r),
        .o_word          (word)
    );

    always @(posedge i_clk) begin
        valid_r <= s_axis_tvalid && m_axis_tready;
        last_r  <= s_axis_tlast;
        data_r  <= s_axis_tdata;
        if (valid_r) begin
            place_r <= last_r ? {RESULTS_BITS{1'b0}} : place_r + 1'b1;
        end
        if (valid_r && last_r) begin
            scan_r <= is_last_scan || !is_last_place ? {SCANS_BITS{1'b0}} : scan_r + 1'b1;
        end

        read_valid_r  <= valid_r;
        read_last_r   <= last_r;
        read_data_r   <= data_r;
        read_place_r  <= place_r;
        read_first_r  <= scan_r == {SCANS_BITS{1'b0}};
        read_leaves_r <= valid_r && is_last_scan;

        word_valid_r  <= read_valid_r;
        word_last_r   <= read_last_r;
        word_data_r   <= read_data_r;
        word_place_r  <= read_place_r;
        word_first_r  <= read_first_r;
        word_leaves_r <= read_leaves_r;

        sum_valid_r  <= word_valid_r;
        sum_last_r   <= word_last_r;
        sum_leaves_r <= word_leaves_r;
        sum_place_r  <= word_place_r;
        sum_r        <= sum;

        if (i_rst) begin
            valid_r       <= 1'b0;
            place_r       <= {RESULTS_BITS{1'b0}};
            scan_r        <= {SCANS_BITS{1'b0}};
            read_valid_r  <= 1'b0;
            read_leaves_r <= 1'b0;
            word_valid_r  <= 1'b0;
            word_leaves_r <= 1'b0;
            sum_valid_r   <= 1'b0;
            sum_leaves_r  <= 1'b0;
        end
    end

    // The padding of s_axis_tdata.
    wire unused = &{1'b0, s_axis_tdata, word_data_r};

endmodule

`default_nettype wire

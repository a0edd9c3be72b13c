// sample_counter: hits by sample of the chip, for a host that calibrates the sampler with dark counts
//
// A hit is a rising edge of a detector's level, as of the core. It waits in a few bits of its sample; one
// sample after another is added to its word in a memory. While a host reads, nothing is counted of any
// sample, so that all of them have counted for the same time; what waits is added first.
//
// Counts go round at 2^32, and are of any value at power-up: the host takes differences.

`default_nettype none

module sample_counter #(
    parameter DETECTORS  = 1,
    parameter SAMPLES    = 8, // of a chip, 2 or more
    parameter INVERT     = 0, // 1: a pulse is low
    parameter PLACE_BITS = 3  // of DETECTORS * SAMPLES - 1
) (
    input  wire                         i_clk,
    input  wire                         i_rst,
    input  wire [DETECTORS*SAMPLES-1:0] i_samples, // of a detector the earliest first

    // From and to another clock domain
    input  wire                         i_hold,    // nothing is counted
    output wire                         o_held,    // and what had been is in o_word
    input  wire [PLACE_BITS-1:0]        i_place,   // while held: sample, above it the detector
    output wire [31:0]                  o_word     // of that, two clocks later
);

    localparam        PLACES    = DETECTORS * SAMPLES;
    localparam        FEW_BITS  = PLACE_BITS + 1;
    localparam [31:0] LAST      = PLACES - 1;

    generate
        if (SAMPLES < 2 || PLACES > (1 << PLACE_BITS)) begin : gen_places
            sample_counter_needs_SAMPLES_of_2_or_more_and_PLACE_BITS_of_all stop ();
        end
    endgenerate

    reg  [31:0]           words [0:PLACES-1];
    reg  [PLACES-1:0]     level_r;
    reg  [DETECTORS-1:0]  before_r;  // the last sample of the word before
    reg  [PLACES-1:0]     hits_r;
    reg  [PLACES*FEW_BITS-1:0] few_r;
    reg  [PLACE_BITS-1:0] place_r;   // whose few hits are taken
    reg  [FEW_BITS-1:0]   taken_r;
    reg  [PLACE_BITS-1:0] write_r;   // where they go
    reg                   valid_r;
    reg  [31:0]           word_r;
    reg  [FEW_BITS:0]     settle_r;  // clocks since nothing was counted
    reg                   held_r;
    wire                  hold;
    wire [PLACES-1:0]     rising;

    integer place;

    assign o_held = held_r;
    assign o_word = word_r;

    bridge_sync #(
        .BITS (1)
    ) hold_sync (
        .i_clk   (i_clk),
        .i_async (i_hold),
        .o_sync  (hold)
    );

    genvar d;
    generate
        for (d = 0; d < DETECTORS; d = d + 1) begin : gen_detector
            assign rising[d*SAMPLES +: SAMPLES] = level_r[d*SAMPLES +: SAMPLES] &
                ~{level_r[d*SAMPLES +: SAMPLES-1], before_r[d]};
        end
    endgenerate

    initial begin
        for (place = 0; place < PLACES; place = place + 1) begin
            words[place] = 32'd0;
        end
    end

    wire [PLACE_BITS-1:0] read = held_r ? i_place : place_r;

    always @(posedge i_clk) begin
        level_r <= INVERT != 0 ? ~i_samples : i_samples;
        for (place = 0; place < DETECTORS; place = place + 1) begin
            before_r[place] <= level_r[place*SAMPLES + SAMPLES - 1];
        end
        hits_r <= rising & {PLACES{!hold}};

        for (place = 0; place < PLACES; place = place + 1) begin
            few_r[place*FEW_BITS +: FEW_BITS] <=
                (place_r == place[PLACE_BITS-1:0] ? {FEW_BITS{1'b0}} : few_r[place*FEW_BITS +: FEW_BITS]) +
                {{FEW_BITS-1{1'b0}}, hits_r[place]};
        end
        taken_r <= few_r[place_r*FEW_BITS +: FEW_BITS];
        write_r <= place_r;
        valid_r <= !held_r;
        word_r  <= words[read];
        if (valid_r) begin
            words[write_r] <= word_r + {{32-FEW_BITS{1'b0}}, taken_r};
        end
        place_r <= place_r == LAST[PLACE_BITS-1:0] ? {PLACE_BITS{1'b0}} : place_r + 1'b1;

        // All places have been taken at least once.
        settle_r <= !hold ? {FEW_BITS+1{1'b0}} : settle_r[FEW_BITS] ? settle_r : settle_r + 1'b1;
        held_r   <= hold && settle_r[FEW_BITS];
        if (i_rst) begin
            few_r    <= {PLACES*FEW_BITS{1'b0}};
            place_r  <= {PLACE_BITS{1'b0}};
            hits_r   <= {PLACES{1'b0}};
            valid_r  <= 1'b0;
            settle_r <= {FEW_BITS+1{1'b0}};
            held_r   <= 1'b0;
        end
    end

endmodule

`default_nettype wire

// counting: sample_counter against counts that are made here of the same samples
//
// Prints "right", or what is wrong. First samples at random, with a host that reads while they rest; then
// a hit of each sample in every four clocks, which a host interrupts as it likes.

`default_nettype none
`timescale 1ns / 1ps

module counting #(
    parameter DETECTORS  = 1,
    parameter SAMPLES    = 8,
    parameter INVERT     = 0,
    parameter PLACE_BITS = 3
);

    localparam PLACES = DETECTORS * SAMPLES;

    reg                   clk     = 1'b0;
    reg                   rst     = 1'b1;
    reg                   hold    = 1'b0;
    reg  [PLACES-1:0]     levels  = {PLACES{1'b0}};
    reg  [DETECTORS-1:0]  before  = {DETECTORS{1'b0}};
    reg  [PLACE_BITS-1:0] place   = {PLACE_BITS{1'b0}};
    wire                  held;
    wire [31:0]           word;

    integer counts [0:PLACES-1];
    integer first  [0:PLACES-1];
    integer seed = 7;
    integer d, k, n, round, least, most;

    sample_counter #(
        .DETECTORS  (DETECTORS),
        .SAMPLES    (SAMPLES),
        .INVERT     (INVERT),
        .PLACE_BITS (PLACE_BITS)
    ) dut (
        .i_clk     (clk),
        .i_rst     (rst),
        .i_samples (INVERT != 0 ? ~levels : levels),
        .i_hold    (hold),
        .o_held    (held),
        .i_place   (place),
        .o_word    (word)
    );

    always #4 clk = !clk;

    task wrong;
        input integer at;
        input integer is;
        input integer should;
        begin
            $display("sample %0d: %0d in place of %0d", at, is, should);
            $finish;
        end
    endtask

    // The next word, and the rising edges in it, one sample after another.
    task offer;
        input [PLACES-1:0] next;
        begin
            @(negedge clk);
            levels = next;
            for (d = 0; d < DETECTORS; d = d + 1) begin
                for (k = 0; k < SAMPLES; k = k + 1) begin
                    if (levels[d*SAMPLES+k] && !before[d]) begin
                        counts[d*SAMPLES+k] = counts[d*SAMPLES+k] + 1;
                    end
                    before[d] = levels[d*SAMPLES+k];
                end
            end
        end
    endtask

    // What the host reads is `first` then.
    task read;
        begin
            #3 hold = 1'b1;
            wait (held);
            for (n = 0; n < PLACES; n = n + 1) begin
                #1 place = n[PLACE_BITS-1:0];
                repeat (3) @(posedge clk);
                #1 first[n] = word;
            end
            #2 hold = 1'b0;
            repeat (5) @(posedge clk);
        end
    endtask

    initial begin
        for (n = 0; n < PLACES; n = n + 1) begin
            counts[n] = 0;
        end
        repeat (9) @(posedge clk);
        rst = 1'b0;
        for (round = 0; round < 20; round = round + 1) begin
            for (n = 0; n < 150 + round; n = n + 1) begin
                offer({$random(seed), $random(seed)} & (round % 3 == 0 ? {$random(seed), $random(seed)} : ~64'd0));
            end
            offer({PLACES{1'b0}});
            repeat (4) @(posedge clk);
            read;
            for (n = 0; n < PLACES; n = n + 1) begin
                if (first[n] != counts[n]) begin
                    wrong(n, first[n], counts[n]);
                end
            end
        end
        // Hits of even and of odd samples in turn, with pauses: as many of each.
        fork
            for (round = 0; round < 4000; round = round + 1) begin
                offer(round % 4 == 0 ? {PLACES{2'b01}} : round % 4 == 2 ? {PLACES{2'b10}} : {PLACES{1'b0}});
            end
            repeat (9) begin
                repeat (1 + ($random(seed) & 63)) @(posedge clk);
                read;
            end
        join
        repeat (4) @(posedge clk);
        read;
        least = first[0] - counts[0];
        most  = least;
        for (n = 0; n < PLACES; n = n + 1) begin
            // Fewer than were offered, and of all samples alike, but for one at the ends of each pause.
            if (first[n] - counts[n] < least) begin
                least = first[n] - counts[n];
            end
            if (first[n] - counts[n] > most) begin
                most = first[n] - counts[n];
            end
        end
        if (most >= 0 || most - least > 9) begin
            wrong(PLACES, most, least);
        end
        $display("right");
        $finish;
    end

endmodule

`default_nettype wire

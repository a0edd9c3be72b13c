// lane_delay: the reference of each sample, from the chip that the delay gives it
//
// Lanes below the delay take the previous chip, the others the present one. The mask of delayed
// lanes is a thermometer, so that no lane needs a comparator. When it is full, the next step
// delays by one chip more.
//
// Latency  1 clock from i_chips to o_window
// Rate     one chip per clock
// Made by  goldtof emit moving.toml (goldtof 0.1.0)

`default_nettype none

module lane_delay (
    // Clock and reset
    input  wire       i_clk,       // one chip per cycle
    input  wire       i_rst,       // synchronous, active high

    // Inputs
    input  wire [1:0] i_chips,     // reference chips, the present one in bit 0
    input  wire       i_step_ends, // the next clock is the last of a phase step
    input  wire       i_step_end,  // last clock of a phase step
    input  wire       i_start,     // a scan begins with the next clock

    // Outputs
    output wire       o_wrap,      // last clock of a step after which the delay grows by a chip more
    output reg  [7:0] o_window     // reference of each sample, bit 0 earliest
);

    // Delayed lanes after reset and at a scan's start
    localparam [6:0] DELAYED_LOAD = 7'h1f;

    reg  [6:0] delayed_r;      // lanes that take the previous chip
    reg        wraps_r;        // this clock ends a step, and the next delays by a chip more
    wire       wrap;           // the next step delays by a whole chip more
    wire [6:0] longer;         // delayed lanes of the next step
    wire [7:0] present;        // chip of a sample
    wire [7:0] previous;       // chip of a sample that is delayed
    wire [7:0] takes_previous; // samples that are delayed

    assign wrap = wraps_r;
    assign o_wrap = wrap;
    assign longer = {delayed_r[5:0], 1'b1};
    assign present = {8{i_chips[0]}};
    assign previous = {i_chips[0], {7{i_chips[1]}}};
    assign takes_previous = {1'b0, delayed_r[6:0]};

    always @(posedge i_clk) begin
        if (i_rst) begin
            delayed_r <= DELAYED_LOAD;
            wraps_r <= 1'b0;
            o_window <= 8'd0;
        end else begin
            o_window <= (takes_previous & previous) | (~takes_previous & present);
            wraps_r <= i_step_ends & delayed_r[6];
            if (wrap) begin
                delayed_r <= 7'd0;
            end else if (i_step_end) begin
                delayed_r <= longer;
            end
            if (i_start) begin
                delayed_r <= DELAYED_LOAD;
            end
        end
    end

endmodule

`default_nettype wire

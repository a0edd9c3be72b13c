// lane_delay: the reference of each sample, from the chip that the delay gives it
//
// Lanes below the delay take the previous chip, the others the present one. The mask of delayed
// lanes is a thermometer, so that no lane needs a comparator. When it is full, the next step
// delays by one chip more.
//
// Latency  1 clock from i_chips to o_window
// Made by  goldtof emit dual-view.toml (goldtof 0.1.0)

`default_nettype none

module lane_delay (
    input  wire       i_clk, i_rst,

    input  wire [1:0] i_chips,         // reference chips, the present one in bit 0
    input  wire       i_pre_last_chip, // the present chip is the last but one of a phase step
    input  wire       i_last_chip,     // last chip of a phase step

    output reg        o_wrap,          // last chip of a step; the next delays by a chip more
    output reg  [7:0] o_window         // reference of each sample, bit 0 earliest
);

    localparam [6:0] DELAYED_LOAD = 7'h00; // after reset and at a scan's start

    reg  [6:0] delayed_r; // lanes that take the previous chip

    wire [6:0] longer = {delayed_r[5:0], 1'b1}; // those of the next step
    wire [7:0] present = {8{i_chips[0]}}; // chip of each sample
    wire [7:0] previous = {i_chips[0], {7{i_chips[1]}}}; // chip of each sample that is delayed
    wire [7:0] takes_previous = {1'b0, delayed_r};

    always @(posedge i_clk)
        if (i_rst) begin
            {o_wrap, o_window} <= 0;
            delayed_r <= DELAYED_LOAD;
        end else begin
            o_window <= (takes_previous & previous) | (~takes_previous & present);
            o_wrap <= i_pre_last_chip & delayed_r[6];
            if (o_wrap) delayed_r <= 7'd0;
            else if (i_last_chip) delayed_r <= longer;
        end

endmodule

`default_nettype wire

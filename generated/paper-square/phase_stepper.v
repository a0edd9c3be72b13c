// phase_stepper: the reference, delayed by one more sample with every phase step
//
// Whole chips of delay come from holding the reference's generator, samples from the choice of
// a chip for each lane.
//
// Latency  2 clocks from i_chip to o_window
// Made by  goldtof emit paper-square.toml (goldtof 0.1.0)

`default_nettype none

module phase_stepper (
    input  wire       i_clk, i_rst,

    input  wire       i_chip,          // next chip of the reference
    input  wire       i_pre_last_chip, // the present chip is the last but one of a phase step
    input  wire       i_last_chip,     // last chip of a phase step

    output wire       o_advance,       // the reference generator goes on to its next chip
    output wire [7:0] o_window         // reference of each sample, bit 0 earliest
);

    wire [1:0] chips_chips;
    wire       lanes_wrap;

    chip_history chips (
        .i_clk (i_clk), .i_rst (i_rst), .i_chip (i_chip), .i_wrap (lanes_wrap),
        .o_advance (o_advance), .o_chips (chips_chips)
    );

    lane_delay lanes (
        .i_clk (i_clk), .i_rst (i_rst), .i_chips (chips_chips),
        .i_pre_last_chip (i_pre_last_chip), .i_last_chip (i_last_chip),
        .o_wrap (lanes_wrap), .o_window (o_window)
    );

endmodule

`default_nettype wire

// board_sampler: the samples of a detector in each chip, on Lattice iCE40
//
// S = 2 only: the pin has registers for both edges of one clock and no gear.
// Latency  one clock after the word's falling edge has passed

`default_nettype none

module board_sampler #(
    parameter PINS    = 1,                // 1
    parameter SAMPLES = 2                 // 2
) (
    input  wire               i_fast_clk, // not needed
    input  wire               i_clk,
    input  wire               i_rst,      // not needed
    input  wire [PINS-1:0]    i_pins,     // the comparator
    output reg  [SAMPLES-1:0] o_samples   // bit 0 earliest
);

    wire at_rise; // sample of the last rising edge
    wire at_fall; // sample of the falling edge after it

    SB_IO #(
        .PIN_TYPE (6'b0000_00), // no output; input registered at both edges
        .PULLUP   (1'b0)
    ) pad (
        .PACKAGE_PIN       (i_pins[0]),
        .LATCH_INPUT_VALUE (1'b0),
        .CLOCK_ENABLE      (1'b1),
        .INPUT_CLK         (i_clk),
        .OUTPUT_CLK        (1'b0),
        .OUTPUT_ENABLE     (1'b0),
        .D_OUT_0           (1'b0),
        .D_OUT_1           (1'b0),
        .D_IN_0            (at_rise),
        .D_IN_1            (at_fall)
    );

    always @(posedge i_clk) begin
        o_samples <= {at_fall, at_rise};
    end

endmodule

`default_nettype wire

// lfsr_check: whether SHIFTS shifts of an LFSR lead from FIRST to LAST; for simulation only
//
// A shift multiplies by x modulo the LFSR's polynomial, so that x^SHIFTS by squaring takes 64
// steps, however many the shifts. Bit k of the state reached is the chip k shifts later still:
// the parity of the bits of FIRST that x^(SHIFTS + k) has.
//
// Made by  goldtof emit image-glass.toml (goldtof 0.1.0)

`default_nettype none

`ifndef SYNTHESIS

module lfsr_check #(
    parameter             WIDTH  = 2,
    parameter [WIDTH-1:0] TAPS   = 2'd3, // bits of a state whose XOR comes in at the top
    parameter [63:0]      SHIFTS = 64'd0,
    parameter [WIDTH-1:0] FIRST  = 2'd1,
    parameter [WIDTH-1:0] LAST   = 2'd1
);

    function [WIDTH-1:0] times_x(input [WIDTH-1:0] a);
        times_x = {a[WIDTH-2:0], 1'b0} ^ ({WIDTH{a[WIDTH-1]}} & TAPS);
    endfunction

    function [WIDTH-1:0] times(input [WIDTH-1:0] a, input [WIDTH-1:0] b);
        integer place;
        begin
            times = {WIDTH{1'b0}};
            for (place = WIDTH - 1; place >= 0; place = place - 1)
                times = times_x(times) ^ ({WIDTH{b[place]}} & a);
        end
    endfunction

    function [WIDTH-1:0] shifted(input [63:0] shifts);
        integer place;
        reg [WIDTH-1:0] power;
        begin
            shifted = {WIDTH{1'b0}};
            power = {{(WIDTH - 1){1'b0}}, 1'b1};
            for (place = 63; place >= 0; place = place - 1) begin
                power = times(power, power);
                if (shifts[place]) power = times_x(power);
            end
            for (place = 0; place < WIDTH; place = place + 1) begin
                shifted[place] = ^(power & FIRST);
                power = times_x(power);
            end
        end
    endfunction

    // Elaboration works it out: a simulator that compiles has nothing to compile.
    localparam [WIDTH-1:0] REACHED = shifted(SHIFTS);

    initial
        if (REACHED != LAST) begin
            $display("%m: %0d shifts lead from %h to %h, not to %h", SHIFTS, FIRST, REACHED, LAST);
            $finish;
        end

endmodule

`endif

`default_nettype wire

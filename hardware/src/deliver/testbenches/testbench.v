// The design with goldtof's recorder beside it, for test_sensor.py.
// Made by  @MADE_BY@

`timescale 1ns / 1ps

`ifndef DESIGN
`define DESIGN @TOP@
`endif

module testbench (
@PORTS@
);
    `DESIGN sensor (
        @OWN@);

    goldtof_recorder #(@WIDTHS@) recorder (
        @CONNECTED@);
endmodule

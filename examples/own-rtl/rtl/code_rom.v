// Two neighbouring chips of the code, looked up in a table.
`include "sensor_defs.vh"

module code_rom (
    input  wire [4:0] chip,
    output wire       now,
    output wire       next
);
    localparam [0:`CODE_CHIPS-1] CODE = `CODE_TABLE;

    wire [4:0] following = (chip == `CODE_CHIPS - 1) ? 5'd0 : chip + 5'd1;

    assign now  = CODE[chip];
    assign next = CODE[following];
endmodule

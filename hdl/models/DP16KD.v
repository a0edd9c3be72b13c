// What goldtof's tests take for Lattice's DP16KD, a model of our own of the part of it that
// block_memory uses (ports as in FPGA-TN-02204, ECP5 memory
// usage guide): ports of equal width, of which A writes and B reads.
//
// B's address and the word that it names go through a register with CEB, and where REGMODE_B is
// OUTREG through another one with OCEB. A word that is read at the clock that writes it is wrong.

`default_nettype none

module DP16KD #(
    parameter DATA_WIDTH_A        = 18,
    parameter DATA_WIDTH_B        = 18,
    parameter REGMODE_A           = "NOREG",
    parameter REGMODE_B           = "NOREG",
    parameter WRITEMODE_A         = "NORMAL",
    parameter WRITEMODE_B         = "NORMAL",
    parameter CSDECODE_A          = "0b000",
    parameter CSDECODE_B          = "0b000",
    parameter RESETMODE           = "SYNC",
    parameter ASYNC_RESET_RELEASE = "SYNC",
    parameter GSR                 = "ENABLED"
) (
    input  wire CLKA, CEA, OCEA, WEA, RSTA, CSA2, CSA1, CSA0,
    input  wire ADA0, ADA1, ADA2, ADA3, ADA4, ADA5, ADA6,
    input  wire ADA7, ADA8, ADA9, ADA10, ADA11, ADA12, ADA13,
    input  wire DIA0, DIA1, DIA2, DIA3, DIA4, DIA5,
    input  wire DIA6, DIA7, DIA8, DIA9, DIA10, DIA11,
    input  wire DIA12, DIA13, DIA14, DIA15, DIA16, DIA17,
    output wire DOA0, DOA1, DOA2, DOA3, DOA4, DOA5,
    output wire DOA6, DOA7, DOA8, DOA9, DOA10, DOA11,
    output wire DOA12, DOA13, DOA14, DOA15, DOA16, DOA17,
    input  wire CLKB, CEB, OCEB, WEB, RSTB, CSB2, CSB1, CSB0,
    input  wire ADB0, ADB1, ADB2, ADB3, ADB4, ADB5, ADB6,
    input  wire ADB7, ADB8, ADB9, ADB10, ADB11, ADB12, ADB13,
    input  wire DIB0, DIB1, DIB2, DIB3, DIB4, DIB5,
    input  wire DIB6, DIB7, DIB8, DIB9, DIB10, DIB11,
    input  wire DIB12, DIB13, DIB14, DIB15, DIB16, DIB17,
    output wire DOB0, DOB1, DOB2, DOB3, DOB4, DOB5,
    output wire DOB6, DOB7, DOB8, DOB9, DOB10, DOB11,
    output wire DOB12, DOB13, DOB14, DOB15, DOB16, DOB17
);

    localparam FIRST = DATA_WIDTH_B == 18 ? 4 : DATA_WIDTH_B == 9 ? 3 : DATA_WIDTH_B == 4 ? 2 :
        DATA_WIDTH_B == 2 ? 1 : 0;

    wire [13:0] ada = {
        ADA13, ADA12, ADA11, ADA10, ADA9, ADA8,
        ADA7, ADA6, ADA5, ADA4, ADA3, ADA2,
        ADA1, ADA0
    };
    wire [13:0] adb = {
        ADB13, ADB12, ADB11, ADB10, ADB9, ADB8,
        ADB7, ADB6, ADB5, ADB4, ADB3, ADB2,
        ADB1, ADB0
    };
    wire [17:0] dia = {
        DIA17, DIA16, DIA15, DIA14, DIA13, DIA12,
        DIA11, DIA10, DIA9, DIA8, DIA7, DIA6,
        DIA5, DIA4, DIA3, DIA2, DIA1, DIA0
    };
    wire [13:0] write_row = ada >> FIRST;
    wire [13:0] read_row = adb >> FIRST;
    wire        writes = CEA && WEA && {CSA2, CSA1, CSA0} == 3'd0;
    // Of 18 bits each half has an enable, in the place of the address.
    wire [17:0] written = {{9{DATA_WIDTH_A != 18 || ADA1}}, {9{DATA_WIDTH_A != 18 || ADA0}}};

    reg  [DATA_WIDTH_B-1:0] words [0:(1 << (14 - FIRST))-1];
    reg  [DATA_WIDTH_B-1:0] read;
    reg  [DATA_WIDTH_B-1:0] out;
    wire [17:0] dob = {{(18 - DATA_WIDTH_B){1'b0}}, REGMODE_B == "OUTREG" ? out : read};

    assign {
        DOA17, DOA16, DOA15, DOA14, DOA13, DOA12,
        DOA11, DOA10, DOA9, DOA8, DOA7, DOA6,
        DOA5, DOA4, DOA3, DOA2, DOA1, DOA0
    } = 18'd0;
    assign {
        DOB17, DOB16, DOB15, DOB14, DOB13, DOB12,
        DOB11, DOB10, DOB9, DOB8, DOB7, DOB6,
        DOB5, DOB4, DOB3, DOB2, DOB1, DOB0
    } = dob;

    always @(posedge CLKA) begin
        if (writes) begin
            words[write_row[13-FIRST:0]] <=
                (words[write_row[13-FIRST:0]] & ~written[DATA_WIDTH_B-1:0]) |
                (dia[DATA_WIDTH_B-1:0] & written[DATA_WIDTH_B-1:0]);
        end
    end

    always @(posedge CLKB) begin
        if (CEB && {CSB2, CSB1, CSB0} == 3'd0) begin
            read <= words[read_row[13-FIRST:0]];
            if (writes && write_row == read_row) begin
                read <= ~dia[DATA_WIDTH_B-1:0];
            end
        end
        if (OCEB) begin
            out <= read;
        end
        if (RSTB) begin
            read <= {DATA_WIDTH_B{1'b0}};
            out <= {DATA_WIDTH_B{1'b0}};
        end
    end

    // What is not modelled.
    initial begin
        if (DATA_WIDTH_A != DATA_WIDTH_B || WEB || CSDECODE_A != "0b000" || CSDECODE_B != "0b000" ||
            RESETMODE != "SYNC" || ASYNC_RESET_RELEASE != "SYNC" || GSR != "DISABLED" ||
            REGMODE_A != "NOREG" || WRITEMODE_A != "NORMAL" || WRITEMODE_B != "NORMAL") begin
            $display("%m: this model has no such DP16KD");
            $finish;
        end
    end

    // Port B writes nothing, and port A is not read.
    wire unused = &{
        1'b0, OCEA, RSTA, ada, adb, dia, write_row, read_row, written,
        DIB0, DIB1, DIB2, DIB3, DIB4, DIB5, DIB6, DIB7, DIB8,
        DIB9, DIB10, DIB11, DIB12, DIB13, DIB14, DIB15, DIB16, DIB17
    };

endmodule

`default_nettype wire

// block_memory: words in block RAM, a port that writes, one that reads, and a register behind it
//
// Words have no value at power-up, and i_rst does not reach them. A word that is read at the clock
// that writes it is not to be relied on.
//
// Synthesizers infer a memory, whose read register is in the block RAM, and registers behind it.
// With the macro ECP5_BLOCK_RAM defined it is made of Lattice's DP16KD in place of that, whose own
// output register is the one behind: Yosys does not infer it, and without it a DP16KD takes 5.8 ns
// from the clock to its output.
//
// Latency  2 clocks from i_address to o_word, of clocks with i_read
//

`default_nettype none

module block_memory #(
    parameter WORDS        = 2,
    parameter ADDRESS_BITS = 1, // of the last word
    parameter BITS         = 1  // of a word
) (
    input  wire                    i_clk,

    // Port that writes
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read,          // both registers go on
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);

`ifdef ECP5_BLOCK_RAM
    localparam IS_OF_BLOCKS = WORDS <= 16384;
`else
    localparam IS_OF_BLOCKS = 0;
`endif

    generate
        if (!IS_OF_BLOCKS) begin : inferred
            // No word is used that is read at the clock that writes it.
            (* no_rw_check *)
            reg [BITS-1:0] words [0:WORDS-1];
            reg [BITS-1:0] read_r;
            reg [BITS-1:0] word_r;

            assign o_word = word_r;

            always @(posedge i_clk) begin
                if (i_write) words[i_write_address] <= i_data;
                if (i_read) begin
                    read_r <= words[i_address];
                    word_r <= read_r;
                end
            end
        end
`ifdef ECP5_BLOCK_RAM
        if (IS_OF_BLOCKS) begin : blocks
            // The widest words that a block has so many of, and the place of their address.
            localparam WIDTH = WORDS <= 1024 ? 18 : WORDS <= 2048 ? 9 : WORDS <= 4096 ? 4 :
                WORDS <= 8192 ? 2 : 1;
            localparam FIRST = WORDS <= 1024 ? 4 : WORDS <= 2048 ? 3 : WORDS <= 4096 ? 2 :
                WORDS <= 8192 ? 1 : 0;
            localparam BLOCKS = (BITS + WIDTH - 1) / WIDTH;

            wire [13:0] write_row = {{(14 - ADDRESS_BITS){1'b0}}, i_write_address};
            wire [13:0] read_row = {{(14 - ADDRESS_BITS){1'b0}}, i_address};
            // Below the address of 18 bits: both halves are written.
            wire [13:0] a = (write_row << FIRST) | {12'd0, {2{WIDTH == 18}}};
            wire [13:0] b = read_row << FIRST;
            wire [BLOCKS*WIDTH-1:0] data = {{(BLOCKS * WIDTH - BITS){1'b0}}, i_data};
            wire [BLOCKS*WIDTH-1:0] word_unused;
            genvar k;

            assign o_word = word_unused[BITS-1:0];

            for (k = 0; k < BLOCKS; k = k + 1) begin : block
                wire [17:0] d = {{(18 - WIDTH){1'b0}}, data[k*WIDTH +: WIDTH]};
                wire [17:0] q_unused;
                wire [17:0] qa_unused;

                assign word_unused[k*WIDTH +: WIDTH] = q_unused[WIDTH-1:0];

                DP16KD #(
                    .DATA_WIDTH_A(WIDTH), .DATA_WIDTH_B(WIDTH),
                    .REGMODE_A("NOREG"), .REGMODE_B("OUTREG"),
                    .WRITEMODE_A("NORMAL"), .WRITEMODE_B("NORMAL"),
                    .CSDECODE_A("0b000"), .CSDECODE_B("0b000"),
                    .RESETMODE("SYNC"), .ASYNC_RESET_RELEASE("SYNC"), .GSR("DISABLED")
                ) ram (
                    .CLKA(i_clk), .CEA(1'b1), .OCEA(1'b0), .WEA(i_write), .RSTA(1'b0),
                    .CSA2(1'b0), .CSA1(1'b0), .CSA0(1'b0),
                    .ADA0(a[0]), .ADA1(a[1]), .ADA2(a[2]), .ADA3(a[3]), .ADA4(a[4]),
                    .ADA5(a[5]), .ADA6(a[6]), .ADA7(a[7]), .ADA8(a[8]), .ADA9(a[9]),
                    .ADA10(a[10]), .ADA11(a[11]), .ADA12(a[12]), .ADA13(a[13]),
                    .DIA0(d[0]), .DIA1(d[1]), .DIA2(d[2]), .DIA3(d[3]), .DIA4(d[4]),
                    .DIA5(d[5]), .DIA6(d[6]), .DIA7(d[7]), .DIA8(d[8]), .DIA9(d[9]),
                    .DIA10(d[10]), .DIA11(d[11]), .DIA12(d[12]), .DIA13(d[13]), .DIA14(d[14]),
                    .DIA15(d[15]), .DIA16(d[16]), .DIA17(d[17]),
                    .DOA0(qa_unused[0]), .DOA1(qa_unused[1]), .DOA2(qa_unused[2]),
                    .DOA3(qa_unused[3]), .DOA4(qa_unused[4]), .DOA5(qa_unused[5]),
                    .DOA6(qa_unused[6]), .DOA7(qa_unused[7]), .DOA8(qa_unused[8]),
                    .DOA9(qa_unused[9]), .DOA10(qa_unused[10]), .DOA11(qa_unused[11]),
                    .DOA12(qa_unused[12]), .DOA13(qa_unused[13]), .DOA14(qa_unused[14]),
                    .DOA15(qa_unused[15]), .DOA16(qa_unused[16]), .DOA17(qa_unused[17]),
                    .CLKB(i_clk), .CEB(i_read), .OCEB(i_read), .WEB(1'b0), .RSTB(1'b0),
                    .CSB2(1'b0), .CSB1(1'b0), .CSB0(1'b0),
                    .ADB0(b[0]), .ADB1(b[1]), .ADB2(b[2]), .ADB3(b[3]), .ADB4(b[4]),
                    .ADB5(b[5]), .ADB6(b[6]), .ADB7(b[7]), .ADB8(b[8]), .ADB9(b[9]),
                    .ADB10(b[10]), .ADB11(b[11]), .ADB12(b[12]), .ADB13(b[13]),
                    .DIB0(1'b0), .DIB1(1'b0), .DIB2(1'b0), .DIB3(1'b0), .DIB4(1'b0),
                    .DIB5(1'b0), .DIB6(1'b0), .DIB7(1'b0), .DIB8(1'b0), .DIB9(1'b0),
                    .DIB10(1'b0), .DIB11(1'b0), .DIB12(1'b0), .DIB13(1'b0), .DIB14(1'b0),
                    .DIB15(1'b0), .DIB16(1'b0), .DIB17(1'b0),
                    .DOB0(q_unused[0]), .DOB1(q_unused[1]), .DOB2(q_unused[2]),
                    .DOB3(q_unused[3]), .DOB4(q_unused[4]), .DOB5(q_unused[5]),
                    .DOB6(q_unused[6]), .DOB7(q_unused[7]), .DOB8(q_unused[8]),
                    .DOB9(q_unused[9]), .DOB10(q_unused[10]), .DOB11(q_unused[11]),
                    .DOB12(q_unused[12]), .DOB13(q_unused[13]), .DOB14(q_unused[14]),
                    .DOB15(q_unused[15]), .DOB16(q_unused[16]), .DOB17(q_unused[17])
                );
            end
        end
`endif
    endgenerate

endmodule

`default_nettype wire

// bridge_memory: words in Lattice ECP5's DP16KD with a clock for each port and its output register
//
// Yosys infers a DP16KD without its output register, which takes 5.8 ns from the clock to the word.
//
// Latency  2 clocks of i_read_clk from i_address to o_word

`default_nettype none

module bridge_memory #(
    parameter ADDRESS_BITS = 10, // 14 at most
    parameter BITS         = 20  // of a word
) (
    // Port that writes
    input  wire                    i_write_clk,
    input  wire                    i_write,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [BITS-1:0]         i_data,

    // Port that reads
    input  wire                    i_read_clk,
    input  wire [ADDRESS_BITS-1:0] i_address,
    output wire [BITS-1:0]         o_word
);

    // The widest words that a block has so many of, and the place of their address.
    localparam WIDTH  = ADDRESS_BITS <= 10 ? 18 : ADDRESS_BITS <= 11 ? 9 : ADDRESS_BITS <= 12 ? 4 :
        ADDRESS_BITS <= 13 ? 2 : 1;
    localparam FIRST  = ADDRESS_BITS <= 10 ? 4 : 14 - ADDRESS_BITS;
    localparam BLOCKS = (BITS + WIDTH - 1) / WIDTH;

    wire [BLOCKS*WIDTH-1:0] data;
    wire [BLOCKS*WIDTH-1:0] word_unused;
    wire [13:0]             write_row;
    wire [13:0]             read_row;
    // Below the address of 18 bits: both halves are written.
    wire [13:0]             a = (write_row << FIRST) | {12'd0, {2{WIDTH == 18}}};
    wire [13:0]             b = read_row << FIRST;
    genvar                  k;

    assign o_word = word_unused[BITS-1:0];

    generate
        if (ADDRESS_BITS > 14) begin : gen_too_deep
            bridge_memory_holds_16384_words_at_most stop ();
        end
        if (ADDRESS_BITS < 14) begin : gen_row
            assign write_row = {{(14-ADDRESS_BITS){1'b0}}, i_write_address};
            assign read_row  = {{(14-ADDRESS_BITS){1'b0}}, i_address};
        end else begin : gen_whole_row
            assign write_row = i_write_address;
            assign read_row  = i_address;
        end
        if (BLOCKS * WIDTH > BITS) begin : gen_wider
            assign data = {{(BLOCKS*WIDTH-BITS){1'b0}}, i_data};
        end else begin : gen_full
            assign data = i_data;
        end

        for (k = 0; k < BLOCKS; k = k + 1) begin : gen_block
            wire [17:0] d;
            wire [17:0] q_unused;
            wire [17:0] qa_unused;

            if (WIDTH < 18) begin : gen_narrow
                assign d = {{(18-WIDTH){1'b0}}, data[k*WIDTH +: WIDTH]};
            end else begin : gen_wide
                assign d = data[k*WIDTH +: WIDTH];
            end
            assign word_unused[k*WIDTH +: WIDTH] = q_unused[WIDTH-1:0];

            DP16KD #(
                .DATA_WIDTH_A(WIDTH), .DATA_WIDTH_B(WIDTH),
                .REGMODE_A("NOREG"), .REGMODE_B("OUTREG"),
                .WRITEMODE_A("NORMAL"), .WRITEMODE_B("NORMAL"),
                .CSDECODE_A("0b000"), .CSDECODE_B("0b000"),
                .RESETMODE("SYNC"), .ASYNC_RESET_RELEASE("SYNC"), .GSR("DISABLED")
            ) ram (
                .CLKA(i_write_clk), .CEA(1'b1), .OCEA(1'b0), .WEA(i_write), .RSTA(1'b0),
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
                .CLKB(i_read_clk), .CEB(1'b1), .OCEB(1'b1), .WEB(1'b0), .RSTB(1'b0),
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
    endgenerate

endmodule

`default_nettype wire

// bridge_memory: words in block RAM with a clock for each port, as synthesizers infer it
//
// Latency  2 clocks of i_read_clk from i_address to o_word

`default_nettype none

module bridge_memory #(
    parameter ADDRESS_BITS = 10,
    parameter BITS         = 20 // of a word
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

    // No word is used that is read while it is written.
    (* no_rw_check *)
    reg [BITS-1:0] words [0:(1<<ADDRESS_BITS)-1];
    reg [BITS-1:0] read_r;
    reg [BITS-1:0] word_r;

    assign o_word = word_r;

    always @(posedge i_write_clk) begin
        if (i_write) begin
            words[i_write_address] <= i_data;
        end
    end

    always @(posedge i_read_clk) begin
        read_r <= words[i_address];
        word_r <= read_r;
    end

endmodule

`default_nettype wire

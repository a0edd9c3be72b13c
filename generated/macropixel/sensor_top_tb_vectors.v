// sensor_top_tb_vectors: values of a vector file, clock by clock
//
// A word of the file is {value, repeats}: value holds for repeats + 1 clocks. It changes with the
// rising edge of i_clk.
//
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

`default_nettype none

module sensor_top_tb_vectors #(
    parameter FILE      = "", // file for $readmemh
    parameter WORDS     = 1,  // words in it
    parameter W_REPEATS = 4,  // bits of repeats
    parameter W_VALUE   = 4   // bits of value
) (
    input  wire               i_clk,
    output wire [W_VALUE-1:0] o_value
);

    reg  [W_VALUE+W_REPEATS-1:0] words [0:WORDS-1];
    reg  [W_VALUE+W_REPEATS-1:0] word_r;
    reg  [W_REPEATS-1:0]         repeated_r;
    wire [W_REPEATS-1:0]         repeats;
    integer                      next;

    assign {o_value, repeats} = word_r;

    initial begin
        $readmemh(FILE, words);
        word_r     = words[0];
        repeated_r = {W_REPEATS{1'b0}};
        next       = 1;
    end

    // After the last word it stays: the testbench ends there.
    always @(posedge i_clk) begin
        if (repeated_r != repeats) begin
            repeated_r <= repeated_r + 1'b1;
        end else if (next < WORDS) begin
            word_r     <= words[next];
            repeated_r <= {W_REPEATS{1'b0}};
            next       <= next + 1;
        end
    end

endmodule

`default_nettype wire

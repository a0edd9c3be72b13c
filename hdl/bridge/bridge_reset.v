// bridge_reset: resets both clock domains together
//
// A reset that lasts one clock of i_clk reaches a slower clock, too: it is asked for until the other
// side says that it is in reset, and the core's side stays in reset until the other one is out of it.

`default_nettype none

module bridge_reset (
    input  wire i_clk,
    input  wire i_rst,      // on i_clk
    output wire o_rst,      // on i_clk, from a register: a clock behind i_rst
    input  wire i_uart_clk,
    output wire o_uart_rst  // on i_uart_clk
);

    // What power-up leaves here must not look like an answer.
    reg due_r         = 1'b0;
    reg ask_r         = 1'b0;
    reg answer_meta_r = 1'b0;
    reg answer_r      = 1'b0;
    reg uart_meta_r   = 1'b0;
    reg uart_rst_r    = 1'b0;
    reg hold_r        = 1'b1; // the core offers nothing before the first reset

    assign o_rst      = hold_r;
    assign o_uart_rst = uart_rst_r;

    always @(posedge i_clk) begin
        answer_meta_r <= uart_rst_r;
        answer_r      <= answer_meta_r;
        hold_r        <= i_rst || due_r || ask_r || answer_r;
        if (i_rst) begin
            due_r <= 1'b1;
        end else if (!ask_r && !answer_r) begin
            due_r <= 1'b0;
        end
        if (ask_r) begin
            ask_r <= !answer_r;
        end else begin
            ask_r <= due_r && !answer_r;
        end
    end

    always @(posedge i_uart_clk) begin
        uart_meta_r <= ask_r;
        uart_rst_r  <= uart_meta_r;
    end

endmodule

`default_nettype wire

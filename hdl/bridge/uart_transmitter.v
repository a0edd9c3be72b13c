// uart_transmitter: bits to a line, 8N1
//
// Takes a bit at a time. While i_active is high bytes follow one another without a gap, 10 bit times
// each; what gives the bits may only change i_active while o_between is high.

`default_nettype none

module uart_transmitter #(
    parameter CLOCKS_PER_BIT = 16,
    parameter TIMER_BITS     = 4  // of CLOCKS_PER_BIT - 1
) (
    input  wire       i_clk,
    input  wire       i_rst,
    input  wire       i_active,
    input  wire       i_bit,
    output wire       o_take,    // i_bit is taken with this edge
    output wire [2:0] o_place,   // of the next bit in its byte
    output wire       o_between, // no bit is due: between two bytes
    output wire       o_tx
);

    localparam [31:0] LAST = CLOCKS_PER_BIT - 1;

    // 0 to 7: that bit is due; 8: the stop bit is; 9: the start bit, if there is one.
    localparam [3:0] START = 4'd9;

    reg  [TIMER_BITS-1:0] timer_r;
    reg  [3:0]            slot_r;
    reg                   tx_r;

    wire tick = timer_r == {TIMER_BITS{1'b0}};

    assign o_between = slot_r[3];
    assign o_place   = slot_r[2:0];
    assign o_take    = tick && !o_between;
    assign o_tx      = tx_r;

    always @(posedge i_clk) begin
        timer_r <= tick ? LAST[TIMER_BITS-1:0] : timer_r - 1'b1;
        if (tick) begin
            if (!slot_r[3]) begin
                tx_r <= i_bit;
            end else begin
                tx_r <= !(slot_r[0] && i_active);
            end
            if (slot_r[3] && slot_r[0]) begin
                slot_r <= i_active ? 4'd0 : START;
            end else begin
                slot_r <= slot_r + 4'd1;
            end
        end
        if (i_rst) begin
            timer_r <= LAST[TIMER_BITS-1:0];
            slot_r  <= START;
            tx_r    <= 1'b1;
        end
    end

endmodule

`default_nettype wire

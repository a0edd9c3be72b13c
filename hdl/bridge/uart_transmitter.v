// uart_transmitter: bits to a line, 8N1
//
// Takes a bit at a time. While i_active is high bytes follow one another without a gap, 10 bit times
// each; what gives the bits may only change i_active while o_between is high.

`default_nettype none

module uart_transmitter #(
    parameter CLOCKS_PER_BIT = 16,
    parameter TIMER_BITS     = 4  // of CLOCKS_PER_BIT - 1
) (
    input  wire i_clk,
    input  wire i_rst,
    input  wire i_active,
    input  wire i_bit,
    output wire o_take,    // i_bit is taken with this edge
    output wire o_between, // the next bit is the first of a byte
    output wire o_tx
);

    localparam [3:0] START = 4'd0; // 1 to 8: data
    localparam [3:0] STOP  = 4'd9;
    localparam [31:0] LAST = CLOCKS_PER_BIT - 1;

    reg  [TIMER_BITS-1:0] timer_r;
    reg  [3:0]            slot_r;
    reg                   tx_r;

    wire tick = timer_r == {TIMER_BITS{1'b0}};

    assign o_between = slot_r == STOP || slot_r == START;
    assign o_take    = tick && !o_between;
    assign o_tx      = tx_r;

    always @(posedge i_clk) begin
        if (i_rst) begin
            timer_r <= LAST[TIMER_BITS-1:0];
            slot_r  <= START;
            tx_r    <= 1'b1;
        end else if (tick) begin
            timer_r <= LAST[TIMER_BITS-1:0];
            case (slot_r)
                START: begin
                    tx_r   <= !i_active;
                    slot_r <= i_active ? 4'd1 : START;
                end
                STOP: begin
                    tx_r   <= 1'b1;
                    slot_r <= START;
                end
                default: begin
                    tx_r   <= i_bit;
                    slot_r <= slot_r + 4'd1;
                end
            endcase
        end else begin
            timer_r <= timer_r - 1'b1;
        end
    end

endmodule

`default_nettype wire

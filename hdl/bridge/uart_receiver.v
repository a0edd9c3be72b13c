// uart_receiver: bits from a line, 8N1, each taken in its middle
//
// i_rx goes through two flip-flops. A byte without its stop bit is told by o_broken; a line that has
// been idle for 256 bit times by o_silence, which stays.

`default_nettype none

module uart_receiver #(
    parameter CLOCKS_PER_BIT = 16,
    parameter TIMER_BITS     = 4  // of CLOCKS_PER_BIT - 1
) (
    input  wire i_clk,
    input  wire i_rst,
    input  wire i_rx,
    output wire o_valid,   // o_bit is a bit of a byte
    output wire o_bit,
    output wire o_byte,    // a byte has ended, with its stop bit
    output wire o_broken,  // it has ended without
    output wire o_silence
);

    localparam [31:0] WHOLE = CLOCKS_PER_BIT - 1;
    // From the edge of the start bit to its middle; the edge is seen a clock late at most.
    localparam [31:0] HALF  = CLOCKS_PER_BIT / 2 - 1;

    // 0 to 7: in that bit; 8: in the stop bit; 15: in the start bit.
    localparam [3:0] START = 4'd15;

    reg                   meta_r;
    reg                   rx_r;
    reg                   busy_r;
    reg  [TIMER_BITS-1:0] timer_r;
    reg  [3:0]            slot_r;
    reg  [8:0]            idle_r; // bit times, the top bit: enough

    wire tick  = timer_r == {TIMER_BITS{1'b0}};
    wire start = !busy_r && !rx_r;
    wire stop  = busy_r && tick && slot_r[3] && !slot_r[0];

    assign o_bit     = rx_r;
    assign o_valid   = busy_r && tick && !slot_r[3];
    assign o_byte    = stop && rx_r;
    assign o_broken  = stop && !rx_r;
    assign o_silence = idle_r[8];

    always @(posedge i_clk) begin
        meta_r  <= i_rx;
        rx_r    <= meta_r;
        timer_r <= start ? HALF[TIMER_BITS-1:0] : tick ? WHOLE[TIMER_BITS-1:0] : timer_r - 1'b1;
        if (start) begin
            busy_r <= 1'b1;
        end else if (tick && slot_r[3]) begin
            // A start bit that is over by its middle was none.
            busy_r <= slot_r[0] && !rx_r;
        end
        if (!busy_r) begin
            slot_r <= START;
        end else if (tick) begin
            slot_r <= slot_r + 4'd1;
        end
        if (busy_r) begin
            idle_r <= 9'd0;
        end else if (tick && !o_silence) begin
            idle_r <= idle_r + 9'd1;
        end
        if (i_rst) begin
            busy_r  <= 1'b0;
            timer_r <= WHOLE[TIMER_BITS-1:0];
            slot_r  <= START;
            idle_r  <= 9'd0;
        end
    end

endmodule

`default_nettype wire

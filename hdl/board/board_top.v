// board_top: the whole design of a board, the same for every family
//
// Clock, samplers and laser cells are the family's (`board_clock`, `board_sampler`, `board_laser`);
// the numbers and what the scene needs are in board.vh, which `goldtof emit --board` writes.
// Reset   begins when the PLL loses its lock, and ends some clocks after it has it.
// Crossing  between the chip clock and the UART's: inside of uart_bridge, and nowhere else.

`include "board.vh"

`default_nettype none

module board_top (
    input  wire                                                      i_oscillator,
    input  wire                                                      i_rx,       // from the host
    output wire                                                      o_tx,       // to the host
    input  wire [`BOARD_DETECTORS*`BOARD_PINS_PER_DETECTOR-1:0]      i_detector, // comparators; a detector's pins side by side
    output wire [`BOARD_LASERS-1:0]                                  o_laser,
`ifdef BOARD_HELD
    output wire                                                      o_held,     // what the board has to have
`endif
    output wire                                                      o_led       // lit while no result has been lost
);

    wire                                                 fast_clk;
    wire                                                 clk;
    wire                                                 uart_clk;
    wire                                                 ready;
    wire                                                 rst;
    wire [`BOARD_DETECTORS*`BOARD_SAMPLES_PER_CHIP-1:0]  samples;
    wire [`BOARD_LASERS-1:0]                             chips;
    wire [`BOARD_TDATA_BITS-1:0]                         tdata;
    wire                                                 tvalid;
    wire                                                 tready;
    wire                                                 tlast;
    wire                                                 overrun;
    wire                                                 saturated;
    reg  [3:0]                                           reset_r = 4'hf; // high at power-up: the core needs a reset

    assign rst = reset_r[3];

    board_clock clocks (
        .i_oscillator (i_oscillator),
        .o_fast_clk   (fast_clk),
        .o_clk        (clk),
        .o_uart_clk   (uart_clk),
        .o_ready      (ready)
    );

    // Reset begins at once and ends with the clock.
    always @(posedge clk or negedge ready) begin
        if (!ready) begin
            reset_r <= 4'hf;
        end else begin
            reset_r <= {reset_r[2:0], 1'b0};
        end
    end

    genvar d;
    generate
        for (d = 0; d < `BOARD_DETECTORS; d = d + 1) begin : gen_detector
            board_sampler #(
                .PINS    (`BOARD_PINS_PER_DETECTOR),
                .SAMPLES (`BOARD_SAMPLES_PER_CHIP)
            ) sampler (
                .i_fast_clk (fast_clk),
                .i_clk      (clk),
                .i_rst      (rst),
                .i_pins     (i_detector[d*`BOARD_PINS_PER_DETECTOR +: `BOARD_PINS_PER_DETECTOR]),
                .o_samples  (samples[d*`BOARD_SAMPLES_PER_CHIP +: `BOARD_SAMPLES_PER_CHIP])
            );
        end
    endgenerate

    genvar m;
    generate
        for (m = 0; m < `BOARD_LASERS; m = m + 1) begin : gen_laser
            board_laser laser (
                .i_clk  (clk),
                .i_rst  (rst),
                .i_chip (chips[m]),
                .o_pin  (o_laser[m])
            );
        end
    endgenerate

    sensor_top sensor (
        .i_clk         (clk),
        .i_rst         (rst),
        .o_laser       (chips),
        .i_samples     (samples),
        .m_axis_tdata  (tdata),
        .m_axis_tvalid (tvalid),
        .m_axis_tready (tready),
        .m_axis_tlast  (tlast),
`ifdef BOARD_HAS_SATURATED
        .o_saturated   (saturated),
`endif
`ifdef BOARD_HAS_PEAK
        .o_peak_step   (),
        .o_peak_count  (),
        .o_peak_valid  (),
`endif
        .o_epoch       (),
        .o_overrun     (overrun)
    );

`ifndef BOARD_HAS_SATURATED
    assign saturated = 1'b0;
`endif

    uart_bridge #(
        .TDATA_BITS     (`BOARD_TDATA_BITS),
        .COUNT_BITS     (`BOARD_COUNT_BITS),
        .MORE_FIRST_BIT (`BOARD_MORE_FIRST_BIT),
        .MORE_BITS      (`BOARD_MORE_BITS),
        .BACK_PRESSURE  (`BOARD_BACK_PRESSURE),
        .CLOCKS_PER_BIT (`BOARD_UART_CLOCKS_PER_BIT),
        .IDENTITY       (`BOARD_IDENTITY)
    ) bridge (
        .i_clk         (clk),
        .i_rst         (rst),
        .i_uart_clk    (uart_clk),
        .i_rx          (i_rx),
        .o_tx          (o_tx),
        .s_axis_tdata  (tdata),
        .s_axis_tvalid (tvalid),
        .s_axis_tready (tready),
        .s_axis_tlast  (tlast),
        .i_overrun     (overrun),
        .i_saturated   (saturated)
    );

`ifdef BOARD_HELD
    assign o_held = `BOARD_HELD;
`endif

    assign o_led = `BOARD_LED_ON ? !overrun : overrun;

endmodule

`default_nettype wire

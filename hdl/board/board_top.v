// board_top: the whole design of a board, the same for every family
//
// Clock, samplers and laser cells are the family's (`board_clock`, `board_sampler`, `board_laser`);
// the numbers and what the scene needs are in board.vh, which `goldtof emit --board` writes.
// Reset   begins when the PLL loses its lock, and ends some clocks after it has it.
// Crossing  between the chip clock and the UART's: inside of uart_bridge and sample_counter, and nowhere else.

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
    (* keep *) // constraints name it
    wire                                                 clk;
    (* keep *)
    wire                                                 uart_clk;
    wire                                                 ready;
    wire                                                 rst;
    wire [`BOARD_DETECTORS*`BOARD_SAMPLES_PER_CHIP-1:0]  samples;
    wire [`BOARD_LASERS-1:0]                             chips;
    reg  [`BOARD_LASERS-1:0]                             chips_r;      // half-way to pins on another side
    wire [`BOARD_TDATA_BITS-1:0]                         tdata;        // to the bridge
    wire                                                 tvalid;
    wire                                                 tready;
    wire                                                 tlast;
`ifdef BOARD_ACCUMULATE
    wire [`BOARD_ACCUMULATE_TDATA_BITS-1:0]              scan_tdata;   // of one scan
    wire                                                 scan_tvalid;
    wire                                                 scan_tready;
    wire                                                 scan_tlast;
`endif
    wire                                                 overrun;
    wire                                                 saturated;
    reg  [3:0]                                           reset_r = 4'hf; // high at power-up: the core needs a reset

`ifdef BOARD_HAS_REGISTERS
    // AXI4-Lite, from the bridge to the core's registers
    wire [11:0]  awaddr;
    wire         awvalid;
    wire         awready;
    wire [31:0]  wdata;
    wire [3:0]   wstrb;
    wire         wvalid;
    wire         wready;
    wire [1:0]   bresp;
    wire         bvalid;
    wire         bready;
    wire [11:0]  araddr;
    wire         arvalid;
    wire         arready;
    wire [31:0]  rdata;
    wire [1:0]   rresp;
    wire         rvalid;
    wire         rready;
`endif

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

    always @(posedge clk) begin
        chips_r <= chips;
    end

    genvar m;
    generate
        for (m = 0; m < `BOARD_LASERS; m = m + 1) begin : gen_laser
            board_laser laser (
                .i_clk  (clk),
                .i_chip (chips_r[m]),
                .o_pin  (o_laser[m])
            );
        end
    endgenerate

    sensor_top sensor (
        .i_clk         (clk),
        .i_rst         (rst),
        .o_laser       (chips),
        .i_samples     (samples),
`ifdef BOARD_ACCUMULATE
        .m_axis_tdata  (scan_tdata),
        .m_axis_tvalid (scan_tvalid),
        .m_axis_tready (scan_tready),
        .m_axis_tlast  (scan_tlast),
`else
        .m_axis_tdata  (tdata),
        .m_axis_tvalid (tvalid),
        .m_axis_tready (tready),
        .m_axis_tlast  (tlast),
`endif
`ifdef BOARD_HAS_SATURATED
        .o_saturated   (saturated),
`endif
`ifdef BOARD_HAS_PEAK
        .o_peak_step   (),
        .o_peak_count  (),
        .o_peak_valid  (),
`endif
`ifdef BOARD_HAS_REGISTERS
        .s_axil_awaddr (awaddr),
        .s_axil_awvalid (awvalid),
        .s_axil_awready (awready),
        .s_axil_wdata (wdata),
        .s_axil_wstrb (wstrb),
        .s_axil_wvalid (wvalid),
        .s_axil_wready (wready),
        .s_axil_bresp (bresp),
        .s_axil_bvalid (bvalid),
        .s_axil_bready (bready),
        .s_axil_araddr (araddr),
        .s_axil_arvalid (arvalid),
        .s_axil_arready (arready),
        .s_axil_rdata (rdata),
        .s_axil_rresp (rresp),
        .s_axil_rvalid (rvalid),
        .s_axil_rready (rready),
`endif
        .o_epoch       (),
        .o_overrun     (overrun)
    );

`ifndef BOARD_HAS_SATURATED
    assign saturated = 1'b0;
`endif

`ifdef BOARD_ACCUMULATE
    result_accumulator #(
        .TDATA_BITS     (`BOARD_ACCUMULATE_TDATA_BITS),
        .COUNT_BITS     (`BOARD_ACCUMULATE_COUNT_BITS),
        .MORE_FIRST_BIT (`BOARD_ACCUMULATE_MORE_FIRST_BIT),
        .MORE_BITS      (`BOARD_ACCUMULATE_MORE_BITS),
        .SCANS          (`BOARD_ACCUMULATE),
        .SCANS_BITS     (`BOARD_ACCUMULATE_BITS),
        .RESULTS        (`BOARD_ACCUMULATE_RESULTS),
        .RESULTS_BITS   (`BOARD_ACCUMULATE_RESULTS_BITS),
        .SUM_BITS       (`BOARD_ACCUMULATE_SUM_BITS)
    ) sums (
        .i_clk         (clk),
        .i_rst         (rst),
        .s_axis_tdata  (scan_tdata),
        .s_axis_tvalid (scan_tvalid),
        .s_axis_tready (scan_tready),
        .s_axis_tlast  (scan_tlast),
        .m_axis_tdata  (tdata),
        .m_axis_tvalid (tvalid),
        .m_axis_tready (tready),
        .m_axis_tlast  (tlast)
    );
`endif

`ifdef BOARD_SAMPLE_COUNTS
    wire        hold;
    wire [9:0]  place;
    wire        held;
    wire [31:0] word;

    sample_counter #(
        .DETECTORS  (`BOARD_DETECTORS),
        .SAMPLES    (`BOARD_SAMPLES_PER_CHIP),
        .INVERT     (`BOARD_SAMPLE_INVERT),
        .PLACE_BITS (`BOARD_SAMPLE_PLACE_BITS)
    ) counter (
        .i_clk     (clk),
        .i_rst     (rst),
        .i_samples (samples),
        .i_hold    (hold),
        .o_held    (held),
        .i_place   (place[`BOARD_SAMPLE_PLACE_BITS-1:0]),
        .o_word    (word)
    );
`endif

    `BOARD_BRIDGE #(
        .TDATA_BITS     (`BOARD_TDATA_BITS),
        .COUNT_BITS     (`BOARD_COUNT_BITS),
        .COUNTS         (`BOARD_COUNTS),
        .COUNT_STRIDE   (`BOARD_COUNT_STRIDE),
        .MORE_FIRST_BIT (`BOARD_MORE_FIRST_BIT),
        .MORE_BITS      (`BOARD_MORE_BITS),
        .BACK_PRESSURE  (`BOARD_BACK_PRESSURE),
`ifdef BOARD_FIFO_ADDRESS_BITS
        .ADDRESS_BITS   (`BOARD_FIFO_ADDRESS_BITS),
`endif
        .CLOCKS_PER_BIT (`BOARD_UART_CLOCKS_PER_BIT),
`ifdef BOARD_TEXT
        .TEXT_BLOCKS    (`BOARD_TEXT_BLOCKS),
        .TEXT           (`BOARD_TEXT),
`endif
`ifdef BOARD_SAMPLE_COUNTS
        .SAMPLE_COUNTS  (`BOARD_SAMPLE_COUNTS),
`endif
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
        .i_saturated   (saturated),
`ifdef BOARD_SAMPLE_COUNTS
        .o_hold        (hold),
        .o_place       (place),
        .i_held        (held),
        .i_word        (word)
`else
        .o_hold        (),
        .o_place       (),
        .i_held        (1'b0),
        .i_word        (32'd0)
`endif
`ifdef BOARD_HAS_REGISTERS
        ,
        .m_axil_awaddr (awaddr),
        .m_axil_awvalid (awvalid),
        .m_axil_awready (awready),
        .m_axil_wdata (wdata),
        .m_axil_wstrb (wstrb),
        .m_axil_wvalid (wvalid),
        .m_axil_wready (wready),
        .m_axil_bresp (bresp),
        .m_axil_bvalid (bvalid),
        .m_axil_bready (bready),
        .m_axil_araddr (araddr),
        .m_axil_arvalid (arvalid),
        .m_axil_arready (arready),
        .m_axil_rdata (rdata),
        .m_axil_rresp (rresp),
        .m_axil_rvalid (rvalid),
        .m_axil_rready (rready)
`endif
    );

`ifdef BOARD_HELD
    assign o_held = `BOARD_HELD;
`endif

    assign o_led = `BOARD_LED_ON ? !overrun : overrun;

endmodule

`default_nettype wire

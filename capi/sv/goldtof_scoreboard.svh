// A scoreboard that stands beside a design and compares every output port with goldtof's
// reference model at every clock. IEEE 1800, DPI-C: include or compile this file, and
// link the C library (libgoldtof_c.so or .a).
//
//     goldtof_scoreboard #(.SCENE("scenes/quick.toml"), .SAMPLES(8), .TDATA(16)) scoreboard (
//         .i_clk, .i_rst, .i_samples, .m_axis_tready,
//         .o_laser, .o_epoch, .m_axis_tdata, .m_axis_tvalid, .m_axis_tlast, .o_overrun,
//         .o_saturated(1'b0), .o_peak_step(1'b0), .o_peak_count(1'b0), .o_peak_valid(1'b0));
//
// Clock 0 is the first rising edge of i_clk. A clock has the inputs that stand before its
// edge and the outputs after it, which are read at the edge of the next clock, all as a
// register would take them: drive the inputs with nonblocking assignments, as for the
// design itself. Comparison begins with the first clock at which i_rst is high.
//
// Of a design with registers, define GOLDTOF_REGISTERS before this file, and connect the ports of the
// AXI4-Lite slave, too. What a host drives while its valid is low may be unknown.
//
// At a mismatch the simulation ends with $fatal (or, with STOP = 0, goes on after one
// $error). At the end of the simulation the verdict is printed; one that is not a match is an
// $error, and an inconclusive one is not a match. `verdict()` gives it earlier.

`ifndef GOLDTOF_SCOREBOARD_SVH
`define GOLDTOF_SCOREBOARD_SVH

package goldtof_dpi;
    // What goldtof.h has of scenes and scoreboards.
    import "DPI-C" function chandle goldtof_scene_load(input string path);
    import "DPI-C" function int     goldtof_scene_set(input chandle scene, input string assignment);
    import "DPI-C" function void    goldtof_scene_free(input chandle scene);
    import "DPI-C" function string  goldtof_last_error();
    import "DPI-C" function chandle goldtof_scoreboard_new(
        input chandle scene, input int result_latency_clocks, input int peak_latency_clocks,
        input int is_idle_payload_free, input int batch_clocks);
    import "DPI-C" function int     goldtof_scoreboard_port(
        input chandle scoreboard, input string name, input int width);
    import "DPI-C" function int     goldtof_scoreboard_begin(input chandle scoreboard);
    // A call for each clock would take as long as a small design: words wait for one.
    localparam int MOST_WORDS = 64;
    typedef longint unsigned words_t [MOST_WORDS];
    import "DPI-C" function int     goldtof_scoreboard_words(
        input chandle scoreboard, input words_t words, input int count);
    import "DPI-C" function int     goldtof_scoreboard_verdict(input chandle scoreboard);
    import "DPI-C" function string  goldtof_scoreboard_report(input chandle scoreboard);
    import "DPI-C" function void    goldtof_scoreboard_free(input chandle scoreboard);

    localparam int MATCH        = 0;  // GOLDTOF_STATUS_OK
    localparam int MISMATCH     = 1;
    localparam int INVALID      = 2;
    localparam int INCONCLUSIVE = 3;
    localparam int INTERNAL     = 4;
    // What a host drives at an AXI4-Lite slave, the first port at the top.
    typedef struct packed {
        logic        rready;
        logic        arvalid;
        logic [11:0] araddr;
        logic        bready;
        logic        wvalid;
        logic [3:0]  wstrb;
        logic [31:0] wdata;
        logic        awvalid;
        logic [11:0] awaddr;
    } host_t;

endpackage

module goldtof_scoreboard #(
    parameter string SCENE = "",       // the scene's file
    // A key to override, "path.distance=5 m", or several, each on a line.
    parameter string SET   = "",
    // Widths of the ports, as in the manifest; 1 for those that the sensor does not have.
    parameter int LASERS     = 1,
    parameter int SAMPLES    = 8,      // of all detectors together
    parameter int TDATA      = 16,
    parameter int PEAK_STEP  = 1,
    parameter int PEAK_COUNT = 1,
    // Clocks from a group's last word to its first result, and from a scan's to its peak;
    // -1 for those of the design that goldtof emits; -2 of results for the design's own, which its
    // first result tells.
    parameter int RESULT_LATENCY = -1,
    parameter int PEAK_LATENCY   = -1,
    // What m_axis_tdata and m_axis_tlast hold while m_axis_tvalid is low is not compared.
    parameter bit IDLE_PAYLOAD_IS_FREE = 1,
    // Clocks that are compared at once: a mismatch is told up to as many clocks late, and those
    // of MOST_WORDS words; with 1 at its own clock.
    parameter int BATCH_CLOCKS = 4096,
    parameter bit STOP = 1
) (
    input logic                  i_clk,
    input logic                  i_rst,
    input logic [SAMPLES-1:0]    i_samples,
    input logic                  m_axis_tready,
    input logic [LASERS-1:0]     o_laser,
    input logic                  o_epoch,
    input logic [TDATA-1:0]      m_axis_tdata,
    input logic                  m_axis_tvalid,
    input logic                  m_axis_tlast,
    input logic                  o_overrun,
    input logic                  o_saturated,
    input logic [PEAK_STEP-1:0]  o_peak_step,
    input logic [PEAK_COUNT-1:0] o_peak_count,
    input logic                  o_peak_valid
`ifdef GOLDTOF_REGISTERS
    ,
    input logic [11:0]           s_axil_awaddr,
    input logic                  s_axil_awvalid,
    input logic                  s_axil_awready,
    input logic [31:0]           s_axil_wdata,
    input logic [3:0]            s_axil_wstrb,
    input logic                  s_axil_wvalid,
    input logic                  s_axil_wready,
    input logic [1:0]            s_axil_bresp,
    input logic                  s_axil_bvalid,
    input logic                  s_axil_bready,
    input logic [11:0]           s_axil_araddr,
    input logic                  s_axil_arvalid,
    input logic                  s_axil_arready,
    input logic [31:0]           s_axil_rdata,
    input logic [1:0]            s_axil_rresp,
    input logic                  s_axil_rvalid,
    input logic                  s_axil_rready
`endif
);
    import goldtof_dpi::*;

`ifdef GOLDTOF_REGISTERS
    localparam int BITS  = SAMPLES + LASERS + TDATA + PEAK_STEP + PEAK_COUNT + 8 + $bits(host_t) + 41;
`else
    localparam int BITS  = SAMPLES + LASERS + TDATA + PEAK_STEP + PEAK_COUNT + 8;
`endif
    localparam int WORDS = (BITS + 63) / 64;

    chandle          scoreboard = null;
    longint unsigned clocks = 0;      // rising edges so far
    bit              has_reset = 0;   // i_rst has been high
    bit              is_over = 0;     // nothing is compared any more
    bit              is_unknown = 0;  // changes when a bit is
    bit              has_unknown = 0;
    int              status = 0;
    words_t          waiting;         // of records, not yet handed over
    int              waiting_words = 0;
    int              waiting_clocks = 0;

    // Inputs of the clock whose outputs show now.
    logic               held_rst;
    logic [SAMPLES-1:0] held_samples;
    logic               held_tready;
`ifdef GOLDTOF_REGISTERS
    host_t              held_host;
`endif

    // The ports in the order in which they are told below, first at bit 0.
    wire [WORDS*64-1:0] record = (WORDS*64)'({
`ifdef GOLDTOF_REGISTERS
        s_axil_rvalid, s_axil_rresp, s_axil_rdata, s_axil_arready, s_axil_bvalid, s_axil_bresp,
        s_axil_wready, s_axil_awready, held_host,
`endif
        o_peak_valid, o_peak_count, o_peak_step, o_saturated, o_overrun,
        m_axis_tlast, m_axis_tready_of_clock, m_axis_tvalid, m_axis_tdata,
        held_samples, o_epoch, o_laser, held_rst});
    wire m_axis_tready_of_clock = held_tready;

    // All that has to be known of a clock after reset; an idle stream's payload may not be.
    wire is_idle = IDLE_PAYLOAD_IS_FREE && m_axis_tvalid === 1'b0;

    function automatic void stop(input string text);
        is_over = 1;
        $fatal(1, "goldtof_scoreboard: %s", text);
    endfunction

    function automatic void tell(input string name, input int width);
        if (goldtof_scoreboard_port(scoreboard, name, width) != 0) stop(goldtof_last_error());
    endfunction

    function automatic void begin_comparison();
        chandle scene;
        int     words;
        scene = goldtof_scene_load(SCENE);
        if (scene == null) begin
            stop(goldtof_last_error());
            return;
        end
        if (SET != "" && goldtof_scene_set(scene, SET) != 0) begin
            stop(goldtof_last_error());
            return;
        end
        scoreboard = goldtof_scoreboard_new(scene, RESULT_LATENCY, PEAK_LATENCY,
                                            int'(IDLE_PAYLOAD_IS_FREE), BATCH_CLOCKS);
        goldtof_scene_free(scene);
        if (scoreboard == null) begin
            stop(goldtof_last_error());
            return;
        end
        tell("i_rst", 1);
        tell("o_laser", LASERS);
        tell("o_epoch", 1);
        tell("i_samples", SAMPLES);
        tell("m_axis_tdata", TDATA);
        tell("m_axis_tvalid", 1);
        tell("m_axis_tready", 1);
        tell("m_axis_tlast", 1);
        tell("o_overrun", 1);
        tell("o_saturated", 1);
        tell("o_peak_step", PEAK_STEP);
        tell("o_peak_count", PEAK_COUNT);
        tell("o_peak_valid", 1);
`ifdef GOLDTOF_REGISTERS
        tell("s_axil_awaddr", 12);
        tell("s_axil_awvalid", 1);
        tell("s_axil_wdata", 32);
        tell("s_axil_wstrb", 4);
        tell("s_axil_wvalid", 1);
        tell("s_axil_bready", 1);
        tell("s_axil_araddr", 12);
        tell("s_axil_arvalid", 1);
        tell("s_axil_rready", 1);
        tell("s_axil_awready", 1);
        tell("s_axil_wready", 1);
        tell("s_axil_bresp", 2);
        tell("s_axil_bvalid", 1);
        tell("s_axil_arready", 1);
        tell("s_axil_rdata", 32);
        tell("s_axil_rresp", 2);
        tell("s_axil_rvalid", 1);
`endif
        words = goldtof_scoreboard_begin(scoreboard);
        if (words == 0) stop(goldtof_last_error());
        else if (words != WORDS) stop("the record is not what the library takes");
    endfunction

    // X and Z are lost on the way to C, so they are looked for here.
    function automatic void unknown(input string name);
        if (!has_unknown) begin
            has_unknown = 1;
            if (STOP) stop($sformatf("mismatch\nclock %0d: port %s is unknown (X or Z)", clocks - 1, name));
            else $error("goldtof_scoreboard: clock %0d: port %s is unknown (X or Z)", clocks - 1, name);
        end
    endfunction

    function automatic void look_for_unknown();
        if ($isunknown(held_rst))      unknown("i_rst");
        if ($isunknown(held_samples))  unknown("i_samples");
        if ($isunknown(held_tready))   unknown("m_axis_tready");
        if ($isunknown(o_laser))       unknown("o_laser");
        if ($isunknown(o_epoch))       unknown("o_epoch");
        if ($isunknown(m_axis_tvalid)) unknown("m_axis_tvalid");
        if ($isunknown(m_axis_tdata) && !is_idle) unknown("m_axis_tdata");
        if ($isunknown(m_axis_tlast) && !is_idle) unknown("m_axis_tlast");
        if ($isunknown(o_overrun))     unknown("o_overrun");
        if ($isunknown(o_saturated))   unknown("o_saturated");
        if ($isunknown(o_peak_step))   unknown("o_peak_step");
        if ($isunknown(o_peak_count))  unknown("o_peak_count");
        if ($isunknown(o_peak_valid))  unknown("o_peak_valid");
`ifdef GOLDTOF_REGISTERS
        if ($isunknown(held_host.awvalid)) unknown("s_axil_awvalid");
        if ($isunknown(held_host.awaddr) && held_host.awvalid) unknown("s_axil_awaddr");
        if ($isunknown(held_host.wvalid))  unknown("s_axil_wvalid");
        if ($isunknown({held_host.wdata, held_host.wstrb}) && held_host.wvalid) unknown("s_axil_wdata");
        if ($isunknown(held_host.bready))  unknown("s_axil_bready");
        if ($isunknown(held_host.arvalid)) unknown("s_axil_arvalid");
        if ($isunknown(held_host.araddr) && held_host.arvalid) unknown("s_axil_araddr");
        if ($isunknown(held_host.rready))  unknown("s_axil_rready");
        if ($isunknown({s_axil_awready, s_axil_wready})) unknown("s_axil_awready");
        if ($isunknown({s_axil_bvalid, s_axil_bresp}))   unknown("s_axil_bvalid");
        if ($isunknown(s_axil_arready))                  unknown("s_axil_arready");
        if ($isunknown({s_axil_rvalid, s_axil_rresp, s_axil_rdata})) unknown("s_axil_rvalid");
`endif
    endfunction

    function automatic void hand_over();
        if (waiting_words != 0)
            status = goldtof_scoreboard_words(scoreboard, waiting, waiting_words);
        waiting_words = 0;
        waiting_clocks = 0;
    endfunction

    initial begin_comparison();

    // What happens at each clock is kept apart from what hardly ever does, whose texts
    // cost simulators time.
    always @(posedge i_clk) begin
        if (!is_over && clocks != 0) begin
            if (held_rst === 1'b1) has_reset = 1;
            if (has_reset && $isunknown(record)) is_unknown = !is_unknown;
            for (int i = 0; i < WORDS; i++) begin
                waiting[waiting_words] = record[i*64 +: 64];
                waiting_words = waiting_words + 1;
                if (waiting_words == MOST_WORDS) hand_over();
            end
            waiting_clocks = waiting_clocks + 1;
            if (waiting_clocks >= BATCH_CLOCKS) hand_over();
        end
        clocks = clocks + 1;
        held_rst     <= i_rst;
        held_samples <= i_samples;
        held_tready  <= m_axis_tready;
`ifdef GOLDTOF_REGISTERS
        held_host    <= {s_axil_rready, s_axil_arvalid, s_axil_araddr, s_axil_bready, s_axil_wvalid,
                         s_axil_wstrb, s_axil_wdata, s_axil_awvalid, s_axil_awaddr};
`endif
    end

    always @(is_unknown) look_for_unknown();
    always @(status) if (status != 0) judge(status);

    bit has_told = 0;

    function automatic void judge(input int found);
        if (has_told) return;
        has_told = 1;
        if (found != MISMATCH)
            stop(goldtof_last_error());
        else if (STOP)
            stop(goldtof_scoreboard_report(scoreboard));
        else
            $error("goldtof_scoreboard: %s", goldtof_scoreboard_report(scoreboard));
    endfunction

    // What all clocks so far say: MATCH, MISMATCH or INCONCLUSIVE.
    function automatic int verdict();
        if (scoreboard == null) return INVALID;
        if (has_unknown) return MISMATCH;
        hand_over();
        return goldtof_scoreboard_verdict(scoreboard);
    endfunction

    final begin
        if (scoreboard == null)
            $display("goldtof_scoreboard: nothing was compared");
        else begin
            if (verdict() == MATCH)
                $display("goldtof_scoreboard: %s", goldtof_scoreboard_report(scoreboard));
            else if (!has_told && !has_unknown)
                $error("goldtof_scoreboard: %s", goldtof_scoreboard_report(scoreboard));
            goldtof_scoreboard_free(scoreboard);
            scoreboard = null;
        end
    end
endmodule

`endif

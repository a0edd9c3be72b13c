// A host that stops a sensor with registers, writes other settings, and asks for single scans; goldtof's
// scoreboard is bound to the design.

module testbench;
    logic        i_clk = 0;
    logic        i_rst = 1;
    logic [7:0]  i_samples = 0;
    logic        m_axis_tready = 1;
    logic [15:0] m_axis_tdata;
    logic        o_laser, o_epoch, m_axis_tvalid, m_axis_tlast, o_overrun;

    logic [11:0] s_axil_awaddr = 'x, s_axil_araddr = 0;
    logic [31:0] s_axil_wdata = 'x, s_axil_rdata;
    logic [3:0]  s_axil_wstrb = 'x;
    logic [1:0]  s_axil_bresp, s_axil_rresp;
    logic        s_axil_awvalid = 0, s_axil_wvalid = 0, s_axil_bready = 1, s_axil_arvalid = 0, s_axil_rready = 1;
    logic        s_axil_awready, s_axil_wready, s_axil_bvalid, s_axil_arready, s_axil_rvalid;

    always #4 i_clk = !i_clk;

    logic [31:0] random = 32'h1234_5678;
    int          results = 0;
    always @(posedge i_clk) begin
        random        <= {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        i_samples     <= random[7:0] & random[15:8] & random[23:16];
        m_axis_tready <= random[4:3] != 0;
        if (m_axis_tvalid && m_axis_tready) results <= results + 1;
    end

    sensor_top sensor (.*);

    // It drives between two rising edges, so that all that takes its levels there takes the same.
    task automatic write(input logic [11:0] address, input logic [31:0] data);
        s_axil_awaddr  = address;
        s_axil_wdata   = data;
        s_axil_wstrb   = 4'hf;
        s_axil_awvalid = 1;
        s_axil_wvalid  = 1;
        while (!(s_axil_awready && s_axil_wready)) @(negedge i_clk);
        @(negedge i_clk);
        s_axil_awvalid = 0;
        s_axil_wvalid  = 0;
        s_axil_awaddr  = 'x;
        s_axil_wdata   = 'x;
        while (!s_axil_bvalid) @(negedge i_clk);
        @(negedge i_clk);
    endtask

    task automatic read(input logic [11:0] address, output logic [31:0] data);
        s_axil_araddr  = address;
        s_axil_arvalid = 1;
        while (!s_axil_arready) @(negedge i_clk);
        @(negedge i_clk);
        s_axil_arvalid = 0;
        while (!s_axil_rvalid) @(negedge i_clk);
        data = s_axil_rdata;
        @(negedge i_clk);
    endtask

    logic [31:0] status;

    initial begin
        repeat (4) @(negedge i_clk);
        i_rst = 0;
        // Settings outlast the reset that ends the scene's scan.
        write(12'h018, 64);
        write(12'h01c, 5);
        write(12'h020, 35);
        write(12'h024, 11);
        i_rst = 1;
        repeat (2) @(negedge i_clk);
        i_rst = 0;
        write(12'h400, 0);
        for (int scan = 0; scan < 6; scan++) begin
            do read(12'h404, status); while (status[2:1] != 0);
            write(12'h018, 64 + scan);
            write(12'h400, 2);
        end
        do read(12'h404, status); while (status[2:1] != 0);
        repeat (100) @(negedge i_clk);
        read(12'h404, status);
        $display("%0d results, %0d scans", results, status[31:16]);
        $finish;
    end
endmodule

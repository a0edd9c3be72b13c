// AXI4-Lite (ARM IHI 0022, chapter B1), with a host that keeps its rules: address and data of a write are
// taken together, each request is answered once, and a response stays, unchanged, until it is taken. In
// reset all of it is 0. The settings stay as they are while codes run, whatever a host writes.
// (What the memory gives is anything, at any clock.)
module prove_registers (
    `INPUTS
);
    `DESIGN
    wire on_seen;
    wire [`SETTINGS_BITS-1:0] settings_seen;

    // What the host has at this clock, and had at the one before.
    reg began = 1'b0;
    reg reset_before;
    reg [47:0] asked_to_write;
    reg [11:0] asked_to_read;
    reg address_waits, data_waits, read_waits;
    reg kept;
    wire stays = began & ~reset_before;
    wire keeps = (~address_waits | (s_axil_awvalid & s_axil_awaddr == asked_to_write[47:36]))
        & (~data_waits | (s_axil_wvalid & {s_axil_wdata, s_axil_wstrb} == asked_to_write[35:0]))
        & (~read_waits | (s_axil_arvalid & s_axil_araddr == asked_to_read));
    wire keeps_so_far = kept & keeps;
    always @(posedge i_clk) begin
        began <= 1'b1;
        reset_before <= i_rst;
        asked_to_write <= {s_axil_awaddr, s_axil_wdata, s_axil_wstrb};
        asked_to_read <= s_axil_araddr;
        address_waits <= ~i_rst & s_axil_awvalid & ~s_axil_awready;
        data_waits <= ~i_rst & s_axil_wvalid & ~s_axil_wready;
        read_waits <= ~i_rst & s_axil_arvalid & ~s_axil_arready;
        kept <= i_rst | keeps_so_far;
    end

    // Requests that are to be answered.
    reg write_open, read_open;
    reg write_waits, read_response_waits;
    reg [1:0] write_response;
    reg [33:0] read_response;
    always @(posedge i_clk) begin
        if (i_rst) write_open <= 1'b0;
        else if (s_axil_awready) write_open <= 1'b1;
        else if (s_axil_bready) write_open <= 1'b0;
        if (i_rst) read_open <= 1'b0;
        else if (s_axil_arready) read_open <= 1'b1;
        else if (s_axil_rready) read_open <= 1'b0;
        write_waits <= s_axil_bvalid & ~s_axil_bready;
        read_response_waits <= s_axil_rvalid & ~s_axil_rready;
        write_response <= s_axil_bresp;
        read_response <= {s_axil_rresp, s_axil_rdata};
    end
    always @* assert (s_axil_awready == s_axil_wready);
    always @* if (stays & keeps_so_far & s_axil_awready) assert (s_axil_awvalid & s_axil_wvalid);
    always @* if (stays & keeps_so_far & s_axil_arready) assert (s_axil_arvalid);
    // One at a time, so that none is lost.
    always @* if (stays & s_axil_awready) assert (~write_open);
    always @* if (stays & s_axil_arready) assert (~read_open);
    always @* if (stays) assert (s_axil_bvalid == write_open);
    always @* if (stays) assert (s_axil_rvalid == read_open);
    always @* if (stays & write_waits) assert (s_axil_bresp == write_response);
    always @* if (stays & read_response_waits) assert ({s_axil_rresp, s_axil_rdata} == read_response);
    always @* assert (~s_axil_bresp[0] & ~s_axil_rresp[0]);
    always @* if (~stays) assert ({s_axil_awready, s_axil_bvalid, s_axil_bresp} == 0);
    always @* if (~stays) assert ({s_axil_arready, s_axil_rvalid, s_axil_rresp, s_axil_rdata} == 0);

    // Settings.
    reg was_on;
    reg [`SETTINGS_BITS-1:0] settings;
    always @(posedge i_clk) begin
        was_on <= on_seen;
        settings <= settings_seen;
    end
    always @* if (stays & was_on & on_seen) assert (settings_seen == settings);
    `REACHES(stays & keeps_so_far & s_axil_bvalid & s_axil_rvalid & on_seen)
endmodule

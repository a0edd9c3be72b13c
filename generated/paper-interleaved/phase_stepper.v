// phase_stepper: the reference, delayed by one more sample with every phase step
//
// Lanes below the delay take the previous chip, the others the present one. When all but the
// last lane are delayed, the next step holds the reference for one chip instead and starts
// again without delayed lanes. The mask of delayed lanes is a thermometer, so that no lane
// needs a comparator.
//
// Latency  1 clock from the chips to o_reference
// Rate     one chip per clock
// Made by  goldtof emit paper-interleaved.toml (goldtof 0.1.0)

`default_nettype none

module phase_stepper (
    // Clock and reset
    input  wire       i_clk,       // one chip per cycle
    input  wire       i_rst,       // synchronous, active high

    // Inputs
    input  wire       i_chip,      // next chip of the reference
    input  wire       i_step_end,  // last clock of a phase step

    // Outputs
    output wire       o_advance,   // the reference generator goes on to its next chip
    output reg  [7:0] o_reference  // reference of each sample, bit 0 earliest
);

    // Present chip after reset and at a scan's start
    localparam PRESENT_LOAD = 1'b1;

    // Previous chip after reset and at a scan's start
    localparam PREVIOUS_LOAD = 1'b0;

    // Delayed lanes after reset and at a scan's start
    localparam [6:0] DELAYED_LOAD = 7'd0;

    reg        present_r;  // reference chip of the present cycle
    reg        previous_r; // reference chip before it
    reg  [6:0] delayed_r;  // lanes that take the previous chip
    wire       wrap;       // the next step delays by a whole chip more

    assign wrap = i_step_end & delayed_r[6];
    assign o_advance = ~wrap;

    always @(posedge i_clk) begin
        if (i_rst) begin
            present_r <= PRESENT_LOAD;
            previous_r <= PREVIOUS_LOAD;
            delayed_r <= DELAYED_LOAD;
            o_reference <= 8'd0;
        end else begin
            o_reference <=
                ({1'b0, delayed_r} & {8{previous_r}})
                | (~{1'b0, delayed_r} & {8{present_r}});
            if (wrap) begin
                delayed_r <= 7'd0;
            end else if (i_step_end) begin
                delayed_r <= {delayed_r[5:0], 1'b1};
            end
            if (~wrap) begin
                present_r <= i_chip;
                previous_r <= present_r;
            end
        end
    end

endmodule

`default_nettype wire

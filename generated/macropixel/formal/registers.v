// Registers, for Yosys' techmap
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

`ifdef IN_RESET

// The proof `reset`: i_rst is high, and registers have any value.
(* techmap_celltype = "$sdff" *)
module resettable (CLK, SRST, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    parameter SRST_POLARITY = 1;
    parameter [WIDTH-1:0] SRST_VALUE = 0;
    input CLK;
    input SRST;
    input [WIDTH-1:0] D;
    output [WIDTH-1:0] Q;

    wire [WIDTH-1:0] next = SRST == SRST_POLARITY ? SRST_VALUE : D;
    \$anyseq #(.WIDTH(WIDTH)) any (.Y(Q));
    \$assert is_reset (.A(next == SRST_VALUE), .EN(1'b1));
endmodule

(* techmap_celltype = "$dff" *)
module other (CLK, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    input CLK;
    input [WIDTH-1:0] D;
    output [WIDTH-1:0] Q;

    \$anyseq #(.WIDTH(WIDTH)) any (.Y(Q));
    \$assert is_reset (.A(D == 0), .EN(1'b1));
endmodule

`else

// All other proofs: a register starts as reset leaves it.
(* techmap_celltype = "$sdff" *)
module resettable (CLK, SRST, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    parameter SRST_POLARITY = 1;
    parameter [WIDTH-1:0] SRST_VALUE = 0;
    input CLK;
    input SRST;
    input [WIDTH-1:0] D;
    (* init = SRST_VALUE *) output [WIDTH-1:0] Q;

    wire [WIDTH-1:0] next = SRST == SRST_POLARITY ? SRST_VALUE : D;
    \$dffe #(.WIDTH(WIDTH), .CLK_POLARITY(CLK_POLARITY), .EN_POLARITY(1)) register
        (.CLK(CLK), .EN(1'b1), .D(next), .Q(Q));
endmodule

(* techmap_celltype = "$dff" *)
module other (CLK, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    input CLK;
    input [WIDTH-1:0] D;
    (* init = {WIDTH{1'b0}} *) output [WIDTH-1:0] Q;

    \$dffe #(.WIDTH(WIDTH), .CLK_POLARITY(CLK_POLARITY), .EN_POLARITY(1)) register
        (.CLK(CLK), .EN(1'b1), .D(D), .Q(Q));
endmodule

`endif

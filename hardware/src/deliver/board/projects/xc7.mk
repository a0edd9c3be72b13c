# Bitstream of @TITLE@, with Vivado in batch mode. No free place and route that is known to work
# has the deserializers of this family.
# @MADE_BY@

VIVADO ?= vivado
YOSYS ?= yosys
LOADER ?= openFPGALoader

CORE = @CORE@
BOARD = @SOURCES@

board.bit: board.tcl board.xdc board.vh $(CORE) $(BOARD)
	$(VIVADO) -mode batch -nojournal -source board.tcl

# The same sources by Yosys, where there is no Vivado: a netlist of the family's cells.
board.json: $(CORE) $(BOARD) board.vh
	$(YOSYS) -q -p 'read_verilog -I. $(CORE) $(BOARD); synth_xilinx -family xc7 -top board_top; write_json $@'

load: board.bit
	$(LOADER) @LOADER@ $<

@SIMULATION@
clean:
	rm -rf simulated simulated_board board.json board.bit board.dcp timing.rpt utilization.rpt vivado.log

.PHONY: load clean

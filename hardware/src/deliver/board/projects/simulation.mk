
# The board in simulation, with Verilator: ./simulated_board says how it is used. Photons at its pins:
#   goldtof pulses scene.toml --out photons.bin
VERILATOR ?= verilator
OPTIMIZE ?= -O3
SIMULATED = $(BOARD) cells.v simulated_board.v

simulated_board: $(CORE) $(SIMULATED) simulated_board.cpp simulated_board.h board.vh
	$(VERILATOR) --cc --exe --build -O3 --x-assign fast -Wno-fatal -Wno-ASSIGNIN -Wno-lint -Wno-style -I. \
	    -MAKEFLAGS OPT_FAST=$(OPTIMIZE) \
	    --top-module simulated_board -Mdir simulated -o ../simulated_board -CFLAGS '@CFLAGS@' \
	    $(CORE) $(SIMULATED) simulated_board.cpp

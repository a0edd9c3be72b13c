# Clocks of xc7_board for a chip of 8 ns with S = 8: the bit clock has S / 2 periods in a chip, so
# its period is 2 T / S. The core's clock follows from it through BUFR, which Vivado knows.
# Pins and their standards are the board's; i_bit_clk needs a clock-capable pin.
create_clock -name bit_clk -period 2.000 [get_ports i_bit_clk]

# Reset is asynchronous, and ends with the core's clock.
set_false_path -from [get_ports i_rst]

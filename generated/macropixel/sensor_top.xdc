# Clock of sensor_top: one cycle is one chip of 8 ns. Pins and the timing of other ports
# are the board's.
#
# Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

create_clock -name i_clk -period 8 [get_ports i_clk]

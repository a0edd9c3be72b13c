// Verilog of sensor_top_tb, the top module last; paths are relative to this folder
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)
lfsr_check.v
block_memory.v
gold_generator.v
histogram_control.v
edge_detector.v
bin_bank.v
bin_adder.v
histogram_channel.v
sensor_top.v
sensor_top_tb_vectors.v
sensor_top_tb.v

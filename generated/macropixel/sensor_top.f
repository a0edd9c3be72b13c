// Verilog of sensor_top, the top module last; paths are relative to this folder
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)
lfsr_check.v
cell_combiner.v
gold_generator.v
scan_controller.v
chip_history.v
lane_delay.v
phase_stepper.v
edge_detector.v
accumulator.v
updown_correlator.v
detector_channel.v
result_stream.v
sensor_top.v

// Sizes of the sensor of scenes/quick.toml.
`ifndef SENSOR_DEFS_VH
`define SENSOR_DEFS_VH

`define SAMPLES      8        // of a chip
`define CODE_CHIPS   31
`define STEP_CHIPS   2500     // of a phase step
`define SCAN_STEPS   248

// Chips of the code, the first one on the left.
`define CODE_TABLE   31'b0000000010010100100111101010110

// Registers behind the adder, at least 1; more of them take a slower FPGA.
`ifndef ADDER_STAGES
`define ADDER_STAGES 1
`endif

`endif

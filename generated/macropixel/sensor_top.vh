// Bits of each port of sensor_top, for what is written round it
// Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

`ifndef SENSOR_TOP_VH
`define SENSOR_TOP_VH

`define SENSOR_TOP_I_CLK_BITS 1
`define SENSOR_TOP_I_RST_BITS 1
`define SENSOR_TOP_O_LASER_BITS 1
`define SENSOR_TOP_O_EPOCH_BITS 1
`define SENSOR_TOP_I_SAMPLES_BITS 16
`define SENSOR_TOP_M_AXIS_TDATA_BITS 16
`define SENSOR_TOP_M_AXIS_TVALID_BITS 1
`define SENSOR_TOP_M_AXIS_TREADY_BITS 1
`define SENSOR_TOP_M_AXIS_TLAST_BITS 1
`define SENSOR_TOP_O_OVERRUN_BITS 1

`endif

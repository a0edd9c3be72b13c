// Modules of sensor_top of which a proof drives the outputs: their ports and no more
// Made by  goldtof emit histogram.toml (goldtof 0.1.0)

`default_nettype none

`default_nettype wire

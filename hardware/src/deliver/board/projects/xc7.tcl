# Vivado, without a project: vivado -mode batch -source board.tcl
# @MADE_BY@

read_verilog [list @CORE@ @SOURCES@]
read_xdc board.xdc
synth_design -top board_top -part @PART@ -include_dirs [list .]
opt_design
place_design
phys_opt_design
route_design
write_checkpoint -force board.dcp
report_utilization -file utilization.rpt
report_timing_summary -file timing.rpt
# No bitstream is written where timing is not met.
if {[get_property SLACK [get_timing_paths -delay_type max]] < 0} {
    error "timing is not met: see timing.rpt"
}
write_bitstream -force board.bit

// The sensor of this folder, for simulators (-F) and goldtof (--filelist).
+incdir+include
+define+ADDER_STAGES=8     // a slow FPGA
rtl/range_top.v
-v rtl/code_rom.v
-y rtl                     /* correlator, stream_port */
+libext+.v+.sv

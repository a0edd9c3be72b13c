//! The emitted Verilog and everything that runs it.

// Tables of cases and models clock by clock are read from top to bottom.
#![allow(clippy::too_many_lines)]

mod boards;
mod boards_checked;
mod boards_simulated;
mod cosim_counts_are_the_verilogs;
mod cosim_finds_faults;
mod cosim_random_scenes_match;
mod cosim_says_what_it_exercised;
mod cosim_waveforms;
mod documents_commands_run;
mod flow_fusesoc_and_testbench;
mod flow_generated_files_are_current;
mod flow_lint_matrix;
mod flow_prefixed_designs;
mod formal_proofs;
mod grade_tells_stimuli_apart;
mod hdl_blocks_agree;
mod hdl_emit_limits_and_files;
mod hdl_emitted_text;
mod hdl_emitted_verilog;
mod hdl_generator_chips;
mod hdl_left_out_is_what_the_plan_says;
mod hdl_lint;
mod hdl_parts_left_out_change_nothing;
mod hdl_rust_simulation;
mod hdl_snapshots;
mod hdl_support;
mod histograms;
mod json_documents_keep_their_schemas;
mod outputs_stand_until_the_next_edge;
mod own_rtl;
mod own_rtl_is_one_circuit;
mod planted_faults;
mod reference_model_equals_a_clock_by_clock_model;
mod registers;
mod rows;
mod schema_takes_scenes;
mod tracking;

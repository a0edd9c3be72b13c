//! Scenes, codes and the command line.

// Tables of cases and models clock by clock are read from top to bottom.
#![allow(clippy::too_many_lines)]

mod builds_check_what_they_promise;
mod check_ends_with_one;
mod ci_reads_reports;
mod cli_keeps_its_contract;
mod code_correlations_obey_their_theorems;
mod code_gps_ca_chips_are_the_published_ones;
mod code_reports_name_the_published_properties;
mod documents_name_what_exists;
mod estimate_takes_recorded_counts;
mod explain_says_what_limits;
mod image_shows_what_the_array_sees;
mod modules_have_no_circles;
mod new_scenes_and_manual;
mod program;
mod report_is_one_sound_page;
mod run_measures_the_articles_sensor;
mod samplers_are_measured_and_told;
mod scene_malformed_scenes_are_refused;
mod scene_plan_names_every_part;
mod scene_standard_scenes_load;
mod scene_values_reach_the_scene;
mod shards_join_bit_for_bit;
mod sweep_goes_on_where_it_stopped;

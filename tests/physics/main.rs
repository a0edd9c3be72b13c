//! Photons, expected counts and estimates.

// Tables of cases and models clock by clock are read from top to bottom.
#![allow(clippy::too_many_lines)]

mod architectures_are_compared;
mod dark_counts_tell_widths;
mod errors_that_wrap;
mod estimate_against_photons;
mod estimate_model;
mod estimate_model_is_unbiased;
mod estimate_model_stays_finite;
mod expectations_hold;
mod expected_counts_of_pulses_that_just_do_not_merge;
mod fidelity_compares_all_three;
mod histogram_estimates;
mod histogram_walk_is_corrected;
mod lasers_and_detectors_as_they_are;
mod light_is_told_apart;
mod macropixels;
mod missed_peaks_are_predicted;
mod moving_paths_are_fitted;
mod optics_crosstalk;
mod optics_detector_statistics;
mod optics_fast_agrees_with_the_plain_loop;
mod optics_fast_counts_depend_on_the_seed_alone;
mod optics_fast_obeys_closed_forms;
mod optics_mean_response;
mod optics_members_agree_with_the_plain_loop;
mod optics_moving_paths;
mod optics_pulses_agree_with_the_plain_loop;
mod optics_sampled_pulses;
mod optics_streams;
mod optics_uneven_samples;
mod own_light_under_other_clocks;
mod parallel_steps_share_their_light;
mod parts_left_out_change_nothing;
mod passive_recharge;
mod recorded_counts_are_diagnosed;
mod recorded_histograms_are_diagnosed;
mod recorded_light_is_told_from_none;
mod recordings_are_replayed;
mod reproduce_makes_figures_and_claims;
mod search_invents_nothing;
mod sequential_tests_keep_their_promise;
mod simulate_agrees_with_theory;
mod sources_with_clocks_of_their_own;
mod stress_quick_cases_hold;
mod stress_results_depend_on_nothing_else;

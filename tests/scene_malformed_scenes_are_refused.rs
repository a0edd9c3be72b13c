//! Every malformed scene is refused with where, what, and what would be right.

use goldtof::scene::parse;

/// A right scene, from which each test departs in one place.
const SCENE: &str = r#"[clock]
chip_period = "8 ns"
samples_per_chip = 8

[[source]]
name = "laser"
code = { family = "gold", degree = 5 }
wavelength = "783 nm"
mean_power = "20 pW"

[[detector]]
name = "spad"
reference = "laser"
dead_time = "14 ns"

[[path]]
source = "laser"
detector = "spad"
distance = "3.2 m"

[scan]
integration = "20 us"
"#;

/// What the scene is refused with once `right` is replaced by `wrong`.
fn refusal(right: &str, wrong: &str) -> String {
    assert!(SCENE.contains(right), "the scene has no {right}");
    let scene = SCENE.replacen(right, wrong, 1);
    match parse("scenes/x.toml", &scene) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("accepted:\n{scene}"),
    }
}

#[test]
fn the_scene_itself_is_right() {
    if let Err(error) = parse("scenes/x.toml", SCENE) {
        panic!("{error}");
    }
}

#[test]
fn a_number_without_a_unit() {
    println!(
        "@@a_number_without_a_unit@@{}@@end@@",
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "14""#)
    );
}

#[test]
fn a_bare_number_where_a_unit_is_needed() {
    println!(
        "@@a_bare_number_where_a_unit_is_needed@@{}@@end@@",
        refusal(r#"dead_time = "14 ns""#, "dead_time = 14")
    );
}

#[test]
fn a_time_where_a_distance_is_needed() {
    println!(
        "@@a_time_where_a_distance_is_needed@@{}@@end@@",
        refusal(r#"distance = "3.2 m""#, r#"distance = "3 ns""#)
    );
}

#[test]
fn an_unknown_unit() {
    println!(
        "@@an_unknown_unit@@{}@@end@@",
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "14 nsec""#)
    );
}

#[test]
fn no_number_at_all() {
    println!(
        "@@no_number_at_all@@{}@@end@@",
        refusal(r#"chip_period = "8 ns""#, r#"chip_period = "fast""#)
    );
}

#[test]
fn a_negative_time() {
    println!(
        "@@a_negative_time@@{}@@end@@",
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "-14 ns""#)
    );
}

#[test]
fn a_chip_period_of_zero() {
    println!(
        "@@a_chip_period_of_zero@@{}@@end@@",
        refusal(r#"chip_period = "8 ns""#, r#"chip_period = "0 ns""#)
    );
}

#[test]
fn a_quantity_beyond_any_number() {
    println!(
        "@@a_quantity_beyond_any_number@@{}@@end@@",
        refusal(r#"integration = "20 us""#, r#"integration = "1e300 h""#)
    );
}

#[test]
fn an_unknown_key_with_a_near_one() {
    println!(
        "@@an_unknown_key_with_a_near_one@@{}@@end@@",
        refusal(r#"dead_time = "14 ns""#, r#"deadtime = "14 ns""#)
    );
}

#[test]
fn an_unknown_key_with_none_near() {
    println!(
        "@@an_unknown_key_with_none_near@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
colour = "red""#
        )
    );
}

#[test]
fn an_unknown_table() {
    println!(
        "@@an_unknown_table@@{}@@end@@",
        refusal(
            "[scan]",
            r#"[skan]
[scan]"#
        )
    );
}

#[test]
fn a_required_key_that_is_missing() {
    println!(
        "@@a_required_key_that_is_missing@@{}@@end@@",
        refusal(
            r#"mean_power = "20 pW"
"#,
            ""
        )
    );
}

#[test]
fn a_required_table_that_is_missing() {
    println!(
        "@@a_required_table_that_is_missing@@{}@@end@@",
        refusal(
            r#"[scan]
integration = "20 us"
"#,
            ""
        )
    );
}

#[test]
fn no_detector() {
    println!(
        "@@no_detector@@{}@@end@@",
        refusal(
            r#"[[detector]]
name = "spad"
reference = "laser"
dead_time = "14 ns"

[[path]]
source = "laser"
detector = "spad"
distance = "3.2 m"
"#,
            ""
        )
    );
}

#[test]
fn a_reference_to_no_source() {
    println!(
        "@@a_reference_to_no_source@@{}@@end@@",
        refusal(r#"reference = "laser""#, r#"reference = "lazer""#)
    );
}

#[test]
fn a_path_to_no_detector() {
    println!(
        "@@a_path_to_no_detector@@{}@@end@@",
        refusal(r#"detector = "spad""#, r#"detector = "camera""#)
    );
}

#[test]
fn two_detectors_of_one_name() {
    println!(
        "@@two_detectors_of_one_name@@{}@@end@@",
        refusal(
            "[[path]]",
            r#"[[detector]]
name = "spad"
reference = "laser"

[[path]]"#
        )
    );
}

#[test]
fn distance_and_delay() {
    println!(
        "@@distance_and_delay@@{}@@end@@",
        refusal(
            r#"distance = "3.2 m""#,
            r#"distance = "3.2 m"
delay = "21 ns""#
        )
    );
}

#[test]
fn neither_distance_nor_delay() {
    println!(
        "@@neither_distance_nor_delay@@{}@@end@@",
        refusal(
            r#"distance = "3.2 m"
"#,
            ""
        )
    );
}

#[test]
fn samples_per_chip_not_a_power_of_two() {
    println!(
        "@@samples_per_chip_not_a_power_of_two@@{}@@end@@",
        refusal("samples_per_chip = 8", "samples_per_chip = 12")
    );
}

#[test]
fn samples_per_chip_too_large() {
    println!(
        "@@samples_per_chip_too_large@@{}@@end@@",
        refusal("samples_per_chip = 8", "samples_per_chip = 128")
    );
}

#[test]
fn an_extinction_ratio_below_one() {
    println!(
        "@@an_extinction_ratio_below_one@@{}@@end@@",
        refusal(
            r#"mean_power = "20 pW""#,
            r#"mean_power = "20 pW"
extinction_ratio = 0.1"#
        )
    );
}

#[test]
fn a_probability_above_one() {
    println!(
        "@@a_probability_above_one@@{}@@end@@",
        refusal(
            r#"dead_time = "14 ns""#,
            r#"dead_time = "14 ns"
photon_detection_probability = 31"#
        )
    );
}

#[test]
fn a_probability_that_is_nan() {
    println!(
        "@@a_probability_that_is_nan@@{}@@end@@",
        refusal(
            r#"dead_time = "14 ns""#,
            r#"dead_time = "14 ns"
photon_detection_probability = nan"#
        )
    );
}

#[test]
fn afterpulsing_without_its_time_constant() {
    println!(
        "@@afterpulsing_without_its_time_constant@@{}@@end@@",
        refusal(
            r#"dead_time = "14 ns""#,
            r#"dead_time = "14 ns"
afterpulsing = { probability = 0.137 }"#
        )
    );
}

#[test]
fn afterpulsing_that_never_dies_out() {
    println!(
        "@@afterpulsing_that_never_dies_out@@{}@@end@@",
        refusal(
            r#"dead_time = "14 ns""#,
            r#"dead_time = "14 ns"
afterpulsing = { probability = 1.0, time_constant = "5 ns" }"#
        )
    );
}

#[test]
fn an_integration_time_of_no_chip() {
    println!(
        "@@an_integration_time_of_no_chip@@{}@@end@@",
        refusal(r#"integration = "20 us""#, r#"integration = "3 ns""#)
    );
}

#[test]
fn an_integration_time_of_ages() {
    println!(
        "@@an_integration_time_of_ages@@{}@@end@@",
        refusal(r#"integration = "20 us""#, r#"integration = "1e12 h""#)
    );
}

#[test]
fn steps_that_are_neither_word_nor_window() {
    println!(
        "@@steps_that_are_neither_word_nor_window@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = "some""#
        )
    );
}

#[test]
fn steps_that_mix_two_windows() {
    println!(
        "@@steps_that_mix_two_windows@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = { first = 0, halfwidth = 3 }"#
        )
    );
}

#[test]
fn more_steps_than_the_period_has() {
    println!(
        "@@more_steps_than_the_period_has@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = { first = 0, count = 249 }"#
        )
    );
}

#[test]
fn a_window_wider_than_the_period() {
    println!(
        "@@a_window_wider_than_the_period@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = { around = "3.2 m", halfwidth = 124 }"#
        )
    );
}

#[test]
fn a_first_step_outside_the_period() {
    println!(
        "@@a_first_step_outside_the_period@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = { first = 248, count = 2 }"#
        )
    );
}

#[test]
fn a_window_around_a_power() {
    println!(
        "@@a_window_around_a_power@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = { around = "3 pW", halfwidth = 1 }"#
        )
    );
}

#[test]
fn more_parallel_steps_than_the_scan_has() {
    println!(
        "@@more_parallel_steps_than_the_scan_has@@{}@@end@@",
        refusal(
            r#"integration = "20 us""#,
            r#"integration = "20 us"
steps = { first = 0, count = 4 }

[hardware]
parallel = 8"#
        )
    );
}

#[test]
fn an_unknown_target() {
    println!(
        "@@an_unknown_target@@{}@@end@@",
        refusal(
            "[scan]",
            r#"[hardware]
target = "ecp5-25k"

[scan]"#
        )
    );
}

#[test]
fn detectors_with_references_of_different_length() {
    println!(
        "@@detectors_with_references_of_different_length@@{}@@end@@",
        refusal(
            "[[path]]",
            r#"[[source]]
name = "other"
code = { family = "square" }
wavelength = "783 nm"
mean_power = "20 pW"

[[detector]]
name = "second"
reference = "other"

[[path]]"#
        )
    );
}

#[test]
fn an_unknown_family() {
    println!(
        "@@an_unknown_family@@{}@@end@@",
        refusal(r#"family = "gold""#, r#"family = "golden""#)
    );
}

#[test]
fn a_degree_without_preferred_pairs() {
    println!(
        "@@a_degree_without_preferred_pairs@@{}@@end@@",
        refusal("degree = 5", "degree = 8")
    );
}

#[test]
fn a_degree_out_of_range() {
    println!(
        "@@a_degree_out_of_range@@{}@@end@@",
        refusal("degree = 5", "degree = 25")
    );
}

#[test]
fn a_code_without_its_degree() {
    println!(
        "@@a_code_without_its_degree@@{}@@end@@",
        refusal(
            r#"{ family = "gold", degree = 5 }"#,
            r#"{ family = "gold" }"#
        )
    );
}

#[test]
fn a_key_of_another_family() {
    println!(
        "@@a_key_of_another_family@@{}@@end@@",
        refusal(
            r#"{ family = "gold", degree = 5 }"#,
            r#"{ family = "square", degree = 5 }"#
        )
    );
}

#[test]
fn an_index_outside_the_set() {
    println!(
        "@@an_index_outside_the_set@@{}@@end@@",
        refusal("degree = 5 }", "degree = 5, index = 31 }")
    );
}

#[test]
fn a_pair_that_is_not_preferred() {
    println!(
        "@@a_pair_that_is_not_preferred@@{}@@end@@",
        refusal(
            "degree = 5 }",
            "degree = 5, polynomials = [[5, 2, 0], [5, 3, 0]] }"
        )
    );
}

#[test]
fn a_polynomial_that_is_not_primitive() {
    println!(
        "@@a_polynomial_that_is_not_primitive@@{}@@end@@",
        refusal(
            "degree = 5 }",
            "degree = 5, polynomials = [[5, 1, 0], [5, 2, 0]] }"
        )
    );
}

#[test]
fn exponents_in_the_wrong_order() {
    println!(
        "@@exponents_in_the_wrong_order@@{}@@end@@",
        refusal(
            "degree = 5 }",
            "degree = 5, polynomials = [[0, 2, 5], [5, 2, 0]] }"
        )
    );
}

#[test]
fn one_polynomial_for_two_registers() {
    println!(
        "@@one_polynomial_for_two_registers@@{}@@end@@",
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 2, 0]] }")
    );
}

#[test]
fn a_seed_of_zeros() {
    println!(
        "@@a_seed_of_zeros@@{}@@end@@",
        refusal(
            "degree = 5 }",
            r#"degree = 5, seeds = ["00000", "11111"] }"#
        )
    );
}

#[test]
fn a_seed_of_the_wrong_length() {
    println!(
        "@@a_seed_of_the_wrong_length@@{}@@end@@",
        refusal("degree = 5 }", r#"degree = 5, seeds = ["1111", "11111"] }"#)
    );
}

#[test]
fn an_interleaving_depth_out_of_range() {
    println!(
        "@@an_interleaving_depth_out_of_range@@{}@@end@@",
        refusal("degree = 5 }", "degree = 5, interleave = 9 }")
    );
}

#[test]
fn chips_that_are_all_alike() {
    println!(
        "@@chips_that_are_all_alike@@{}@@end@@",
        refusal(
            r#"{ family = "gold", degree = 5 }"#,
            r#"{ family = "chips", chips = "1111" }"#
        )
    );
}

#[test]
fn chips_that_are_not_binary() {
    println!(
        "@@chips_that_are_not_binary@@{}@@end@@",
        refusal(
            r#"{ family = "gold", degree = 5 }"#,
            r#"{ family = "chips", chips = "0120" }"#
        )
    );
}

#[test]
fn a_string_where_a_table_is_needed() {
    println!(
        "@@a_string_where_a_table_is_needed@@{}@@end@@",
        refusal(r#"{ family = "gold", degree = 5 }"#, r#""gold""#)
    );
}

#[test]
fn text_that_is_not_toml() {
    println!(
        "@@text_that_is_not_toml@@{}@@end@@",
        refusal(r#"name = "laser""#, "name = laser")
    );
}

#[test]
fn a_key_given_twice() {
    println!(
        "@@a_key_given_twice@@{}@@end@@",
        refusal(
            r#"dead_time = "14 ns""#,
            r#"dead_time = "14 ns"
dead_time = "15 ns""#
        )
    );
}

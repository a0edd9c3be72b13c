//! Every malformed scene is refused with where, what, and what would be right.

use goldtof::scene::{SceneErrors, load, parse};

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
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "14""#),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: "14" has no unit; write for example "14 ns"
      14 | dead_time = "14"
         |             ^^^^
    "#
    );
}

#[test]
fn a_bare_number_where_a_unit_is_needed() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = 14"),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: 14 has no unit; write for example "14 ns"
      14 | dead_time = 14
         |             ^^
    "#
    );
}

#[test]
fn a_time_where_a_distance_is_needed() {
    insta::assert_snapshot!(
        refusal(r#"distance = "3.2 m""#, r#"distance = "3 ns""#),
        @r#"
    scenes/x.toml:19:12: path.distance: "3 ns" is a time, but a distance is needed; write for example "3.2 m"
      19 | distance = "3 ns"
         |            ^^^^^^
    "#
    );
}

#[test]
fn an_unknown_unit() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "14 nsec""#),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: "14 nsec" has the unknown unit "nsec"; a time takes fs, ps, ns, us, ms, s, min or h
      14 | dead_time = "14 nsec"
         |             ^^^^^^^^^
    "#
    );
}

#[test]
fn no_number_at_all() {
    insta::assert_snapshot!(
        refusal(r#"chip_period = "8 ns""#, r#"chip_period = "fast""#),
        @r#"
    scenes/x.toml:2:15: clock.chip_period: "fast" is not a number with a unit; write for example "8 ns"
      2 | chip_period = "fast"
        |               ^^^^^^
    "#
    );
}

#[test]
fn a_negative_time() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "-14 ns""#),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: "-14 ns" must be 0 or more; write for example "14 ns"
      14 | dead_time = "-14 ns"
         |             ^^^^^^^^
    "#
    );
}

#[test]
fn a_chip_period_of_zero() {
    insta::assert_snapshot!(
        refusal(r#"chip_period = "8 ns""#, r#"chip_period = "0 ns""#),
        @r#"
    scenes/x.toml:2:15: clock.chip_period: "0 ns" must be greater than 0; write for example "8 ns"
      2 | chip_period = "0 ns"
        |               ^^^^^^
    "#
    );
}

#[test]
fn a_quantity_beyond_any_number() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, r#"integration = "1e300 h""#),
        @r#"
    scenes/x.toml:22:15: scan.integration: "1e300 h" is too large; write for example "100 us"
      22 | integration = "1e300 h"
         |               ^^^^^^^^^
    "#
    );
}

#[test]
fn an_unknown_key_with_a_near_one() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"deadtime = "14 ns""#),
        @r#"
    scenes/x.toml:14:1: detector.deadtime: `detector` has no key `deadtime`; did you mean `dead_time`?
      14 | deadtime = "14 ns"
         | ^^^^^^^^
    "#
    );
}

#[test]
fn an_unknown_key_with_none_near() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\ncolour = \"red\""),
        @r#"
    scenes/x.toml:23:1: scan.colour: `scan` has no key `colour`; it takes steps or integration
      23 | colour = "red"
         | ^^^^^^
    "#
    );
}

#[test]
fn an_unknown_table() {
    insta::assert_snapshot!(
        refusal("[scan]", "[skan]\n[scan]"),
        @r#"
    scenes/x.toml:21:2: skan: a scene has no key `skan`; did you mean `scan`?
      21 | [skan]
         |  ^^^^
    "#
    );
}

#[test]
fn a_required_key_that_is_missing() {
    insta::assert_snapshot!(
        refusal("mean_power = \"20 pW\"\n", ""),
        @r#"
    scenes/x.toml:5:1: source: `mean_power` is missing; write for example mean_power = "4 pW"
      5 | [[source]]
        | ^^^^^^^^^^
    "#
    );
}

#[test]
fn a_required_table_that_is_missing() {
    insta::assert_snapshot!(
        refusal("[scan]\nintegration = \"20 us\"\n", ""),
        @r#"
    scenes/x.toml:1:1: the table [scan] is missing; a scene needs it
      1 | [clock]
        | ^
    "#
    );
}

#[test]
fn no_detector() {
    insta::assert_snapshot!(
        refusal("[[detector]]\nname = \"spad\"\nreference = \"laser\"\ndead_time = \"14 ns\"\n\n[[path]]\nsource = \"laser\"\ndetector = \"spad\"\ndistance = \"3.2 m\"\n", ""),
        @r#"
    scenes/x.toml:1:1: the table [[detector]] is missing; a scene needs it
      1 | [clock]
        | ^
    "#
    );
}

#[test]
fn a_reference_to_no_source() {
    insta::assert_snapshot!(
        refusal(r#"reference = "laser""#, r#"reference = "lazer""#),
        @r#"
    scenes/x.toml:13:13: detector.reference: no source is named "lazer"; did you mean "laser"?
      13 | reference = "lazer"
         |             ^^^^^^^
    "#
    );
}

#[test]
fn a_path_to_no_detector() {
    insta::assert_snapshot!(
        refusal(r#"detector = "spad""#, r#"detector = "camera""#),
        @r#"
    scenes/x.toml:18:12: path.detector: no detector is named "camera"; there is "spad"
      18 | detector = "camera"
         |            ^^^^^^^^
    "#
    );
}

#[test]
fn two_detectors_of_one_name() {
    insta::assert_snapshot!(
        refusal("[[path]]", "[[detector]]\nname = \"spad\"\nreference = \"laser\"\n\n[[path]]"),
        @r#"
    scenes/x.toml:17:8: detector.name: "spad" already names another detector; choose another name
      17 | name = "spad"
         |        ^^^^^^
    "#
    );
}

#[test]
fn distance_and_delay() {
    insta::assert_snapshot!(
        refusal(r#"distance = "3.2 m""#, "distance = \"3.2 m\"\ndelay = \"21 ns\""),
        @r#"
    scenes/x.toml:20:9: path.delay: the path has a distance already; give one of `distance` and `delay`
      20 | delay = "21 ns"
         |         ^^^^^^^
    "#
    );
}

#[test]
fn neither_distance_nor_delay() {
    insta::assert_snapshot!(
        refusal("distance = \"3.2 m\"\n", ""),
        @r#"
    scenes/x.toml:16:1: path: neither `distance` nor `delay` is given; write for example distance = "3.2 m"
      16 | [[path]]
         | ^^^^^^^^
    "#
    );
}

#[test]
fn samples_per_chip_not_a_power_of_two() {
    insta::assert_snapshot!(
        refusal("samples_per_chip = 8", "samples_per_chip = 12"),
        @r#"
    scenes/x.toml:3:20: clock.samples_per_chip: 12 is not a power of two; use 8 or 16
      3 | samples_per_chip = 12
        |                    ^^
    "#
    );
}

#[test]
fn samples_per_chip_too_large() {
    insta::assert_snapshot!(
        refusal("samples_per_chip = 8", "samples_per_chip = 128"),
        @r#"
    scenes/x.toml:3:20: clock.samples_per_chip: 128 is outside 1..=64
      3 | samples_per_chip = 128
        |                    ^^^
    "#
    );
}

#[test]
fn an_extinction_ratio_below_one() {
    insta::assert_snapshot!(
        refusal(r#"mean_power = "20 pW""#, "mean_power = \"20 pW\"\nextinction_ratio = 0.1"),
        @r#"
    scenes/x.toml:10:20: source.extinction_ratio: 0.1 is not a ratio of 1 or more; write for example 10, or "inf"
      10 | extinction_ratio = 0.1
         |                    ^^^
    "#
    );
}

#[test]
fn a_probability_above_one() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nphoton_detection_probability = 31"),
        @r#"
    scenes/x.toml:15:32: detector.photon_detection_probability: 31 is not a number from 0 to 1; write for example 0.31
      15 | photon_detection_probability = 31
         |                                ^^
    "#
    );
}

#[test]
fn a_probability_that_is_nan() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nphoton_detection_probability = nan"),
        @r#"
    scenes/x.toml:15:32: detector.photon_detection_probability: nan is not a number from 0 to 1; write for example 0.31
      15 | photon_detection_probability = nan
         |                                ^^^
    "#
    );
}

#[test]
fn afterpulsing_without_its_time_constant() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nafterpulsing = { probability = 0.137 }"),
        @r#"
    scenes/x.toml:15:16: detector.afterpulsing: `time_constant` is missing; write for example time_constant = "5 ns"
      15 | afterpulsing = { probability = 0.137 }
         |                ^^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn afterpulsing_that_never_dies_out() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nafterpulsing = { probability = 1.0, time_constant = \"5 ns\" }"),
        @r#"
    scenes/x.toml:15:32: detector.afterpulsing.probability: 1.0 is not a number from 0 to less than 1; write for example 0.137
      15 | afterpulsing = { probability = 1.0, time_constant = "5 ns" }
         |                                ^^^
    "#
    );
}

#[test]
fn an_integration_time_of_no_chip() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, r#"integration = "3 ns""#),
        @r#"
    scenes/x.toml:22:15: scan.integration: the integration time rounds to 0 chips of 8 ns; integrate for at least one chip
      22 | integration = "3 ns"
         |               ^^^^^^
    "#
    );
}

#[test]
fn an_integration_time_of_ages() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, r#"integration = "1e12 h""#),
        @r#"
    scenes/x.toml:22:15: scan.integration: 248 phase steps of this length are more than 2^60 chips; integrate for less
      22 | integration = "1e12 h"
         |               ^^^^^^^^
    "#
    );
}

#[test]
fn steps_that_are_neither_word_nor_window() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = \"some\""),
        @r#"
    scenes/x.toml:23:9: scan.steps: "some" is no choice of phase steps; write "all", { first = 0, count = 64 } or { around = "3.2 m", halfwidth = 16 }
      23 | steps = "some"
         |         ^^^^^^
    "#
    );
}

#[test]
fn steps_that_mix_two_windows() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 0, halfwidth = 3 }"),
        @r#"
    scenes/x.toml:23:9: scan.steps: these keys do not choose phase steps; write "all", { first = 0, count = 64 } or { around = "3.2 m", halfwidth = 16 }
      23 | steps = { first = 0, halfwidth = 3 }
         |         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn more_steps_than_the_period_has() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 0, count = 249 }"),
        @r#"
    scenes/x.toml:23:30: scan.steps.count: 249 phase steps are more than the 248 of a code period; scan fewer, or "all"
      23 | steps = { first = 0, count = 249 }
         |                              ^^^
    "#
    );
}

#[test]
fn a_window_wider_than_the_period() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { around = \"3.2 m\", halfwidth = 124 }"),
        @r#"
    scenes/x.toml:23:41: scan.steps.halfwidth: 249 phase steps are more than the 248 of a code period; scan fewer, or "all"
      23 | steps = { around = "3.2 m", halfwidth = 124 }
         |                                         ^^^
    "#
    );
}

#[test]
fn a_first_step_outside_the_period() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 248, count = 2 }"),
        @r#"
    scenes/x.toml:23:19: scan.steps.first: 248 is outside 0..248, the phase steps of a period
      23 | steps = { first = 248, count = 2 }
         |                   ^^^
    "#
    );
}

#[test]
fn a_window_around_a_power() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { around = \"3 pW\", halfwidth = 1 }"),
        @r#"
    scenes/x.toml:23:20: scan.steps.around: "3 pW" is a power, but a distance is needed; write for example "3.2 m"
      23 | steps = { around = "3 pW", halfwidth = 1 }
         |                    ^^^^^^
    "#
    );
}

#[test]
fn more_parallel_steps_than_the_scan_has() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 0, count = 4 }\n\n[hardware]\nparallel = 8"),
        @r#"
    scenes/x.toml:26:12: hardware.parallel: 8 phase steps at once are more than the 4 of the scan; use 4 or less, or scan more steps
      26 | parallel = 8
         |            ^
    "#
    );
}

#[test]
fn an_unknown_target() {
    insta::assert_snapshot!(
        refusal("[scan]", "[hardware]\ntarget = \"ecp5-25k\"\n\n[scan]"),
        @r#"
    scenes/x.toml:22:10: hardware.target: "ecp5-25k" is not known; did you mean "ecp5-25k-6"?
      22 | target = "ecp5-25k"
         |          ^^^^^^^^^^
    "#
    );
}

#[test]
fn detectors_with_references_of_different_length() {
    insta::assert_snapshot!(
        refusal("[[path]]", "[[source]]\nname = \"other\"\ncode = { family = \"square\" }\nwavelength = \"783 nm\"\nmean_power = \"20 pW\"\n\n[[detector]]\nname = \"second\"\nreference = \"other\"\n\n[[path]]"),
        @r#"
    scenes/x.toml:24:13: detector.reference: this detector's reference code is 2 chips long, the first detector's 31; detectors are stepped together, so give them codes of one length
      24 | reference = "other"
         |             ^^^^^^^
    "#
    );
}

#[test]
fn an_unknown_family() {
    insta::assert_snapshot!(
        refusal(r#"family = "gold""#, r#"family = "golden""#),
        @r#"
    scenes/x.toml:7:19: source.code.family: "golden" is not known; did you mean "gold"?
      7 | code = { family = "golden", degree = 5 }
        |                   ^^^^^^^^
    "#
    );
}

#[test]
fn a_degree_without_preferred_pairs() {
    insta::assert_snapshot!(
        refusal("degree = 5", "degree = 8"),
        @r#"
    scenes/x.toml:7:36: source.code.degree: degree 8 has no preferred pair, because 4 divides it; use degree 7 or 9, or set allow_non_preferred = true
      7 | code = { family = "gold", degree = 8 }
        |                                    ^
    "#
    );
}

#[test]
fn a_degree_out_of_range() {
    insta::assert_snapshot!(
        refusal("degree = 5", "degree = 25"),
        @r#"
    scenes/x.toml:7:36: source.code.degree: degree 25 is outside 3..=20
      7 | code = { family = "gold", degree = 25 }
        |                                    ^^
    "#
    );
}

#[test]
fn a_code_without_its_degree() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "gold" }"#),
        @r#"
    scenes/x.toml:7:8: source.code: family "gold" needs `degree`, for example degree = 11
      7 | code = { family = "gold" }
        |        ^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_key_of_another_family() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "square", degree = 5 }"#),
        @r#"
    scenes/x.toml:7:38: source.code.degree: `degree` does not belong to family "square"; leave it out
      7 | code = { family = "square", degree = 5 }
        |                                      ^
    "#
    );
}

#[test]
fn an_index_outside_the_set() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, index = 31 }"),
        @r#"
    scenes/x.toml:7:47: source.code.index: index 31 is outside -2..=30 (-2 is u, -1 is v, i is u XOR v advanced by i)
      7 | code = { family = "gold", degree = 5, index = 31 }
        |                                               ^^
    "#
    );
}

#[test]
fn a_pair_that_is_not_preferred() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 2, 0], [5, 3, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: polynomials 5,2,0 and 5,3,0 are not a preferred pair: their cross-correlation takes 6 different values between -9 and 11, not just -9, -1 and 7; take another pair, or set allow_non_preferred = true
      7 | code = { family = "gold", degree = 5, polynomials = [[5, 2, 0], [5, 3, 0]] }
        |                                                     ^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_polynomial_that_is_not_primitive() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 1, 0], [5, 2, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: polynomial 5,1,0 is not primitive; 5,2,0 is
      7 | code = { family = "gold", degree = 5, polynomials = [[5, 1, 0], [5, 2, 0]] }
        |                                                     ^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn exponents_in_the_wrong_order() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[0, 2, 5], [5, 2, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: polynomial 0,2,5 does not list exponents in descending order from the degree 5 down to 0, as 5,2,0 does
      7 | code = { family = "gold", degree = 5, polynomials = [[0, 2, 5], [5, 2, 0]] }
        |                                                     ^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn one_polynomial_for_two_registers() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 2, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: family "gold" takes 2 polynomials, not 1
      7 | code = { family = "gold", degree = 5, polynomials = [[5, 2, 0]] }
        |                                                     ^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_seed_of_zeros() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", r#"degree = 5, seeds = ["00000", "11111"] }"#),
        @r#"
    scenes/x.toml:7:47: source.code.seeds: seed "00000" is all zero, and an LFSR never leaves that state; set at least one 1
      7 | code = { family = "gold", degree = 5, seeds = ["00000", "11111"] }
        |                                               ^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_seed_of_the_wrong_length() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", r#"degree = 5, seeds = ["1111", "11111"] }"#),
        @r#"
    scenes/x.toml:7:47: source.code.seeds: seed "1111" is not 5 binary digits, first chip first, as "11111" is
      7 | code = { family = "gold", degree = 5, seeds = ["1111", "11111"] }
        |                                               ^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn an_interleaving_depth_out_of_range() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, interleave = 9 }"),
        @r#"
    scenes/x.toml:7:52: source.code.interleave: interleave 9 is outside 0..=8
      7 | code = { family = "gold", degree = 5, interleave = 9 }
        |                                                    ^
    "#
    );
}

#[test]
fn chips_that_are_all_alike() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "chips", chips = "1111" }"#),
        @r#"
    scenes/x.toml:7:36: source.code.chips: all chips of this code are 1: it carries no time; use a code with both 0 and 1
      7 | code = { family = "chips", chips = "1111" }
        |                                    ^^^^^^
    "#
    );
}

#[test]
fn chips_that_are_not_binary() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "chips", chips = "0120" }"#),
        @r#"
    scenes/x.toml:7:36: source.code.chips: chips may hold only the digits 0 and 1, as "0110" does, and at least one
      7 | code = { family = "chips", chips = "0120" }
        |                                    ^^^^^^
    "#
    );
}

#[test]
fn a_string_where_a_table_is_needed() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#""gold""#),
        @r#"
    scenes/x.toml:7:8: source.code: "gold" is a string, but a table is needed; write for example { family = "gold", degree = 11 }
      7 | code = "gold"
        |        ^^^^^^
    "#
    );
}

#[test]
fn text_that_is_not_toml() {
    insta::assert_snapshot!(
        refusal(r#"name = "laser""#, "name = laser"),
        @r#"
    scenes/x.toml:6:8: not TOML: string values must be quoted, expected literal string
      6 | name = laser
        |        ^^^^^
    "#
    );
}

#[test]
fn a_key_given_twice() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\ndead_time = \"15 ns\""),
        @r#"
    scenes/x.toml:15:1: not TOML: duplicate key
      15 | dead_time = "15 ns"
         | ^^^^^^^^^
    "#
    );
}

#[test]
fn all_errors_are_reported_together_in_the_order_of_the_file() {
    let scene = SCENE
        .replace("783 nm", "783")
        .replace("dead_time", "dead_tme")
        .replace("[clock]", "[clock]\nchip_perod = 3");
    let Err(SceneErrors::Invalid(errors)) = parse("scenes/x.toml", &scene) else {
        panic!("accepted:\n{scene}");
    };
    let places: Vec<(usize, usize)> = errors.iter().map(|e| (e.line, e.column)).collect();
    assert_eq!(places, [(2, 1), (9, 14), (15, 1)]);
}

#[test]
fn a_wrong_source_causes_no_further_errors_elsewhere() {
    let scene = SCENE.replace("degree = 5", "degree = 8");
    let Err(SceneErrors::Invalid(errors)) = parse("scenes/x.toml", &scene) else {
        panic!("accepted:\n{scene}");
    };
    assert_eq!(errors.len(), 1, "{errors:?}");
}

#[test]
fn columns_count_characters_and_tabs_keep_the_caret_in_place() {
    let scene = SCENE
        .replace("dead_time", "\tdead_time")
        .replace("14 ns", "14 \u{b5}");
    let Err(SceneErrors::Invalid(errors)) = parse("scenes/x.toml", &scene) else {
        panic!("accepted:\n{scene}");
    };
    assert_eq!((errors[0].column, errors[0].marked), (14, 6));
    assert!(
        errors[0]
            .to_string()
            .ends_with(&format!("| \t{}^^^^^^", " ".repeat(12)))
    );
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = load(std::path::Path::new("scenes/absent.toml")).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("scenes/absent.toml: cannot read the scene: "),
        "{text}"
    );
}
